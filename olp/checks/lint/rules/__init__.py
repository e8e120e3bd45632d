"""All rules, one per file."""
