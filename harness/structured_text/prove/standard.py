"""The standard function blocks on terms, with the behaviour of `engines.builtin.blocks`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, Protocol

from structured_text.engines.builtin.blocks import counter_limits
from structured_text.language.dialects import rules_of
from structured_text.language.project import Project
from structured_text.language.scalars import ELEMENTARY
from structured_text.language.standard import BLOCKS
from structured_text.language.types import Type
from structured_text.prove import values
from structured_text.prove.logic import Bool, UnsupportedError, both, either, negated
from structured_text.prove.values import Value

__all__ = ["memory", "run"]

_BOOL, _TIME, _PHASE = ELEMENTARY["BOOL"], ELEMENTARY["TIME"], ELEMENTARY["USINT"]
_TIMER = (("before", "BOOL"), ("phase", "USINT"), ("start", "TIME"))
_MEMORY: dict[str, tuple[tuple[str, str], ...]] = {
    **dict.fromkeys(("R_TRIG", "F_TRIG"), (("seen", "BOOL"),)),
    **dict.fromkeys(("TON", "TOF", "TP"), _TIMER),
    "CTU": (("up", "BOOL"),),
    "CTD": (("down", "BOOL"),),
    "CTUD": (("up", "BOOL"), ("down", "BOOL")),
}


def _kind(name: str) -> str:
    return name if name.endswith("_TRIG") else name.removeprefix("L").partition("_")[0]


@cache
def memory(name: str) -> tuple[tuple[str, str], ...]:
    """Return the names and elementary types of an instance's variables, its pins first."""
    pins = [(pin.name, getattr(pin.type, "name", "")) for pin in BLOCKS[name].variables]
    return (*pins, *_MEMORY.get(_kind(name), ()))


class _Machine(Protocol):
    """The part of `machine.Machine` that the standard blocks use: memory and time."""

    now: Value
    project: Project

    def __getitem__(self, path: tuple[Any, ...]) -> Value: ...

    def __setitem__(self, path: tuple[Any, ...], value: Value) -> None: ...


class _Instance:
    """An instance of a standard block; `instance["PT"]` reads a pin or an internal variable."""

    def __init__(self, machine: _Machine, path: tuple[Any, ...], name: str) -> None:
        self._machine = machine
        self._path = path
        self._types: dict[str, Type] = {slot: ELEMENTARY[kind] for slot, kind in memory(name)}
        self.name = name
        self.rules = rules_of(machine.project.dialect)

    @property
    def now(self) -> Value:
        """Return the PLC's time in nanoseconds."""
        return self._machine.now

    def __getitem__(self, slot: str) -> Value:
        path = (*self._path, slot)
        return self._machine[path]

    def set(self, when: Bool, **slots: Value) -> None:
        """Set variables of the instance to these values if the condition holds."""
        for slot, value in slots.items():
            path = (*self._path, slot)
            before = self._machine[path]
            self._machine[path] = values.choose(when, value, before, self._types[slot])

    def kind(self, slot: str) -> Type:
        """Return the type of a variable of the instance."""
        return self._types[slot]

    def is_phase(self, phase: int) -> Bool:
        """Return the condition that a timer is in a phase: 0 idle, 1 running, 2 expired."""
        return values.compare("=", self["phase"], phase, _PHASE)

    def elapsed(self) -> Value:
        """Return the time since the timer was started."""
        return values.combine("-", self.now, self["start"], _TIME)


def run(machine: _Machine, path: tuple[Any, ...], name: str) -> None:
    """Run one call of a standard block, or raise UnsupportedError."""
    body = _BODIES.get(_kind(name))
    if body is None:
        raise UnsupportedError(f"the standard block {name} is not supported")
    body(_Instance(machine, path, name))


def _r_trig(s: Any) -> None:
    clk = s["CLK"]
    s.set(True, Q=both(clk, negated(s["seen"])), seen=clk)


def _f_trig(s: Any) -> None:
    low = negated(s["CLK"])
    s.set(True, Q=both(low, negated(s["seen"])), seen=low)


