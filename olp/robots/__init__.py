"""The robot library: one TOML file per machine under a folder per maker, and what reads it."""

from typing import Final

EXAMPLE_ROBOT: Final = "yaskawa/gp25"  # of the library, in messages and contracts
RECORDED_ROBOT: Final = "yaskawa/up20"  # of the recordings in samples/
