"""What the keys of RobotConfig on clock, option slots and real time output may be."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.robot.config.checks import expect, near
from rcx_harness.robot.quantities import QUANTITIES

__all__ = ["DATA", "check_data", "read_items"]

DATA = ("clock", "option_slots", "real_time_items")
#: Item numbers of the real time output (guide, 4.9.1).
_ITEMS = range(1, 46)
_SLOTS = 4


def check_data(key: str, value: Any) -> None:
    """Refuse a value that one of the keys DATA cannot have.

    Raises:
        InputError: with what is allowed as the hint; the key is in single quotes.
    """
    if key == "clock":
        expect(_is_moment(value), key, value, 'date and time as "2014-01-01 10:59:59"')
    elif key == "option_slots":
        units = value if isinstance(value, tuple) else ()
        right = len(units) == _SLOTS and all(_is_unit(unit) for unit in units)
        expect(right, key, value, f"{_SLOTS} unit numbers, such as [0x0401, 0, 0, 0]")
    else:
        _check_items(key, value)


def read_items(key: str, value: Any) -> dict[int, str]:
    """`real_time_items` of a robot file: a table of item numbers and names.

    Raises:
        InputError: it is not.
    """
    if not isinstance(value, dict) or not all(number.isdecimal() for number in value):
        raise InputError(f"'{key}' must be a table", hint=f'write 13 = "motor_duty" in [{key}]')
    return {int(number): name for number, name in value.items()}


def _check_items(key: str, value: Mapping[int, Any]) -> None:
    for number, name in value.items():
        expect(number in _ITEMS, key, number, f"an item number, {_ITEMS[0]} to {_ITEMS[-1]}")
        if name not in QUANTITIES:
            hint = near(name, QUANTITIES) if isinstance(name, str) else ", ".join(QUANTITIES)
            raise InputError(f"'{key}' cannot have {name!r}", hint=hint)


def _is_moment(value: Any) -> bool:
    try:
        return 2000 <= datetime.strptime(value, "%Y-%m-%d %H:%M:%S").year <= 2099
    except (TypeError, ValueError):
        return False


def _is_unit(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= 0xFFFF
