"""Three-way merge of programs: combines the changes of two people."""
