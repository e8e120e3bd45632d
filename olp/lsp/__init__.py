"""The language server: `olp.language` spoken in the Language Server Protocol, and nothing else."""
