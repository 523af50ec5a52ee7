"""The contract of the blocks: rules of PLCopen, checked from outside, scan by scan.

A monitor sees a block before and after a scan, not at its call. Rules that do not depend on the
time of the call are checked for every instance, including those inside other blocks. The other
rules depend on Execute or Enable at the call. They are checked only if the source makes these
values certain: one call per scan that cannot be skipped, and no assignment to the pin after it
(`steady_instances`).

A call outside of FB_ReadArea and FB_WriteArea is recognized by the ErrorID of the block, because
only the built-in engine reports calls.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import lru_cache
from itertools import islice
from typing import Any, NamedTuple

from rcx_harness.robot import Violation
from structured_text.engines.base import Program
from structured_text.language.types import BlockType, ElementaryType

__all__ = ["ContractMonitor"]

#: ErrorID of a block that was called outside of FB_ReadArea and FB_WriteArea (errors.md).
_OUT_OF_PLACE = 0x8017


class _Pins(NamedTuple):
    """Outputs of an edge-triggered block."""

    busy: bool
    done: bool
    error: bool
    aborted: bool
    active: bool
    error_id: int

    @property
    def shown(self) -> tuple[str, ...]:
        """Return the true outputs among those of which only one may be true."""
        named = zip(("Busy", "Done", "Error", "CommandAborted"), self[:4], strict=True)
        return tuple(name for name, value in named if value)

    @property
    def end(self) -> bool:
        """Return whether Done, Error or CommandAborted is true."""
        return self.done or self.error or self.aborted


class _Instance:
    """One judged block instance, with the previous values of its pins.

    Subclasses define the pins and the rules.
    """

    pins: tuple[str, ...] = ("error", "errorid")

    def __init__(self, found: _Found) -> None:
        self.path, names, self.steady, self.outermost, self.topmost = found[1:]
        # In the order of declaration, so that the pins are adjacent in memory.
        there = [pin for pin in names if pin in self.pins]
        self.read = [f"{self.path}.{names[pin]}" for pin in there]
        """Paths of the pins in `pins` that the block has, in the order of declaration."""
        self._at = [there.index(pin) if pin in names else None for pin in self.pins]
        self.has_id = "errorid" in names
        self.before: tuple[Any, ...] = (0,) * len(there)
        self.told: tuple[str, ...] = ()
        self._verdicts: dict[tuple[tuple[Any, ...], tuple[Any, ...]], tuple[str, ...]] = {}
        """The broken rules for each change of the pins; cached because few changes recur often."""
        self.at_rest = False
        """Whether an unchanged state breaks no rule."""

    def scan(self, now: tuple[Any, ...]) -> list[str]:
        """Judge the values of `read` after a scan; return violations that did not exist before."""
        change = self.before, now
        verdict = self._verdicts.get(change)
        if verdict is None:
            pins = self._by_pin(now)
            broken = self._judge(self._by_pin(self.before), pins)
            if self.topmost and self.has_id and pins[-1] == _OUT_OF_PLACE:
                broken = [*broken, _MOVE_IT]
            verdict = self._verdicts[change] = tuple(broken)
        found = [text for text in verdict if text not in self.told]
        self.before, self.told = now, verdict
        self.at_rest = not verdict and not self._may_not_last()
        return found

    def begin(self, now: tuple[Any, ...]) -> None:
        """Store the values of `read` as the previous values if an output is true.

        Such an output was true before the start, so the next scan must not judge it as new.
        """
        if any(self._by_pin(now)[1:]):
            self.before = now

    def _by_pin(self, values: tuple[Any, ...]) -> list[Any]:
        """Return the values in the order of `pins`, 0 for a missing pin."""
        return [0 if at is None else values[at] for at in self._at]

    def _may_not_last(self) -> bool:
        """Return whether an unchanged state would be a violation in the next scan."""
        return False

    def _judge(self, before: list[Any], now: list[Any]) -> list[str]:
        return _id_of(now[0], now[1])


class _Level(_Instance):
    """A block that works while Enable is true."""

    pins = ("enable", "valid", "busy", "error", "errorid")

    def _judge(self, before: list[Any], now: list[Any]) -> list[str]:
        enable, valid, busy, error, error_id = now
        named = (("Valid", valid), ("Busy", busy), ("Error", error))
        shown = [name for name, value in named if value]
        broken = _together(shown)
        if self.has_id:
            broken += _id_of(error, error_id)
        if self.steady and not broken:
            if enable and not shown:
                broken.append("no Valid, Busy or Error while Enable is true")
            elif shown and not enable:
                broken.append(f"{shown[0]} is true while Enable is FALSE")
        return broken


class _Edge(_Instance):
    """A block that a rising edge of Execute starts."""

    pins = ("execute", "busy", "done", "error", "commandaborted", "active", "errorid")

    def _may_not_last(self) -> bool:
        execute, *rest = self._by_pin(self.before)
        return not execute and _Pins(*rest).end

    def _judge(self, before: list[Any], now: list[Any]) -> list[str]:
        was, pins = _Pins(*before[1:]), _Pins(*now[1:])
        broken = _together(pins.shown)
        if pins.active and not pins.busy:
            broken.append("Active is true without Busy")
        if self.has_id:
            broken += _id_of(pins.error, pins.error_id)
        if was.busy and not pins.shown and (self.outermost or self.steady):
            broken.append("Busy fell without an end; expected Done or Error for at least one scan")
        if self.steady and not broken:
            broken += _at_the_call(pins, was, bool(now[0]), bool(before[0]))
        return broken


class ContractMonitor:
    """A monitor of the contract for every block instance, also inside other blocks.

    It judges blocks with Execute, Busy, Done and Error, blocks with Enable and Error, and all other
    blocks with Error and ErrorID. The monitor judges an instance only if its pins have changed, or
    if an unchanged state would be a violation.

    Args:
        steady: Result of `steady_instances`: instances that their owner calls exactly once, and
            whose Execute or Enable no statement changes after the call. All rules are checked for
            an instance if its owner is also steady.
    """

    def __init__(self, program: Program, steady: Collection[str] = ()) -> None:
        known = frozenset(steady)
        self.instances = [
            found.kind(found)
            for name, kind in program.instances().items()
            if isinstance(kind, BlockType)
            for found in _all_inside(name, kind, known)
        ]
        """The watched instances."""
        self._look = program.reader([path for one in self.instances for path in one.read])
        self._seen: tuple[Any, ...] | None = None

    def scan(self, t_us: int, scan: int) -> list[Violation]:
        """Judge all instances after a scan."""
        seen = self._look()
        if seen == self._seen:
            return []
        pins = iter(seen)
        found = [
            Violation(t_us, "contract", f"plc, scan {scan}: contract: {instance.path}: {text}")
            for instance in self.instances
            if (now := tuple(islice(pins, len(instance.read)))) != instance.before
            or not instance.at_rest
            for text in instance.scan(now)
        ]
        at_rest = all(instance.at_rest for instance in self.instances)
        self._seen = seen if at_rest else None
        return found

    def snapshot(self) -> object:
        """Return the previous values of all instances."""
        return [(one.before, one.told) for one in self.instances]

    def restore(self, snapshot: list[tuple[tuple[Any, ...], tuple[str, ...]]]) -> None:
        """Restore the state from `snapshot`."""
        for instance, state in zip(self.instances, snapshot, strict=True):
            instance.before, instance.told = state
            instance.at_rest = False
        self._seen = None

    def begin(self) -> None:
        """Begin anew after a start of the PLC; an instance in VAR RETAIN still has its outputs."""
        pins = iter(self._look())
        for instance in self.instances:
            instance.begin(tuple(islice(pins, len(instance.read))))


class _Found(NamedTuple):
    """The data of an instance: its contract, path, pins and the blocks around it.

    Attributes:
        outermost: Whether a program declares the instance. A block may call an inner block twice in
            a scan.
        topmost: Whether no instance around it is watched. Only such an instance reports a call
            outside of FB_ReadArea and FB_WriteArea.
    """

    kind: type[_Instance]
    path: str
    names: dict[str, str]
    steady: bool
    outermost: bool
    topmost: bool


@lru_cache(maxsize=64)
def _all_inside(path: str, owner: BlockType, steady: frozenset[str]) -> tuple[_Found, ...]:
    """Return the watched instances of a program; they are the same for each cell with it."""
    return tuple(_inside(path, owner, steady, outermost=True, topmost=True))


def _inside(
    path: str, owner: BlockType, steady: Collection[str], *, outermost: bool, topmost: bool
) -> Iterator[_Found]:
    """Yield the watched instances declared in `owner`, and watched instances inside these."""
    for variable in owner.variables:
        block = variable.type
        if variable.section != "VAR" or not isinstance(block, BlockType):
            continue
        inner = f"{path}.{variable.name}"
        certain = f"{owner.name}.{variable.name}".upper() in steady
        names = {pin.name.lower(): pin.name for pin in block.variables if _is_pin(pin.type)}
        kind = _kind(names)
        if kind is not None:
            yield _Found(kind, inner, names, certain, outermost, topmost)
        yield from _inside(
            inner,
            block,
            steady if certain else (),
            outermost=False,
            topmost=topmost and kind is None,
        )


def _is_pin(kind: object) -> bool:
    return isinstance(kind, ElementaryType) and kind.name in ("BOOL", "WORD")


def _kind(names: Collection[str]) -> type[_Instance] | None:
    """Return the class that judges a block with these pins; None if the block has no such rules."""
    if all(pin in names for pin in ("execute", "busy", "done", "error")):
        return _Edge
    if "enable" in names and "error" in names:
        return _Level
    if "error" in names and "errorid" in names:
        return _Instance
    return None


_MOVE_IT = (
    "was called before FB_ReadArea or behind FB_WriteArea: it has ended with 16#8017, and nothing "
    "was executed; move the call between the two"
)


def _together(shown: Collection[str]) -> list[str]:
    if len(shown) < 2:
        return []
    return [f"{' and '.join(shown)} are true together; expected at most one"]


def _id_of(error: bool, error_id: int) -> list[str]:
    if bool(error) == (error_id != 0):
        return []
    return [
        f"Error is {str(bool(error)).upper()} with ErrorID 16#{error_id:04X}; "
        "Error is true exactly when ErrorID is not 0"
    ]


def _at_the_call(pins: _Pins, before: _Pins, execute: bool, saw: bool) -> list[str]:
    """Check the rules of a call; `execute` is Execute now, `saw` is Execute at the call before.

    A rising edge must show an output at once. Without an edge and without Busy before, no new
    output may appear. While Execute is true, an output must stay. After Execute has fallen, Done,
    Error or CommandAborted may be shown for one scan only.
    """
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
