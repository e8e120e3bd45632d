"""Recordings of real robots as a researcher uses them: read, calibrate, predict, diagnose; tables and plots.

`FluentRecording` and `FluentSignature` (`olp.Recording`, `olp.Signature` for users) are the classes of
`olp.identification` with the methods that need packages above theirs.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from olp.fluent import as_html, as_robot, fields_of
from olp.identification.recording import recording as recordings
from olp.identification.recording.reader import read_recording
from olp.identification.signature import document as signatures
from olp.identification.signature import learn
from olp.identification.signature.file import read_signature, write_signature

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from olp.identification.diagnosis.diagnose import DiagnosisOutcome
    from olp.robots.model import Robot


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FluentRecording(recordings.Recording):
    """What a real robot did, move by move; see docs/recording.md for the files and `moves`, `log`, `settings`.

    Example:
        >>> import olp
        >>> recording = olp.Recording.read("samples/up20")
        >>> recording
        <Recording samples/up20: 146 moves, yaskawa/up20>
        >>> recording.moves.duration.shape, float(recording.moves.duration[0])  # [s]
        ((146,), 2.64)
    """

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> FluentRecording:
        """The recording at `path`: a folder, or a single file of moves. Raises OlpError with all that is wrong."""
        return cls(**fields_of(read_recording(os.fspath(path), logs_alone=True)))

    def frame(self) -> pandas.DataFrame:
        """The moves as moves.csv has them: one row per move, units in the names of the columns."""
        import io

        import pandas

        from olp.identification.recording.writer import moves_csv

        return pandas.read_csv(io.StringIO(moves_csv(self.moves)))

    def plot(self, axes: Axes | None = None) -> Axes:
        """Durations [s] of the moves, measured and simulated; of logs alone the axes [deg | mm] over time [s].

        `axes`: where to draw (None: a new figure). Raises OlpError (Y003) without matplotlib, or with nothing to draw.
        """
        from olp.drawings import draw_durations

        return draw_durations(self, axes)

    def _repr_html_(self) -> str:
        from olp.identification.recording.summary import describe

        return f"<pre>{escape(describe(self))}</pre>" + as_html("", self.diagnostics)


@dataclass(frozen=True, slots=True, repr=False)
class FluentSignature(signatures.Signature):
    """How a robot differs from its data sheet, learnt by `olp.calibrate`; docs/signature.md has the fields.

    Example:
        >>> import olp
        >>> olp.calibrate("samples/up20", method="constant")
        <Signature of yaskawa/up20: method constant, 146 moves of samples/up20>
    """

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> FluentSignature:
        """The signature in a file. Raises OlpError if the file is not a signature."""
        return cls(**fields_of(read_signature(os.fspath(path))))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the file that `--signature` of the commands takes. Raises OSError."""
        write_signature(self, os.fspath(path))

    def plot(self, axes: Axes | None = None) -> Axes:
        """The corrected acceleration [mm/s²] of the moves it learnt, with 95 % intervals, over their direction [deg].

        `axes`: where to draw (None: a new figure). Raises OlpError (Y003) without matplotlib, or with nothing to draw.
        """
        from olp.drawings import draw_signature

        return draw_signature(self, axes)

    def __repr__(self) -> str:
        learnt = self.recording
        return f"<Signature of {self.robot or 'a robot'}: method {self.method}, {learnt.moves} moves of {learnt.name}>"

    def _repr_html_(self) -> str:
        from olp.identification.signature.summary import describe

        return f"<pre>{escape(chr(10).join(describe(self)))}</pre>"


