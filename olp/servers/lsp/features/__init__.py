"""What the server can do: one file per feature, each with `register(server, service)`; the listing is the register."""
