"""The errors that the blocks of a program have reported in a run."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from rcx_harness.spec import folder
from rcx_harness.spec.tables import public_alarms
from structured_text.engines.base import Program
from structured_text.language.types import BlockType, ElementaryType
from structured_text.output.toml_files import load_toml
from structured_text.output.units import format_us

__all__ = ["BlockErrors", "error_names", "error_text"]

_PINS = ("Error", "ErrorID")
_ALARM = ("AlarmGroup", "AlarmCategory")
_TYPES = (ElementaryType("BOOL"), ElementaryType("WORD"))


class BlockErrors:
    """The first errors of the blocks with Execute that a program declares.

    A block shows its error only until Execute is FALSE, so `scan` must be called after each scan.
    Blocks with Enable are left out, because most of them report an error until the robot is
    connected. Blocks inside other blocks with ErrorID are also left out, because the outer block
    reports their errors.
    """

    def __init__(self, program: Program) -> None:
        self._program = program
        found = program.instances().items()
        self._blocks = {
            path: block
            for name, kind in found
            if isinstance(kind, BlockType)
            for path, block in _reporting(name, kind)
        }
        self._read = program.reader([f"{path}.ErrorID" for path in self._blocks])
        self._before: tuple[object, ...] = (0,) * len(self._blocks)
        self._texts: list[str] = []

    def scan(self, t_us: int) -> None:
        """Add the errors that have appeared in the scan at `t_us` [us]."""
        now = self._read()
        if now == self._before:
            return
        for path, was, error in zip(self._blocks, self._before, now, strict=True):
            if error and error != was:
                text = error_text(self._program, path, self._blocks[path])
                self._texts.append(f"{path} ended with {text} at {format_us(t_us)}")
        self._before = now

    def texts(self, most: int) -> Iterator[str]:
        """Yield a sentence for each of the first `most` errors.

        If there are more errors, a last sentence has their number.
        """
        yield from self._texts[:most]
        if (rest := len(self._texts) - most) > 0:
            yield f"further errors of blocks: {rest}"


def error_text(program: Program, path: str, block: BlockType) -> str:
    """Return the error that a block shows, with its name, and with its alarm if there is one.

    `error 16#8020 (Abnormal end, alarm 6.204: Point doesn't exist)` is an example. The names of
    errors come from spec/errors.toml, the names of alarms from spec/public_alarms.toml.
    """
    number = int(str(program.read(f"{path}.ErrorID")))
    alarm = ""
    if {pin.name for pin in block.variables}.issuperset(_ALARM):
        group, category = (int(str(program.read(f"{path}.{pin}"))) for pin in _ALARM)
        if group:
            name = public_alarms().get(f"{group}.{category}", "")
            alarm = f", alarm {group}.{category}{f': {name}' if name else ''}"
    return f"error 16#{number:04X} ({error_names().get(number, 'unknown')}{alarm})"


@lru_cache(maxsize=1)
def error_names() -> dict[int, str]:
    """Return the name of each ErrorID of the library (spec/errors.toml)."""
    table = load_toml(folder() / "errors.toml")["error"]
    return {entry["id"]: entry["name"] for entry in table}


def _reporting(path: str, owner: BlockType) -> Iterator[tuple[str, BlockType]]:
    for variable in owner.variables:
        block = variable.type
        if variable.section != "VAR" or not isinstance(block, BlockType):
            continue
        inner = f"{path}.{variable.name}"
        types = {pin.name: pin.type for pin in block.variables}
        if tuple(types.get(pin) for pin in _PINS) != _TYPES:
            yield from _reporting(inner, block)
        elif "Execute" in types:
            yield inner, block
