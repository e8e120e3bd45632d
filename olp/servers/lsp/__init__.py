"""The language server: `olp.servers.language` spoken in the Language Server Protocol, and nothing else."""
