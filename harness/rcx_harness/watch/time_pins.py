"""Times at pins of blocks that may not suit the packet interval of the connection.

A `Timeout` below one interval ends before an answer can arrive. A `Margin` that is too small lets
two changes of dedicated inputs arrive at the controller less than 100 ms apart
(docs/explanation/scan-model.md, dedicated inputs).
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from rcx_harness.watch.robots_used import Call, RobotsUsed
from structured_text.language import tree as t
from structured_text.language.syntax import Position
from structured_text.output.units import format_us

__all__ = ["MARGIN", "TIMEOUT", "TimePin", "time_of"]

#: The kinds of the two mistakes: sections of docs/how-to/first-mistakes.md.
TIMEOUT, MARGIN = "short-timeout", "small-margin"

#: Cycle in which the controller reads its inputs [us].
_CYCLE_US = 5_000
#: Nanoseconds in a microsecond; a TIME is a number of nanoseconds.
_NS = 1_000


class TimePin(NamedTuple):
    """A pin `Timeout` or `Margin` with a constant value.

    Attributes:
        file: The file with the call.
        at: The position of the call.
        kind: `TIMEOUT` or `MARGIN`.
        name: The name of the called instance.
        value_us: The value of the pin.
    """

    file: Path
    at: Position
    kind: str
    name: str
    value_us: int

    def mistake(self, rpi_us: int, jitter_us: int) -> str:
        """Return why the value does not suit a connection; empty if it does."""
        if self.kind == TIMEOUT:
            return self._timeout(rpi_us)
        least_us = rpi_us + jitter_us + _CYCLE_US
        if self.value_us >= least_us:
            return ""
        return (
            f"Margin of {self.name} is {format_us(max(0, self.value_us))}, but a packet interval "
            f"of {format_us(rpi_us)} with a jitter of {format_us(jitter_us)} needs at least "
            f"{format_us(least_us)}: two changes of dedicated inputs can reach the controller "
            f"less than 100 ms apart; write Margin := T#{-(-least_us // 1000)}ms or more"
        )

    def _timeout(self, rpi_us: int) -> str:
        if not 0 < self.value_us < rpi_us:
            return ""
        return (
            f"Timeout of {self.name} is {format_us(self.value_us)}, less than one packet interval "
            f"({format_us(rpi_us)}): the answer of the controller cannot arrive in this time, "
            "and the block ends in error; give it a longer Timeout, or T#0s for no limit"
        )


def time_of(call: Call, pin: str, used: RobotsUsed) -> int | None:
    """Return the value of a pin [us]; None if the source does not decide it.

    Without an argument it is the initial value of the instance, or else of the block.
    """
    if (call.block.name.upper(), pin.upper()) in used.set_apart:
        return None
    given = [value for name, value in call.node.inputs if name.upper() == pin.upper()]
    value: object
    if given:
        value = given[0].value if isinstance(given[0], t.Constant) else None
    else:
        instance = call.node.instance
        start = instance.symbol.initial if isinstance(instance, t.Use) else None
        own = start.get(pin) if isinstance(start, dict) else None
        value = own if own is not None else used.initial_of(call.block, pin)
    return value // _NS if isinstance(value, int) else None