def _sr(s: Any) -> None:
    s.set(True, Q1=either(s["S1"], both(negated(s["R"]), s["Q1"])))


def _rs(s: Any) -> None:
    s.set(True, Q1=both(negated(s["R1"]), either(s["S"], s["Q1"])))


def _times(s: Any, running: Bool, **at_end: Value) -> None:
    """Update ET of a running timer, and end its time when ET has reached PT."""
    elapsed = s.elapsed()
    over = both(running, values.compare(">=", elapsed, s["PT"], _TIME))
    s.set(running, ET=elapsed)
    s.set(over, phase=2, ET=s["PT"], **at_end)


def _ton(s: Any) -> None:
    on = s["IN"]
    running = both(on, s.is_phase(1))
    begins = both(on, s.is_phase(0), negated(s["before"]))
    _times(s, running, Q=True)
    s.set(begins, phase=1, Q=False, start=s.now)
    s.set(negated(on), ET=0, phase=0, Q=False)
    s.set(True, before=on)


def _tof(s: Any) -> None:
    on = s["IN"]
    running = both(negated(on), s.is_phase(1))
    begins = both(negated(on), s.is_phase(0), s["before"])
    _times(s, running)
    s.set(begins, phase=1, start=s.now)
    s.set(on, ET=0, phase=0)
    s.set(True, Q=either(on, s.is_phase(1)), before=on)


def _tp(s: Any) -> None:
    on = s["IN"]
    running = s.is_phase(1)
    begins = both(s.is_phase(0), on, negated(s["before"]))
    _times(s, running, Q=False)
    s.set(begins, phase=1, Q=True, start=s.now)
    s.set(both(s.is_phase(2), negated(on)), ET=0, phase=0)
    s.set(True, before=on)


def _step(s: Any, when: Bool, by: int) -> None:
    kind = s.kind("CV")
    s.set(when, CV=values.combine("+" if by > 0 else "-", s["CV"], 1, kind))


def _below(s: Any) -> Bool:
    return values.compare("<", s["CV"], s["PV"], s.kind("CV"))


def _above(s: Any) -> Bool:
    return values.compare(">", s["CV"], 0, s.kind("CV"))


def _more(s: Any) -> Bool:
    """Return the condition that a counter may still count up."""
    most, _ = counter_limits(s.name, s.rules)
    return _below(s) if most is None else values.compare("<", s["CV"], most, s.kind("CV"))


def _less(s: Any) -> Bool:
    """Return the condition that a counter may still count down."""
    _, least = counter_limits(s.name, s.rules)
    return values.compare(">", s["CV"], least, s.kind("CV"))


def _ctu(s: Any) -> None:
    edge = both(s["CU"], negated(s["up"]), negated(s["R"]), _more(s))
    _step(s, edge, 1)
    s.set(s["R"], CV=0)
    s.set(True, up=s["CU"], Q=negated(_below(s)))


def _ctd(s: Any) -> None:
    edge = both(s["CD"], negated(s["down"]), negated(s["LD"]), _less(s))
    _step(s, edge, -1)
    s.set(s["LD"], CV=s["PV"])
    s.set(True, down=s["CD"], Q=negated(_above(s)))


def _ctud(s: Any) -> None:
    up, down = both(s["CU"], negated(s["up"])), both(s["CD"], negated(s["down"]))
    counts = negated(either(s["R"], s["LD"]))
    more = both(counts, up, negated(down), _more(s))
    less = both(counts, down, negated(up), _less(s))
    _step(s, more, 1)
    _step(s, less, -1)
    s.set(both(s["LD"], negated(s["R"])), CV=s["PV"])
    s.set(s["R"], CV=0)
    s.set(True, up=s["CU"], down=s["CD"], QU=negated(_below(s)), QD=negated(_above(s)))


_BODIES: dict[str, Callable[[Any], None]] = {
    "R_TRIG": _r_trig,
    "F_TRIG": _f_trig,
    "SR": _sr,
    "RS": _rs,
    "TON": _ton,
    "TOF": _tof,
    "TP": _tp,
    "CTU": _ctu,
    "CTD": _ctd,
    "CTUD": _ctud,
}
