"""The commands of the tool bar."""

from __future__ import annotations

import os
import tempfile

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

import olp_freecad
from olp_freecad import ask
from olp_freecad.gui import panel

_ICONS = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(__file__))), "resources")
_FILES = "Robot programs (*.jbi *.src *.sub *.mod *.modx *.prg *.ls *.script);;All files (*)"
_LANGUAGES = ["inform", "krl", "rapid", "tp", "urscript"]


def current() -> object | None:
    """The program of the selection, else the first one of the document."""
    document = FreeCAD.ActiveDocument
    if document is None:
        return None
    programs = [one for one in document.Objects if type(getattr(one, "Proxy", None)).__name__ == "OlpProgram"]
    chosen = {one.Name for one in FreeCADGui.Selection.getSelection()}
    return next((one for one in programs if one.Name in chosen), programs[0] if programs else None)


class _Command:
    """A command that needs a program, unless `alone`."""

    title = tip = icon = ""
    alone = False

    def GetResources(self) -> dict:  # noqa: N802
        return {"MenuText": self.title, "ToolTip": self.tip, "Pixmap": os.path.join(_ICONS, self.icon)}

    def IsActive(self) -> bool:  # noqa: N802
        return self.alone or current() is not None

    def Activated(self, index: int = 0) -> None:  # noqa: N802
        try:
            self.run(current())
        except ask.OlpError as problem:
            told("\n".join(problem.problems), QtGui.QMessageBox.Warning)

    def run(self, program: object) -> None:
        """What the command does. Raises OlpError, which is shown."""


def told(text: str, icon: object = QtGui.QMessageBox.Information) -> None:
    box = QtGui.QMessageBox(icon, "olp", text, QtGui.QMessageBox.Ok, FreeCADGui.getMainWindow())
    box.exec_()


def file_to_write(title: str, name: str, kinds: str = "All files (*)") -> str:
    return QtGui.QFileDialog.getSaveFileName(FreeCADGui.getMainWindow(), title, name, kinds)[0]


class Open(_Command):
    title, tip, icon = "Open program", "Open a robot program and time it", "open.svg"
    alone = True

    def run(self, program: object) -> None:
        window = FreeCADGui.getMainWindow()
        name = QtGui.QFileDialog.getOpenFileName(window, "Robot program", "", _FILES)[0]
        if name:
            panel.show(olp_freecad.open(name, robot=ask.setting("Robot")))


class Table(_Command):
    title, tip, icon = (
        "Segment table",
        "Every move and wait with its time, and the time line to play",
        "table.svg",
    )

    def run(self, program: object) -> None:
        panel.show(program)


class Play(_Command):
    title, tip, icon = "Play", "Run the tool along the path with olp's times; again to stop", "play.svg"

    def run(self, program: object) -> None:
        panel.show(program).toggle_play()


class Colour(_Command):
    title, tip, icon = "Colour by time or speed", "What the colour of the path shows", "colour.svg"

    def run(self, program: object) -> None:
        program.Colour = "time" if program.Colour == "speed" else "speed"
        panel.show(program).tell()


class Refresh(_Command):
    title, tip, icon = (
        "Read again",
        "Read the file again and time it with the robot of the program",
        "refresh.svg",
    )

    def run(self, program: object) -> None:
        panel.show(olp_freecad.refresh(program))


class WriteBack(_Command):
    title, icon = "Write back", "write.svg"
    tip = "Write moved points and changed speeds into the program; all other lines stay as they are"

    def run(self, program: object) -> None:
        changes = olp_freecad.pending(program)
        count = len(changes["points"]) + len(changes["speeds"])
        if not count:
            told("Nothing was changed. Move a point by its placement, or change a speed in the table.")
            return
        name = file_to_write("Write the program", program.File)
        if name:
            lines = olp_freecad.write_back(program, "" if name == program.File else name)
            panel.show(program)
            told("\n".join(["Lines that changed:", *(f"{os.path.basename(f)}, line {n}" for f, n in lines)]))


class Convert(_Command):
    title, tip, icon = "Convert", "Translate the program into another robot's language", "convert.svg"

    def run(self, program: object) -> None:
        window = FreeCADGui.getMainWindow()
        others = [one for one in _LANGUAGES if one != program.Language]
        language, is_chosen = QtGui.QInputDialog.getItem(window, "olp convert", "Language", others, 0, False)
        folder = is_chosen and QtGui.QFileDialog.getExistingDirectory(window, "Folder for the translation")
        if folder:
            _page("olp convert", olp_freecad.convert(program, language, folder))


class Report(_Command):
    title, tip, icon = "Report", "One HTML page with times, speed, path and text", "report.svg"

    def run(self, program: object) -> None:
        name = os.path.splitext(os.path.basename(program.File))[0] + ".html"
        page = os.path.join(tempfile.mkdtemp(prefix="olp-"), name)
        olp_freecad.report(program, page)
        QtGui.QDesktopServices.openUrl(QtCore.QUrl.fromLocalFile(page))


class Settings(_Command):
    title, tip, icon = "Settings", "The Python that has olp, and the usual robot", "settings.svg"
    alone = True

    def run(self, program: object) -> None:
        window = FreeCADGui.getMainWindow()
        for name, says in (
            ("Python", "Python that has olp (empty: looked for):"),
            ("Robot", "Robot of programs that name none, as in `olp robots` (may be empty):"),
        ):
            line = QtGui.QLineEdit.Normal
            text, is_set = QtGui.QInputDialog.getText(window, "olp", says, line, ask.setting(name))
            if not is_set:
                return
            ask.set_setting(name, text.strip())
        python, root = ask.python_with_olp()
        told(f"olp answers: {ask.command('--version').strip()}\n{python}" + (f"\n{root}" if root else ""))


def _page(title: str, text: str) -> None:
    """A long text to read."""
    dialog = QtGui.QDialog(FreeCADGui.getMainWindow())
    dialog.setWindowTitle(title)
    dialog.resize(900, 500)
    view = QtGui.QPlainTextEdit(text, dialog)
    view.setReadOnly(True)
    view.setFont(QtGui.QFontDatabase.systemFont(QtGui.QFontDatabase.FixedFont))
    QtGui.QVBoxLayout(dialog).addWidget(view)
    dialog.exec_()


def register() -> list:
    """The names of all commands, known to FreeCAD from now on."""
    kinds = (Open, Table, Play, Colour, Refresh, WriteBack, Convert, Report, Settings)
    for kind in kinds:
        FreeCADGui.addCommand(f"Olp_{kind.__name__}", kind())
    return [f"Olp_{kind.__name__}" for kind in kinds]
