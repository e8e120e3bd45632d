"""Recordings of real robots: one form, whatever the robot, controller or simulator. docs/recording.md describes it."""

from olp.recording.columns import KINDS
from olp.recording.log import Log
from olp.recording.moves import RecordedMoves
from olp.recording.reader import read_recording
from olp.recording.recording import NoiseFloor, Recording
from olp.recording.settings import Settings
from olp.recording.writer import write_recording

__all__ = [
    "KINDS",
    "Log",
    "NoiseFloor",
    "RecordedMoves",
    "Recording",
    "Settings",
    "read_recording",
    "write_recording",
]
