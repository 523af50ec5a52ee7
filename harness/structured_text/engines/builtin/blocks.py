"""The standard function blocks, as the generated code calls them.

Each class represents an instance of a block. Slots in upper case hold the pins, and slots in lower
case the block's memory. All of them are scalars. The timers read the PLC time [ns] from
`clock.now`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from structured_text.language.dialects import Dialect
from structured_text.language.scalars import INT_RANGE
from structured_text.language.standard import BLOCKS
from structured_text.language.types import type_name

__all__ = ["CLASSES", "bodies", "counter_limits"]

_Counter = Callable[[Any, int | None, int], None]


def _class(name: str, memory: tuple[str, ...]) -> type[Any]:
    """Return a class with the pins of a standard block and its memory, all initially FALSE or 0."""
    pins = {
        pin.name: False if getattr(pin.type, "name", "") == "BOOL" else 0
        for pin in BLOCKS[name].variables
    }
    start: dict[str, Any] = {**pins, **dict.fromkeys(memory, 0)}

    def initialise(self: Any, clock: Any) -> None:
        self.clock = clock
        for slot, value in start.items():
            setattr(self, slot, value)

    return type(f"b_{name}", (), {"__slots__": (*start, "clock"), "__init__": initialise})


def _r_trig(s: Any) -> None:
    clk = s.CLK
    s.Q = clk and not s.seen
    s.seen = clk


def _f_trig(s: Any) -> None:
    # By the standard, F_TRIG also reports a falling edge if CLK is FALSE in the first call.
    clk = s.CLK
    s.Q = not clk and not s.seen
    s.seen = not clk


def _sr(s: Any) -> None:
    s.Q1 = s.S1 or (not s.R and s.Q1)


def _rs(s: Any) -> None:
    s.Q1 = not s.R1 and (s.S or s.Q1)


# The timers have three phases: 0 idle, 1 running, 2 expired. The call that starts a timer does not
# compare the time yet. Therefore PT = 0 expires one call later.


def _ton(s: Any) -> None:
    if not s.IN:
        s.ET = s.phase = 0
        s.Q = False
    elif s.phase == 1:
        elapsed = s.clock.now - s.start
        if elapsed >= s.PT:
            s.phase = 2
            s.Q = True
            s.ET = s.PT
        else:
            s.ET = elapsed
    elif s.phase == 0 and not s.before:
        s.phase = 1
        s.Q = False
        s.start = s.clock.now
    s.before = s.IN


def _tof(s: Any) -> None:
    if s.IN:
        s.ET = s.phase = 0
    elif s.phase == 1:
        elapsed = s.clock.now - s.start
        if elapsed >= s.PT:
            s.phase = 2
            s.ET = s.PT
        else:
            s.ET = elapsed
    elif s.phase == 0 and s.before:
        s.phase = 1
        s.start = s.clock.now
    s.Q = s.IN or s.phase == 1
    s.before = s.IN


def _tp(s: Any) -> None:
    if s.phase == 0:
        if s.IN and not s.before:
            s.phase = 1
            s.Q = True
            s.start = s.clock.now
    elif s.phase == 1:
        elapsed = s.clock.now - s.start
        if elapsed >= s.PT:
            s.phase = 2
            s.Q = False
            s.ET = s.PT
        else:
            s.ET = elapsed
    if s.phase == 2 and not s.IN:
        s.ET = s.phase = 0
    s.before = s.IN


# The values of CV at which a counter stops counting depend on the dialect. As a limit, None means
# the value of PV.


def _ctu(s: Any, most: int | None, least: int) -> None:
    edge = s.CU and not s.up
    s.up = s.CU
    if s.R:
        s.CV = 0
    elif edge and (s.PV if most is None else most) > s.CV:
        s.CV += 1
    s.Q = s.CV >= s.PV


def _ctd(s: Any, most: int | None, least: int) -> None:
    edge = s.CD and not s.down
    s.down = s.CD
    if s.LD:
        s.CV = s.PV
    elif edge and least < s.CV:
        s.CV -= 1
    s.Q = s.CV <= 0


def _ctud(s: Any, most: int | None, least: int) -> None:
    up, down = s.CU and not s.up, s.CD and not s.down
    s.up, s.down = s.CU, s.CD
    if s.R:
        s.CV = 0
    elif s.LD:
        s.CV = s.PV
    elif up != down:
        if up and (s.PV if most is None else most) > s.CV:
            s.CV += 1
        elif down and least < s.CV:
            s.CV -= 1
    s.QU = s.CV >= s.PV
    s.QD = s.CV <= 0


_TIMER = ("before", "phase", "start")
_KINDS: dict[str, tuple[Callable[[Any], None], tuple[str, ...]]] = {
    "R_TRIG": (_r_trig, ("seen",)),
    "F_TRIG": (_f_trig, ("seen",)),
    "SR": (_sr, ()),
    "RS": (_rs, ()),
    "TON": (_ton, _TIMER),
    "TOF": (_tof, _TIMER),
    "TP": (_tp, _TIMER),
}
_COUNTERS: dict[str, tuple[_Counter, tuple[str, ...]]] = {
    "CTU": (_ctu, ("up",)),
    "CTD": (_ctd, ("down",)),
    "CTUD": (_ctud, ("up", "down")),
}
# A counter exists for each integer type, and a timer for TIME and for LTIME.
_NAMES = {name: name.removeprefix("L").partition("_")[0] for name in BLOCKS}
_NAMES.update({name: name for name in ("R_TRIG", "F_TRIG")})

#: Maps the name of a standard block to the class of its instances.
CLASSES = {
    name: _class(name, _COUNTERS[kind][1] if kind in _COUNTERS else _KINDS[kind][1])
    for name, kind in _NAMES.items()
}


def _counting(body: _Counter, most: int | None, least: int) -> Callable[[Any], None]:
    """Return a function that executes a counter, which stops counting at `most` and `least`."""
    return lambda instance: body(instance, most, least)


def counter_limits(name: str, rules: Dialect) -> tuple[int | None, int]:
    """Return the greatest and the least value of CV at which a counter stops; None means PV."""
    if rules.counters == "preset":
        return None, 0
    (kind,) = (pin.type for pin in BLOCKS[name].variables if pin.name == "CV")
    low, high = INT_RANGE[type_name(kind)]
    return high, 0 if rules.counters == "unsigned" else low


def bodies(rules: Dialect) -> dict[str, Callable[[Any], None]]:
    """Return a dict from the name of each standard block to the function that executes it."""
    found: dict[str, Callable[[Any], None]] = {}
    for name, kind in _NAMES.items():
        if kind in _COUNTERS:
            most, least = counter_limits(name, rules)
            found[name] = _counting(_COUNTERS[kind][0], most, least)
        else:
            found[name] = _KINDS[kind][0]
    return found
