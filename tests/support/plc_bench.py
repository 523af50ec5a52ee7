"""A bench for a PLC without a robot.

The test plays the controller, byte by byte and scan by scan.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from rcx_harness.watch.calls_source import steady_instances
from rcx_harness.watch.contract import ContractMonitor
from structured_text.engines import build
from structured_text.engines.base import Program, Value
from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.engines.native.program import NativeProgram
from structured_text.projects.needed import needed

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = sorted((ROOT / "plc/lib").rglob("*.st"))
BENCH = ROOT / "tests/data/library/Bench.st"


def compiled(program: str | Path, engine: str = "auto") -> Program:
    """Return a new instance of a program, which is given as a text or as a file.

    The program is compiled with the library blocks that it needs. Many tests share the compiled
    program.
    """
    return _compiled(program, engine, tuple(LIBRARY))[0].instance()


@lru_cache(maxsize=64)
def _compiled(
    program: str | Path, engine: str, library: tuple[Path, ...]
) -> tuple[BuiltinProgram | NativeProgram, frozenset[str]]:
    """Return the compiled program and the block instances that it calls in every scan."""
    with tempfile.TemporaryDirectory() as folder:
        file = program if isinstance(program, Path) else Path(folder) / "Program.st"
        if isinstance(program, str):
            file.write_text(program, encoding="utf-8")
        files = needed([file], library)
        found = build([file, *files], engine).program
        assert isinstance(found, (BuiltinProgram, NativeProgram))
        return found, frozenset(steady_instances([file], files))


class PlcBench:
    """A bench that scans a program every 10 ms: Bench.st, or the given file or text.

    Its areas begin at the offsets `m` and `n`. With the margin of 20 ms, two changes of dedicated
    inputs are at least 120 ms (12 scans) apart. With `contract`, the contract monitor checks every
    scan of every
    block.
    """

    def __init__(
        self,
        *,
        program: Path | str = BENCH,
        size: int = 48,
        m: int = 0,
        n: int = 0,
        scan_us: int = 10_000,
        margin: str | None = "T#20ms",
        engine: str = "auto",
        contract: bool = True,
    ) -> None:
        self.program: Program = compiled(program, engine)
        steady = _compiled(program, engine, tuple(LIBRARY))[1]
        self._monitor = ContractMonitor(self.program, steady) if contract else None
        self.now_us = 0
        self.scan_us = scan_us
        self.m, self.n = m, n
        self.so = bytearray(size)
        self["ReadArea.m"], self["WriteArea.n"] = m, n
        self["ReadArea.Size"] = self["WriteArea.Size"] = size
        if margin is not None:
            self["WriteArea.Margin"] = margin

    def __getitem__(self, path: str) -> Value:
        return self.program.read(f"Main.{path}")

    def __setitem__(self, path: str, value: Value) -> None:
        self.program.write(f"Main.{path}", value)

    def snapshot(self) -> object:
        """Return the state of the program, of the controller's outputs and of the monitor."""
        judged = self._monitor.snapshot() if self._monitor else None
        return self.program.snapshot(), self.now_us, bytes(self.so), judged

    def restore(self, snapshot: Any) -> None:
        """Continue from `snapshot`."""
        program, self.now_us, so, judged = snapshot
        self.program.restore(program)
        self.so[:] = so
        if self._monitor:
            self._monitor.restore(judged)

    def scan(self, count: int = 1) -> None:
        """Run scans. Each scan reads the area `so`."""
        for _ in range(count):
            image = bytearray(self.program.read_bytes("Main.InputArea"))
            image[self.m : self.m + len(self.so)] = self.so
            self.program.write_bytes("Main.InputArea", bytes(image))
            self.program.scan(self.now_us)
            if self._monitor:
                found = self._monitor.scan(self.now_us, self.now_us // self.scan_us)
                assert not found, found[0].text
            self.now_us += self.scan_us

    def scan_until(
        self, condition: Callable[[], bool], *, most: int = 100, execute: str = ""
    ) -> int:
        """Raise Execute of the block, if a name is given, and scan until the condition holds.

        Returns:
            The number of scans.
        """
        if execute:
            self[f"{execute}.Execute"] = True
        for count in range(1, most + 1):
            self.scan()
            if condition():
                return count
        raise AssertionError(f"not within {most} scans, at {self.now_us} us")

    def change(self, *paths: str, to: Value, scans: int = 1) -> None:
        """Write a value to variables, then run scans."""
        for path in paths:
            self[path] = to
        self.scan(scans)

    def outputs(self, *, scans: int = 0, **bits: bool) -> None:
        """Set dedicated outputs of the controller, `outputs(SO02=True)`, then run scans."""
        for name, on in bits.items():
            byte, bit = 32 + int(name[2]), int(name[3])
            self.so[byte] = self.so[byte] & ~(1 << bit) | (on << bit)
        self.scan(scans)

    def let(self, cause: str) -> None:
        """Set an output of the controller or a pin of the area blocks: `SO00=1`, `StopOk=0`."""
        name, _, value = cause.partition("=")
        if name.startswith("SO"):
            self.outputs(**{name: value == "1"})
        else:
            self[name] = value == "1"

    def answer(self, status: int, response: Sequence[int] = (), *, scans: int = 0) -> None:
        """Set the remote status and the words from SOW(1) on, fill up with 0, then run scans."""
        words = [status, *response, *[0] * (15 - len(response))]
        for k, word in enumerate(words):
            self.so[2 * k : 2 * k + 2] = word.to_bytes(2, "little")
        self.scan(scans)

    def complete(self, status: int = 0x0200, response: Sequence[int] = ()) -> None:
        """Let the command end with this status for one scan, then reset the status."""
        self.answer(status, response, scans=1)
        self.answer(0)

    def give(self, block: str, code: int, *, most: int = 100) -> None:
        """Start this FB_RemoteCommand, and scan until its code is on the wire."""
        self[f"{block}.Code"] = code
        self.scan_until(lambda: self.words[0] == code, most=most, execute=block)

    @property
    def image(self) -> bytes:
        """Return the whole output image."""
        return self.program.read_bytes("Main.OutputArea")

    @property
    def words(self) -> list[int]:
        """Return SIW(0) to SIW(15) from the output image: code and data."""
        area = self.image[self.n : self.n + 32]
        return [int.from_bytes(area[2 * k : 2 * k + 2], "little") for k in range(16)]

    @property
    def inputs(self) -> list[str]:
        """Return the dedicated inputs that are ON in the output image, as in `["SI00", "SI06"]`."""
        return [
            f"SI{byte}{bit}"
            for byte in (0, 1)
            for bit in range(8)
            if self.image[self.n + 32 + byte] >> bit & 1
        ]

    def power_up(self) -> None:
        """Power up: normal state, AUTO, SI(00) and SI(06) ON and settled."""
        self.outputs(SO01=True, SO04=True, SO10=True)
        self.scan_until(lambda: bool(self["Robot.Settled"]))
