"""The open texts and what is known of them. One per server; no threads, no protocol."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from olp.core import source
from olp.core.memory_limit import TextCache
from olp.servers.language.analysis import Analysis, analyse
from olp.servers.language.document import OpenDocument, TextChange
from olp.servers.language.findings import moved
from olp.servers.language.settings import EditorSettings


class ProgramService:
    """`documents` and `analyses` by path; an analysis may be of an earlier edition: see `is_current`."""

    def __init__(self) -> None:
        self.settings = EditorSettings()
        self.documents: dict[str, OpenDocument] = {}
        self.analyses: dict[str, Analysis] = {}
        self._memories: dict[str, TextCache] = {}

    # --- texts ------------------------------------------------------------------------------------------

    def open(self, path: str, text: str, language: str = "", version: int = 0) -> OpenDocument:
        """From now on the text of `path` is the editor's."""
        document = OpenDocument(path, text, language, version)
        self.documents[path] = document
        self._memories[path] = TextCache()
        self.analyses.pop(path, None)
        self._overlay(document)
        return document

    def change(self, path: str, changes: list[TextChange | str], version: int) -> bool:
        """Edits in their order; a text alone replaces all. False where no such text is open."""
        document = self.documents.get(path)
        if document is None:
            return False
        for change in changes:
            if isinstance(change, str):
                document.replace(change)
            else:
                document.change(change)
        document.version = version
        return True

    def close(self, path: str) -> bool:
        """The file on the disk counts again. False where no such text is open."""
        source.drop(path)
        self.analyses.pop(path, None)
        self._memories.pop(path, None)
        return self.documents.pop(path, None) is not None

    # --- what is known of them --------------------------------------------------------------------------

    def configure(self, settings: EditorSettings) -> None:
        """Everything is timed anew."""
        self.settings = settings
        self.forget()

    def forget(self, path: str | None = None) -> None:
        """What is known of `path`, of everything when None, is out of date."""
        for known in [path] if path is not None else list(self.analyses):
            if known in self.analyses:
                self.analyses[known] = replace(self.analyses[known], edition=-1)

    def is_current(self, path: str) -> bool:
        document, analysis = self.documents.get(path), self.analyses.get(path)
        return document is not None and analysis is not None and analysis.edition == document.edition

    def current(
        self, path: str, wanted: Callable[[], bool] = lambda: True, whole: bool = True
    ) -> Analysis | None:
        """What is known of the text as it is now; None where none is open. Raises SupersededError like `analyse`.

        `whole` False: a program that goes on and on may be `partial`.
        """
        document = self.documents.get(path)
        if document is None:
            return None
        before = self.analyses.get(path)
        if before is not None and self.is_current(path) and not (whole and before.partial):
            return before
        self._overlay(document)
        analysis = analyse(document, self.settings, wanted, self._memories[path], whole)
        if before is not None:
            # Until the rules have run again, what they found stays where it was.
            analysis = replace(analysis, lint=moved(before.lint, document.splices))
        document.splices.clear()
        self.analyses[path] = analysis
        return analysis

    def dependents(self, path: str) -> list[str]:
        """The other open texts that a change of `path` may concern: they need it, or miss something of its folder."""
        folder = Path(path).parent
        return [
            other
            for other, analysis in self.analyses.items()
            if other != path
            and (path in analysis.needs or (Path(other).parent == folder and analysis.misses))
        ]

    def _overlay(self, document: OpenDocument) -> None:
        if Path(document.path).is_absolute():
            source.put(document.path, document.raw)
