"""Figures of the runs of the campaign."""

from __future__ import annotations

from dataclasses import dataclass, field

from rcx_harness.cell.stimulus import Entry

__all__ = ["Outcome"]


@dataclass
class Outcome:
    """The figures of one or several runs; times are in virtual microseconds."""

    virtual_us: int = 0
    storms: int = 0
    requests: int = 0
    executions: int = 0
    scans: int = 0
    acts: dict[str, int] = field(default_factory=dict)
    ends: dict[str, int] = field(default_factory=dict)
    done: dict[str, int] = field(default_factory=dict)
    packets: dict[str, int] = field(default_factory=dict)
    longest_quiet_us: int = 0
    longest_recovery_us: int = 0

    def take(self, act: Entry) -> None:
        """Count an event of a storm."""
        for name in [name for name, _ in act.events] or ["set"]:
            self.acts[name] = self.acts.get(name, 0) + 1

    def add(self, other: Outcome) -> None:
        """Add the figures of another run."""
        for name in ("virtual_us", "storms", "requests", "executions", "scans"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        for name in ("acts", "ends", "done", "packets"):
            into: dict[str, int] = getattr(self, name)
            for key, count in getattr(other, name).items():
                into[key] = into.get(key, 0) + count
        for name in ("longest_quiet_us", "longest_recovery_us"):
            setattr(self, name, max(getattr(self, name), getattr(other, name)))
