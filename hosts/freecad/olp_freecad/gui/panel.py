"""The table of segments beside the 3D view, linked with the selection both ways, and the time line below it."""

from __future__ import annotations

import contextlib
import json

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from olp_freecad import program as parts
from olp_freecad.changes import set_speed
from olp_freecad.shapes import colour_of

_COLUMNS = (
    ("Line", "line"),
    ("Statement", "statement"),
    ("mm", "distance_mm"),
    ("Speed", ""),
    ("Top mm/s", "reached_mm_s"),
    ("mm/s²", "accel_mm_s2"),
    ("Limited by", "limited_by"),
    ("Time s", "duration_s"),
    ("End s", "end_s"),
)
_DECIMALS = {"line": 0, "distance_mm": 1, "reached_mm_s": 1, "accel_mm_s2": 0, "duration_s": 3, "end_s": 3}
_SPEED = 3
_BAR = 7
_TICK = 40  # [ms] between two pictures while it plays
_ROW = QtCore.Qt.UserRole + 1


def show(group: object) -> Panel:
    """The panel, made when there is none yet, with the segments of `group`."""
    window = FreeCADGui.getMainWindow()
    found = window.findChild(QtGui.QDockWidget, "olp")
    if found is None:
        found = Panel(window)
        window.addDockWidget(QtCore.Qt.BottomDockWidgetArea, found)
    if not found.shows(group):
        found.load(group)
    found.show()
    return found


class _Bar(QtGui.QStyledItemDelegate):
    """A bar behind the time, as long as the segment's share of the longest one."""

    def paint(self, painter: object, option: object, index: object) -> None:
        share, colour = index.data(_ROW) or (0.0, None)
        if share > 0.0:
            box = option.rect.adjusted(1, 2, -1, -2)
            box.setWidth(max(2, int(box.width() * share)))
            painter.fillRect(box, QtGui.QColor(*colour))
        super().paint(painter, option, index)


