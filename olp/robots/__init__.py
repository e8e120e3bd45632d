"""The robot library: one TOML file per machine under a folder per maker, and what reads it."""
