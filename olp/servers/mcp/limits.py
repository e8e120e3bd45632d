"""How much one call may read, compute and say."""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class ServerLimits:
    """The defaults hold a cell of a few hundred jobs; a call beyond them is refused, never answered in part unsaid."""

    seconds: float = 60.0  # [s] of the clock, then the worker is ended
    memory: int = 4_000_000_000  # [bytes] of address space of the worker
    file: int = 8_000_000  # [bytes] of one file that is read
    files: int = 500  # programs of one call
    answer: int = 200_000  # characters of one answer

    def as_json(self) -> dict[str, float]:
        """For the worker's request."""
        return asdict(self)
