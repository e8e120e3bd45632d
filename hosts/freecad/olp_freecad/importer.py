"""File → Open and File → Import of robot programs."""

from __future__ import annotations

import FreeCAD

from olp_freecad import program
from olp_freecad.ask import OlpError, setting


def open(filename: str) -> object | None:
    """FreeCAD calls it for File → Open."""
    return _read(filename, None)


def insert(filename: str, docname: str) -> object | None:
    """FreeCAD calls it for File → Import."""
    return _read(filename, FreeCAD.getDocument(docname) if docname in FreeCAD.listDocuments() else None)


def _read(filename: str, document: object | None) -> object | None:
    try:
        group = program.open(filename, robot=setting("Robot"), document=document)
    except OlpError as problem:
        FreeCAD.Console.PrintError(f"{filename}: {problem}\n")
        return None
    for text in group.Messages:
        FreeCAD.Console.PrintWarning(f"{filename}: {text}\n")
    if FreeCAD.GuiUp:
        from olp_freecad.gui import panel

        panel.show(group)
    return group
