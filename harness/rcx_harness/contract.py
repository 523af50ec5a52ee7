"""The contract of the blocks (PLCopen), checked from outside, scan by scan.

A monitor sees a block before and after a scan, not at its call. What holds whenever the block is
called is checked for every instance. The rest needs to know the Execute that the block saw; it is
checked where the program shows it: one call per scan that cannot be skipped, and no assignment to
Execute after it (`steady_instances`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

from rcx_harness.engine.base import Program
from rcx_harness.engine.types import BlockType, ElementaryType, Variable
from rcx_harness.robot import Violation

__all__ = ["ContractMonitor"]

_NEEDED = ("Execute", "Busy", "Done", "Error")
_OPTIONAL = ("Active", "CommandAborted", "ErrorID")


class _Pins(NamedTuple):
    busy: bool
    done: bool
    error: bool
    aborted: bool
    active: bool
    error_id: int

    @property
    def shown(self) -> tuple[str, ...]:
        """Which of the exclusive outputs are true."""
        named = zip(("Busy", "Done", "Error", "CommandAborted"), self[:4], strict=True)
        return tuple(name for name, value in named if value)

    @property
    def end(self) -> bool:
        """Is an end shown?"""
        return self.done or self.error or self.aborted


_IDLE = _Pins(False, False, False, False, False, 0)


class _Instance:
    """One block instance: the paths of its pins and what they were."""

    def __init__(self, path: str, block: BlockType, steady: bool) -> None:
        names = {variable.name.lower(): variable.name for variable in block.variables}
        self.path, self.steady = path, steady
        self.execute = f"{path}.{names['execute']}"
        self.pins = [
            f"{path}.{names[pin]}" if pin in names else None
            for pin in ("busy", "done", "error", "commandaborted", "active", "errorid")
        ]
        self.has_id = self.pins[5] is not None
        self.before = _IDLE
        self.saw = False
        self.told: frozenset[str] = frozenset()

    def read(self, program: Program) -> _Pins:
        values: list[Any] = [program.read(path) if path else 0 for path in self.pins]
        return _Pins(*values)


class ContractMonitor:
    """Checks every instance that has Execute, Busy, Done and Error.

    Args:
        program: The program to watch.
        steady: Instances that are called exactly once in every scan, with an Execute that
            nothing alters after the call, as `steady_instances` gives them; they are checked
            to the full.
    """

    def __init__(self, program: Program, steady: Collection[str] = ()) -> None:
        self._program = program
        self._instances = [
            _Instance(f"{name}.{variable.name}", block, key in steady)
            for name, variable, block, key in _top_level(program)
            if _is_command(block)
        ]

    @property
    def paths(self) -> list[str]:
        """The instances that are watched."""
        return [instance.path for instance in self._instances]

    def scan(self, t_us: int, scan: int) -> list[Violation]:
        """Judge all instances after a scan."""
        found = []
        for instance in self._instances:
            pins = instance.read(self._program)
            execute = bool(self._program.read(instance.execute))
            same = pins == instance.before and execute == instance.saw and not instance.told
            if same and (execute or not pins.end):
                continue  # nothing new, and nothing that may not last
            broken = _always(pins, instance)
            if instance.steady and not broken:
                broken += _at_the_call(pins, instance.before, execute, instance.saw)
            told = frozenset(broken)
            for text in broken:
                if text not in instance.told:
                    where = f"plc, scan {scan}: contract: {instance.path}"
                    found.append(Violation(t_us, "contract", f"{where}: {text}"))
            instance.before, instance.saw, instance.told = pins, execute, told
        return found

    def snapshot(self) -> object:
        """What is remembered of each instance."""
        return [(one.before, one.saw, one.told) for one in self._instances]

    def restore(self, snapshot: list[tuple[_Pins, bool, frozenset[str]]]) -> None:
        """Go back to what `snapshot` gave."""
        for instance, state in zip(self._instances, snapshot, strict=True):
            instance.before, instance.saw, instance.told = state


def _top_level(program: Program) -> Iterator[tuple[str, Variable, BlockType, str]]:
    """Instances declared in the programs themselves; what a block does inside is its own affair."""
    for name, kind in program.instances().items():
        assert isinstance(kind, BlockType)
        for variable in kind.variables:
            if isinstance(variable.type, BlockType) and variable.section == "VAR":
                yield name, variable, variable.type, f"{kind.name}.{variable.name}".upper()


def _is_command(block: BlockType) -> bool:
    bools = {
        variable.name.lower()
        for variable in block.variables
        if variable.type == ElementaryType("BOOL")
    }
    return all(name.lower() in bools for name in _NEEDED)


def _always(pins: _Pins, instance: _Instance) -> list[str]:
    """What holds at any time, called or not."""
    broken = []
    if len(pins.shown) > 1:
        broken.append(f"{' and '.join(pins.shown)} are true together; expected at most one")
    if pins.active and not pins.busy:
        broken.append("Active is true without Busy")
    if instance.has_id and pins.error != (pins.error_id != 0):
        broken.append(
            f"Error is {str(pins.error).upper()} with ErrorID 16#{pins.error_id:04X}; "
            "Error is true exactly when ErrorID is not 0"
        )
    before = instance.before
    if before.busy and not pins.shown:
        broken.append("Busy fell without an end; expected Done or Error for at least one scan")
    return broken


def _at_the_call(pins: _Pins, before: _Pins, execute: bool, saw: bool) -> list[str]:
    """What holds where the block saw `execute` in this scan and `saw` in the one before."""
    edge = execute and not saw
    if edge and not pins.shown:
        return ["no Busy, Done or Error in the call of the rising edge"]
    if not edge and not before.busy and pins.shown not in ((), before.shown):
        return [f"{pins.shown[0]} without a rising edge of Execute"]
    if execute and not pins.shown:
        return [f"{before.shown[0] if before.shown else 'the end'} is gone while Execute is true"]
    if not execute and not saw and before.end and pins.end:
        return [f"{pins.shown[0]} is shown for more than one scan after Execute has fallen"]
    return []