class Panel(QtGui.QDockWidget):
    def __init__(self, window: object) -> None:
        super().__init__("Segments", window)
        self.setObjectName("olp")
        self.group_name = self.document_name = self.data = ""
        self.rows: list = []
        self._is_linking = False
        self.table = QtGui.QTableWidget(0, len(_COLUMNS))
        self.table.setHorizontalHeaderLabels([title for title, _ in _COLUMNS])
        self.table.setSelectionBehavior(QtGui.QAbstractItemView.SelectRows)
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setDefaultSectionSize(20)
        self.table.setItemDelegateForColumn(_BAR, _Bar(self.table))
        self.table.itemSelectionChanged.connect(self._select_parts)
        self.table.itemChanged.connect(self._speed_typed)
        self.slider = QtGui.QSlider(QtCore.Qt.Horizontal)
        self.slider.valueChanged.connect(self._moved)
        self.button = QtGui.QPushButton("Play")
        self.button.clicked.connect(self.toggle_play)
        self.clock = QtGui.QLabel()
        self.says = QtGui.QLabel()
        self.timer = QtCore.QTimer(self)
        self.timer.timeout.connect(self._tick)
        self._lay_out()
        FreeCADGui.Selection.addObserver(self)

    def _lay_out(self) -> None:
        inside = QtGui.QWidget()
        column = QtGui.QVBoxLayout(inside)
        column.setContentsMargins(4, 2, 4, 2)
        line = QtGui.QHBoxLayout()
        for widget, stretch in ((self.button, 0), (self.slider, 1), (self.clock, 0)):
            line.addWidget(widget, stretch)
        column.addWidget(self.says)
        column.addWidget(self.table, 1)
        column.addLayout(line)
        self.setWidget(inside)

    @property
    def group(self) -> object | None:
        """The program; None when its document was closed."""
        if self.document_name not in FreeCAD.listDocuments():
            return None
        return FreeCAD.getDocument(self.document_name).getObject(self.group_name)

    def shows(self, group: object) -> bool:
        return self.group is group and self.data == group.Data

    def load(self, group: object) -> None:
        """Shows the segments of `group`."""
        self.timer.stop()
        self.button.setText("Play")
        self.group_name, self.document_name = group.Name, group.Document.Name
        self.data, self.rows = group.Data, parts.segments(group)
        self.speeds = json.loads(group.Written)
        self._is_linking = True
        longest = max((row["duration_s"] or 0.0 for row in self.rows), default=0.0) or 1.0
        self.table.setRowCount(len(self.rows))
        for number, row in enumerate(self.rows):
            for column, (_, name) in enumerate(_COLUMNS):
                self.table.setItem(number, column, self._cell(group, row, name, column, longest))
        self.table.resizeColumnsToContents()
        self.table.setColumnWidth(_BAR, 130)
        self.table.horizontalHeader().setSectionResizeMode(1, QtGui.QHeaderView.Stretch)
        self.slider.setRange(0, max(1, round(1000.0 * group.TotalSeconds)))
        self.tell()
        self._is_linking = False
        self._show_clock(group.Instant)

    def tell(self) -> None:
        """The line above the table; what olp says of the program is its tool tip."""
        group = self.group
        if group is not None:
            self.says.setText(_summary(group))
            self.says.setToolTip(
                "\n".join([*group.Messages, *(f"assumed: {one}" for one in group.Assumptions)])
            )

    def _cell(self, group: object, row: dict, name: str, column: int, longest: float) -> object:
        if column == _SPEED:
            return self._speed_cell(group, row)
        value = row[name]
        shown = "" if value is None else value if isinstance(value, str) else f"{value:.{_DECIMALS[name]}f}"
        cell = QtGui.QTableWidgetItem(shown)
        cell.setFlags(QtCore.Qt.ItemIsSelectable | QtCore.Qt.ItemIsEnabled)
        if not isinstance(value, str):
            cell.setTextAlignment(QtCore.Qt.AlignRight | QtCore.Qt.AlignVCenter)
        if column == _BAR:
            share = (row["duration_s"] or 0.0) / longest
            colour = [round(255 * v) for v in colour_of(share)]
            cell.setData(_ROW, (share, (*colour, 90)))
        return cell

    def _speed_cell(self, group: object, row: dict) -> object:
        told = self.speeds.get(str(row["line"])) if row["own"] else None
        if told is None:
            # As programmed, but not written on this line: nothing to change here.
            shown = row["speed_mm_s"]
            cell = QtGui.QTableWidgetItem("" if shown is None else f"{shown:.6g} mm/s")
            cell.setToolTip("set elsewhere, or computed" if shown is not None else "")
            cell.setFlags(QtCore.Qt.ItemIsSelectable | QtCore.Qt.ItemIsEnabled)
        else:
            value = getattr(group, f"Line_{row['line']}")
            cell = QtGui.QTableWidgetItem(f"{value:.6g} {told['unit']}")
            cell.setToolTip("Type another speed; Write back changes this line of the program")
            cell.setForeground(QtGui.QColor(0, 90, 180))
        cell.setTextAlignment(QtCore.Qt.AlignRight | QtCore.Qt.AlignVCenter)
        return cell

    def _speed_typed(self, cell: object) -> None:
        group = self.group
        if self._is_linking or group is None or cell.column() != _SPEED:
            return
        line = self.rows[cell.row()]["line"]
        words = cell.text().replace(",", ".").split()
        # What is no number is shown as the number it was.
        with contextlib.suppress(ValueError, IndexError):
            set_speed(group, line, float(words[0]))
        self._is_linking = True
        for number, row in enumerate(self.rows):
            if row["line"] == line and row["own"]:
                self.table.setItem(number, _SPEED, self._speed_cell(group, row))
        self._is_linking = False

    def _select_parts(self) -> None:
        """The rows of the table are selected in the 3D view, and the tool goes to the end of the last one."""
        group = self.group
        if self._is_linking or group is None:
            return
        rows = {index.row() for index in self.table.selectionModel().selectedRows()}
        self._is_linking = True
        FreeCADGui.Selection.clearSelection()
        owners = group.Path.Segment
        names = [f"Edge{i}" for i, owner in enumerate(owners, 1) if owner in rows]
        if names:
            FreeCADGui.Selection.addSelection(group.Path, names)
        self._is_linking = False
        if rows:
            self.set_instant(self.rows[max(rows)]["end_s"])

    # FreeCAD calls these four when something is selected.

    def addSelection(self, document: str, name: str, part: str, place: object) -> None:  # noqa: N802
        self._select_rows()

    def removeSelection(self, document: str, name: str, part: str) -> None:  # noqa: N802
        self._select_rows()

    def setSelection(self, document: str) -> None:  # noqa: N802
        self._select_rows()

    def clearSelection(self, document: str) -> None:  # noqa: N802
        self._select_rows()

    def _select_rows(self) -> None:
        group = self.group
        if self._is_linking or group is None:
            return
        rows: set = set()
        for one in FreeCADGui.Selection.getSelectionEx(self.document_name):
            owners = getattr(one.Object, "Segment", None)
            if owners is None:
                continue
            if one.ObjectName == group.Path.Name:
                rows |= {owners[int(part[4:]) - 1] for part in one.SubElementNames if part.startswith("Edge")}
            else:
                rows |= set(owners)
        self._is_linking = True
        self.table.clearSelection()
        self.table.setSelectionMode(QtGui.QAbstractItemView.MultiSelection)
        for row in sorted(rows):
            self.table.selectRow(row)
        self.table.setSelectionMode(QtGui.QAbstractItemView.ExtendedSelection)
        if rows:
            self.table.scrollToItem(self.table.item(min(rows), 0))
        self._is_linking = False

    def toggle_play(self) -> None:
        """Plays from where the slider is, from the start when it is at the end; again to stop."""
        if self.timer.isActive():
            self.timer.stop()
            self.button.setText("Play")
            return
        if self.slider.value() >= self.slider.maximum():
            self.slider.setValue(0)
        self._began, self._clock = self.slider.value(), QtCore.QElapsedTimer()
        self._clock.start()
        self.timer.start(_TICK)
        self.button.setText("Stop")

    def _tick(self) -> None:
        """Pictures may come late, but the tool is where it is at that time."""
        self.slider.setValue(self._began + self._clock.elapsed())
        if self.group is None or self.slider.value() >= self.slider.maximum():
            self.timer.stop()
            self.button.setText("Play")

    def set_instant(self, seconds: float) -> None:
        self.slider.setValue(int(1000.0 * seconds))

    def _moved(self, milliseconds: int) -> None:
        group = self.group
        if group is not None and not self._is_linking:
            place = parts.place_at(self.rows, milliseconds / 1000.0)
            if place is not None:
                group.Tool.Placement = place
            self._show_clock(milliseconds / 1000.0)

    def _show_clock(self, seconds: float) -> None:
        row = next((row for row in self.rows if row["end_s"] >= seconds), None)
        line = f"line {row['line']}" if row is not None else ""
        self.clock.setText(f"{seconds:7.3f} s of {self.slider.maximum() / 1000.0:.3f} s  {line}")


def _summary(group: object) -> str:
    told = [
        f"<b>{group.Label}</b>: {group.TotalSeconds:.3f} s (motion {group.MotionSeconds:.3f} s, "
        f"waits {group.WaitSeconds:.3f} s, signals {group.SignalSeconds:.3f} s), {group.Robot or 'no robot'}"
    ]
    if group.HighSeconds > 0.0:
        told.append(f"95 %: {group.LowSeconds:.3f} to {group.HighSeconds:.3f} s")
    for count, what in ((len(group.Messages), "message"), (len(group.Assumptions), "assumption")):
        if count:
            told.append(f"{count} {what}{'s' if count > 1 else ''}")
    told.append(
        "path: yellow fast, violet slow" if group.Colour == "speed" else "path: yellow first, violet last"
    )
    return "; ".join(told)
