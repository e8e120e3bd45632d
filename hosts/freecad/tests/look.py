"""Runs inside the graphical FreeCAD: the workbench is used as a person would, and what went wrong is written down."""

import os
import sys
import traceback

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

OUT = os.environ["OLP_LOOK"]
SAMPLE = os.path.join(os.environ["OLP_SAMPLES"], "krl", "handling.src")
held = {}


def wait(milliseconds):
    loop = QtCore.QEventLoop()
    QtCore.QTimer.singleShot(milliseconds, loop.quit)
    loop.exec_()


def shoot(name):
    wait(400)
    # The widget's own picture has no 3D view in it.
    box = FreeCADGui.getMainWindow().frameGeometry()
    picture = QtGui.QApplication.primaryScreen().grabWindow(0, box.x(), box.y(), box.width(), box.height())
    picture.save(os.path.join(OUT, name))


def look():
    import olp_freecad
    from olp_freecad import ask, shapes
    from olp_freecad.gui import panel

    window = FreeCADGui.getMainWindow()
    window.setGeometry(0, 0, 1300, 860)
    for dock in window.findChildren(QtGui.QDockWidget):
        dock.setVisible(dock.objectName() == "Combo View")
    ask.set_setting("Robot", os.environ["OLP_ROBOT"])
    FreeCADGui.activateWorkbench("OlpWorkbench")
    held["workbench"] = FreeCADGui.activeWorkbench().__class__.__name__ == "OlpWorkbench"
    bar = [one for one in window.findChildren(QtGui.QToolBar) if one.objectName() == "olp"]
    held["tool bar"] = len(bar) == 1 and bar[0].isVisible() and len(bar[0].actions()) == 9
    held["icons"] = all(not one.icon().isNull() for one in bar[0].actions())

    # File → Open
    FreeCAD.loadFile(SAMPLE)
    wait(500)
    group = FreeCAD.ActiveDocument.getObject("Program")
    docks = window.findChildren(QtGui.QDockWidget, "olp")
    held["panel opens with the file"] = len(docks) == 1 and docks[0].isVisible()
    dock = docks[0]
    for tree in window.findChildren(QtGui.QTreeWidget):
        tree.expandAll()
    FreeCADGui.activeDocument().activeView().viewDimetric()
    FreeCADGui.SendMsgToActiveView("ViewFit")
    FreeCADGui.activeDocument().activeView().zoomIn()
    held["a row per segment"] = dock.table.rowCount() == len(olp_freecad.segments(group)) > 5
    held["an edge colour per edge"] = len(group.Path.ViewObject.LineColorArray) == len(group.Path.Segment)
    speeds = shapes.edge_values(dock.rows, "speed")
    fastest = max(one["reached_mm_s"] or 0.0 for one in dock.rows)
    held["lines are drawn no faster than they are"] = sorted(speeds)[len(speeds) // 2] <= fastest
    held["no piece is a jump"] = max(speeds) < 3000.0
    held["more than one colour"] = len(set(group.Path.ViewObject.LineColorArray)) > 5
    shoot("freecad.png")

    # From the table to the path, and back.
    row = max(
        (i for i, one in enumerate(dock.rows) if one.get("way")), key=lambda i: dock.rows[i]["duration_s"]
    )
    dock.table.selectRow(row)
    wait(200)
    chosen = FreeCADGui.Selection.getSelectionEx()[0]
    edges = [f"Edge{i}" for i, owner in enumerate(group.Path.Segment, 1) if owner == row]
    held["a row selects its edges"] = sorted(chosen.SubElementNames) == sorted(edges) and bool(edges)
    shoot("freecad-selection.png")
    FreeCADGui.Selection.clearSelection()
    wait(100)
    held["nothing selected, no row"] = not dock.table.selectionModel().selectedRows()
    last = len(group.Path.Segment)
    FreeCADGui.Selection.addSelection(group.Path, f"Edge{last}")
    wait(200)
    rows = [index.row() for index in dock.table.selectionModel().selectedRows()]
    held["an edge selects its row"] = rows == [group.Path.Segment[last - 1]]
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(group.Points[-1])
    wait(200)
    rows = [index.row() for index in dock.table.selectionModel().selectedRows()]
    held["a point selects its rows"] = rows == list(group.Points[-1].Segment)
    FreeCADGui.Selection.clearSelection()

    # Playing
    before = FreeCAD.Placement(group.Tool.Placement)
    dock.slider.setValue(0)
    FreeCADGui.runCommand("Olp_Play")
    wait(900)
    passed = dock.slider.value()
    FreeCADGui.runCommand("Olp_Play")
    held["it plays in real time"] = 600 <= passed <= 2500
    held["the tool moves"] = (group.Tool.Placement.Base - before.Base).Length > 1.0
    held["and stops"] = not dock.timer.isActive()

    FreeCADGui.runCommand("Olp_Colour")
    held["colours by time"] = group.Colour == "time"
    shoot("freecad-time.png")

    # A speed typed into the table
    number = next(i for i, one in enumerate(dock.rows) if f"Line_{one['line']}" in group.PropertiesList)
    name = f"Line_{dock.rows[number]['line']}"
    value = getattr(group, name) * 0.5
    dock.table.item(number, 3).setText(f"{value:g}")
    held["a speed typed in is kept"] = getattr(group, name) == value
    dock.table.item(number, 3).setText("rabbit")
    held["nonsense is not"] = (
        getattr(group, name) == value and "rabbit" not in dock.table.item(number, 3).text()
    )
    held["it is pending"] = len(olp_freecad.pending(group)["speeds"]) == 1

    # Written back, elsewhere, by the command
    from olp_freecad.gui import commands

    said = []
    other = os.path.join(os.environ["FREECAD_USER_HOME"], "handling.src")
    commands.told = lambda text, *more: said.append(text)
    commands.file_to_write = lambda *more: other
    FreeCADGui.runCommand("Olp_WriteBack")
    held["written back"] = os.path.isfile(other) and len(said) == 1 and "line" in said[0]
    held["the table is that of the new file"] = dock.group is not None and dock.rows == olp_freecad.segments(
        group
    )
    FreeCADGui.runCommand("Olp_WriteBack")
    held["nothing more to write"] = "Nothing was changed" in said[-1]
    os.remove(other)
    FreeCADGui.runCommand("Olp_Refresh")
    held["a file that is gone is told"] = "cannot read the file" in said[-1]
    value = getattr(group, name) * 0.5
    olp_freecad.set_speed(group, int(name[5:]), value)

    # Saved and opened again
    path = os.path.join(os.environ["FREECAD_USER_HOME"], "saved.FCStd")
    FreeCAD.ActiveDocument.saveAs(path)
    FreeCAD.closeDocument(FreeCAD.ActiveDocument.Name)
    wait(200)
    held["the panel outlives the document"] = dock.group is None
    FreeCAD.openDocument(path)
    again = FreeCAD.ActiveDocument.getObject("Program")
    held["saved and opened again"] = len(olp_freecad.pending(again)["speeds"]) == 1
    panel.show(again)
    wait(200)


def main():
    try:
        look()
    except Exception:
        held[traceback.format_exc()] = False
    for says, is_held in held.items():
        print(f"{'held' if is_held else 'FAILED'}: screen: {says}", flush=True)
    failed = [says for says, is_held in held.items() if not is_held]
    with open(os.environ["OLP_RESULT"], "w") as file:
        file.write("\n".join(failed) or "held")
    # Nobody is there to answer whether the document shall be saved.
    os._exit(0)


sys.excepthook = lambda *what: held.setdefault("".join(traceback.format_exception(*what)), False)
QtCore.QTimer.singleShot(1500, main)
