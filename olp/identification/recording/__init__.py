"""Recordings of real robots: one form, whatever the robot, controller or simulator. docs/recording.md describes it."""

from olp.identification.recording.log import Log
from olp.identification.recording.moves import KINDS, RecordedMoves
from olp.identification.recording.reader import read_recording
from olp.identification.recording.recording import NoiseFloor, Recording
from olp.identification.recording.settings import RecordingSettings
from olp.identification.recording.writer import write_recording

__all__ = [
    "KINDS",
    "Log",
    "NoiseFloor",
    "RecordedMoves",
    "Recording",
    "RecordingSettings",
    "read_recording",
    "write_recording",
]
