"""The tools that an assistant can call: one file each, found by being here."""