@dataclass(frozen=True, slots=True, repr=False)
class DiagnosisAnswer:
    """What `olp.diagnose` found; `outcome` holds all of it, the objects of `olp.identification.diagnosis`.

    Example:
        >>> import olp
        >>> answer = olp.diagnose("samples/recordings/tuned")
        >>> answer.verdict, answer.findings
        ('explained', ('acceleration', 'jerk'))
    """

    outcome: DiagnosisOutcome
    recording: FluentRecording

    @property
    def verdict(self) -> str:
        """explained, partly-explained, unexplained, no-mismatch … as in docs/diagnose.md."""
        return self.outcome.diagnosis.verdict

    @property
    def findings(self) -> tuple[str, ...]:
        """The names of the physics that the simulation left out."""
        return tuple(finding.term for finding in self.outcome.diagnosis.findings)

    def to_json(self) -> dict[str, Any]:
        """The whole answer, schema olp.diagnosis/1."""
        return self.outcome.diagnosis.to_json()

    def text(self) -> str:
        """What `olp diagnose` prints."""
        from olp.identification.diagnosis.report_text import text_report

        return text_report(self.outcome.diagnosis, self.outcome.case, 100, False)

    def html(self) -> str:
        """The page of `olp diagnose --html`."""
        from olp.reports.diagnosis.page import html_report

        log = self.outcome.log.to_json() if self.outcome.log is not None else None
        return html_report(self.outcome, self.recording, None, log_summary=log)

    def plot(self, axes: Axes | None = None) -> Axes:
        """What the simulation is off [ms] in each move, as it is and with the findings.

        `axes`: where to draw (None: a new figure). Raises OlpError (Y003) without matplotlib, or with nothing to draw.
        """
        from olp.drawings import draw_residuals

        return draw_residuals(self.outcome, axes)

    def __repr__(self) -> str:
        names = ", ".join(self.findings) or "nothing named"
        return f"<Diagnosis of {self.recording.path}: {self.verdict}, {names}>"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.text())}</pre>"


def calibrate(
    recording: recordings.Recording | str | os.PathLike[str],
    *,
    method: str = "auto",
    robot: str | Robot | None = None,
) -> FluentSignature:
    """The timing signature of a robot, learnt from recorded moves.

    `recording`: one that was read, or its folder. `method`: auto, or a name of docs/signature.md. `robot`: name of the
    library or robot file (None: the recording's). Raises OlpError for a recording that cannot teach one.

    Example:
        >>> import olp
        >>> signature = olp.calibrate("samples/up20", method="factors")
        >>> signature.save("up20.signature.json")  # for olp time --signature
    """
    return FluentSignature(**fields_of(learn.calibrate(_recording(recording), method, as_robot(robot))[0]))


def predict(
    recording: recordings.Recording | str | os.PathLike[str],
    *,
    signature: signatures.Signature | str | os.PathLike[str],
) -> pandas.DataFrame:
    """The time of each of the n moves of a recording: n rows, columns `move`, `predicted_s`, `low_s`, `high_s` [s].

    `low_s` to `high_s` is the 95 % interval; nan where nothing can be said. `signature`: one that was learnt or read,
    or its file. Raises OlpError for a signature or a recording that is none.

    Example:
        >>> import olp
        >>> signature = olp.calibrate("samples/up20", method="factors")
        >>> table = olp.predict("samples/up20", signature=signature)
        >>> list(table.columns), len(table)
        (['move', 'predicted_s', 'low_s', 'high_s'], 146)
    """
    import pandas

    from olp.identification.signature.rows import predict_recording

    if isinstance(signature, (str, os.PathLike)):
        signature = FluentSignature.read(signature)
    rows, _ = predict_recording(signature, _recording(recording))
    columns = {"move": rows.move, "predicted_s": rows.predicted, "low_s": rows.low, "high_s": rows.high}
    return pandas.DataFrame(columns)


def diagnose(
    recording: recordings.Recording | str | os.PathLike[str], *, robot: str | Robot | None = None
) -> DiagnosisAnswer:
    """Where a simulation and a recording differ, and which physics was left out.

    `recording`: one that was read, or its folder. `robot`: name of the library or robot file (None: the recording's).
    Raises OlpError for what is no recording.

    Example:
        >>> import olp
        >>> olp.diagnose("samples/recordings/tuned")
        <Diagnosis of samples/recordings/tuned: explained, acceleration, jerk>
    """
    from olp.identification.diagnosis.diagnose import diagnose_recording

    known = _recording(recording)
    return DiagnosisAnswer(diagnose_recording(known, as_robot(robot)), known)


def _recording(recording: recordings.Recording | str | os.PathLike[str]) -> FluentRecording:
    if isinstance(recording, FluentRecording):
        return recording
    if isinstance(recording, recordings.Recording):
        return FluentRecording(**fields_of(recording))
    return FluentRecording.read(recording)


# What users import.
Recording = FluentRecording
Signature = FluentSignature
