"""A sixth author's recordings: a program is one string of intervals; causes cancel or hide (docs/concealed.md)."""
