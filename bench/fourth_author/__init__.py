"""A fourth author's recordings: other cells, another motion engine, the same sealed truth (docs/concealed.md)."""
