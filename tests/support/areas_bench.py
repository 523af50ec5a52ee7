"""A PLC with two versions of each block, for images of bytes and of words. Both must agree."""

from __future__ import annotations

from pathlib import Path

from plc_bench import ROOT, PlcBench
from structured_text.engines.base import Value

_PROGRAM: Path = ROOT / "tests/data/library/Areas.st"
_READERS = ("ReadBit", "ReadPort", "ReadWord", "ReadDoubleWord")
_WRITERS = ("WriteBit", "WritePort", "WriteWord", "WriteDoubleWord")
_SINGLES = ("Robot", "ReadArea", "WriteArea", "First", "ServoOn", "RealTimeValue")
_TWINS = (*_SINGLES, *_READERS, *_WRITERS)


class AreasBench(PlcBench):
    """The program Areas.st, in which a block for bytes and its twin for words get the same pins.

    The twin's name ends in W. After every scan the bench compares the images, the robots and all
    pins of the twins, unless `alike` is False (for an odd offset).
    """

    def __init__(self, *, size: int = 48, m: int = 0, n: int = 0, alike: bool = True) -> None:
        super().__init__(program=_PROGRAM, size=size, m=m, n=n)
        self.alike = alike
        for name in _READERS:
            self[f"{name}.m"], self[f"{name}.Size"] = m, size
        for name in _WRITERS:
            self[f"{name}.n"], self[f"{name}.Size"] = n, size

    def __setitem__(self, path: str, value: Value) -> None:
        super().__setitem__(path, value)
        block, dot, rest = path.partition(".")
        if block in _TWINS:
            super().__setitem__(f"{block}W{dot}{rest}", value)

    def scan(self, count: int = 1) -> None:
        """Run scans. Before each scan, copy the area `so` into both input images."""
        for _ in range(count):
            image = bytearray(self.program.read_bytes("Main.InputWords"))
            image[self.m : self.m + len(self.so)] = self.so
            self.program.write_bytes("Main.InputWords", bytes(image))
            super().scan()
            if self.alike:
                self._compare()

    def write(self, block: str, **pins: Value) -> Value:
        """Call the writing block of this name for one scan, and return its ErrorID."""
        for name, value in pins.items():
            self[f"{block}.{name}"] = value
        for other in _WRITERS:
            self[f"{other}.Size"] = len(self.so) if other == block else 0
        self["Writing"] = True
        self.scan()
        self["Writing"] = False
        assert self[f"{block}.Error"] is (self[f"{block}.ErrorID"] != 0)
        return self[f"{block}.ErrorID"]

    def read(self, block: str, **pins: Value) -> tuple[Value, Value, Value]:
        """Set these pins of a reading block, scan once, and return its Value, Valid and ErrorID."""
        for name, value in pins.items():
            self[f"{block}.{name}"] = value
        self.scan()
        assert self[f"{block}.Error"] is (self[f"{block}.ErrorID"] != 0)
        return self[f"{block}.Value"], self[f"{block}.Valid"], self[f"{block}.ErrorID"]

    @property
    def word_image(self) -> bytes:
        """Return the output image of words as bytes, the lower byte of each word first."""
        return self.program.read_bytes("Main.OutputWords")

    def fill(self, pattern: int) -> None:
        """Fill both output images with one byte."""
        for area in ("OutputArea", "OutputWords"):
            self.program.write_bytes(f"Main.{area}", bytes([pattern] * 512))

    def _compare(self) -> None:
        assert self.word_image == self.image, "the images differ"
        assert self["RobotW"] == self["Robot"]
        for name in (*_READERS, *_WRITERS, "ReadArea", "WriteArea"):
            pins = ["Error", "ErrorID", *(["Value", "Valid"] if name in _READERS else [])]
            for pin in pins:
                assert self[f"{name}W.{pin}"] == self[f"{name}.{pin}"], f"{name}.{pin}"
