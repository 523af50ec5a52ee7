"""A bench for FB_CommandRecorder, with helpers that write its inputs and read its log."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from alone import Alone

Row = tuple[str, int, int]

_NOTHING: Row = ("LOG_NOTHING", 0, 0)


class Recorder:
    """The recorder block, which is called every 10 ms."""

    def __init__(self) -> None:
        self._alone = _alone()
        self._alone.restart()
        self._now_ms = 0

    def __setitem__(self, path: str, value: Any) -> None:
        self._alone[path if path.startswith("Robot.") else f"Block.{path}"] = value

    def __getitem__(self, path: str) -> Any:
        return self._alone[f"Block.{path}"]

    def scan(self, count: int = 1) -> None:
        """Run scans."""
        for _ in range(count):
            self._alone["Robot.Inner.Elapsed"] = min(self._now_ms, 10)
            self._alone.scan(self._now_ms)
            self._now_ms += 10

    def change(self, path: str, *, to: Any, scans: int = 1) -> None:
        """Write a variable, then run scans."""
        self[path] = to
        self.scan(scans)

    def rows(self) -> list[Row]:
        """Return Kind, Number and Result of the log's rows, except empty rows at the end."""
        rows = [short(row) for row in self["Rows"]]
        while rows and rows[-1] == _NOTHING:
            rows.pop()
        return rows

    def edges(self, count: int) -> None:
        """Change SO(15), the warning, this many times: once in each scan."""
        for _ in range(count):
            self["Robot.SO.SO15_Warning"] = not self._alone["Robot.SO.SO15_Warning"]
            self.scan()

    def command(self, status: int, code: int = 0x1001, **fields: Any) -> None:
        """Simulate a remote command that runs for three scans and ends with this status."""
        self["Robot.Inner.Code"] = code
        self["Robot.Inner.Phase"] = "PHASE_COMMAND_DATA"
        self.scan()
        self["Robot.Inner.Phase"] = "PHASE_COMMAND_RUN"
        self.scan(3)
        self["Robot.Status"] = status
        self["Robot.Inner.Phase"] = "PHASE_STATUS_RESET"
        for path, value in fields.items():
            self[f"Robot.{path.replace('__', '.')}"] = value
        self.scan()
        self["Robot.Status"] = 0
        self["Robot.Inner.Phase"] = "PHASE_READY"
        self.scan()


@cache
def _alone() -> Alone:
    return Alone("FB_CommandRecorder", {"Robot": "RCX_REF"})


def short(entry: Mapping[str, Any]) -> Row:
    """Return Kind, Number and Result of a log entry."""
    return entry["Kind"], entry["Number"], entry["Result"]


def connected() -> Recorder:
    """Return a recorder after Connected and CPU_OK. Its log has a row for each of the two."""
    block = Recorder()
    block["Robot.Connected"] = True
    block["Robot.SO.SO01_CpuOk"] = True
    block.scan()
    assert block.rows() == [("LOG_OUTPUT", 1, 1), ("LOG_LINK", 0, 1)]
    return block
