"""Physics that a simulation may leave out: one file per effect. docs/physics.md lists them."""

from olp.timing.physics.term import Form, LogTerm, MoveTerm, Stage, Term, TermParameter, load_term, term_names

__all__ = ["Form", "LogTerm", "MoveTerm", "Stage", "Term", "TermParameter", "load_term", "term_names"]

# What these were called in earlier versions.
Parameter = TermParameter
