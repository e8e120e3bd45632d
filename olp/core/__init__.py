"""What everything rests on: diagnostics, sources, units, files, registries."""
