"""The run as a VCD file for wave viewers: all dedicated bits and words, on both sides."""

from __future__ import annotations

from pathlib import Path
from typing import TextIO, cast

from vcd import VCDWriter
from vcd.writer import Variable

from rcx_harness.output.files import OutputFile
from rcx_harness.spec import Signal, signals
from rcx_harness.trace.records import Cycle, Record, Scan
from rcx_harness.watch.wire import word

__all__ = ["Wave"]

_WORDS = 16


class _Area:
    """The variables of one area in one scope."""

    def __init__(
        self, writer: VCDWriter, scope: str, prefix: str, bits: tuple[Signal, ...]
    ) -> None:
        self._writer = writer
        self._before = b""
        self._bits = [
            (one.byte, one.bit, writer.register_var(scope, one.name, "wire", size=1, init=0))
            for one in bits
        ]
        self._words: list[Variable[int]] = [
            writer.register_var(scope, f"{prefix}{k:02}", "wire", size=16, init=0)
            for k in range(_WORDS)
        ]

    def take(self, t_us: int, area: bytes) -> None:
        """Note the changes of an area; without a connection nothing changes."""
        if not area or area == self._before:
            return
        before = self._before or bytes(len(area))
        for byte, bit, variable in self._bits:
            new = area[byte] >> bit & 1
            if new != before[byte] >> bit & 1:
                self._writer.change(variable, t_us, new)
        if area[: 2 * _WORDS] != before[: 2 * _WORDS]:
            for k, variable in enumerate(self._words):
                value = word(area, 2 * k)
                if value != word(before, 2 * k):
                    self._writer.change(variable, t_us, value)
        self._before = area


class Wave:
    """Writes a VCD file as the run goes; give `take` to `Trace.listen`.

    Args:
        path: File to write.
        controllers: How many there are; the scopes of all but the first bear their number.

    Raises:
        InputError: the file cannot be written.
    """

    def __init__(self, path: str | Path, controllers: int = 1) -> None:
        self._file = OutputFile(path, "ascii")
        # No date and no version: the same run gives the same bytes.
        self._writer = VCDWriter(
            cast(TextIO, self._file), timescale="1 us", date="", version="rcx", comment=""
        )
        table = signals()
        self._plc: list[tuple[_Area, _Area]] = []
        self._robot: list[tuple[_Area, _Area]] = []
        for which in ("", *(f"_{k}" for k in range(2, controllers + 1))):
            for sides, scope in ((self._plc, f"plc{which}"), (self._robot, f"robot{which}")):
                so = _Area(self._writer, scope, "SOW", table.output)
                sides.append((so, _Area(self._writer, scope, "SIW", table.input)))
        self._broken = self._writer.register_var("rules", "broken", "integer", size=32, init=0)
        self._count = 0
        self._end_us = 0

    def take(self, record: Record) -> None:
        """Take the next record of the run."""
        self._end_us = record.t_us
        if isinstance(record, Scan):
            so, si = self._plc[record.controller - 1]
            so.take(record.t_us, record.so)
            si.take(record.t_us, record.si)
        elif isinstance(record, Cycle):
            so, si = self._robot[record.controller - 1]
            si.take(record.t_us, record.rcx_si)
            so.take(record.t_us, record.rcx_so)
        else:
            self._count += 1
            self._writer.change(self._broken, record.t_us, self._count)

    def close(self) -> None:
        """Write the last time and close the file."""
        if not self._file.closed:
            self._writer.close(self._end_us)
            self._file.close()
