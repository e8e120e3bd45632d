"""The vendor-neutral program: expressions, statements, moves, points."""
