"""Types, numbers and names of the data that the controller stores or shows, except programs."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any

from rcx_harness.spec import command

__all__ = [
    "AXES",
    "COUNTS",
    "EXAMPLE_POINTS",
    "FIRST_REAL",
    "HIGH_WORD",
    "PALLET_POINTS",
    "PARAMETER_DEFAULTS",
    "QUANTITIES",
    "QUANTITIES_OF_AXIS",
    "ROBOTS",
    "ROBOT_PARAMETERS",
    "VARIABLES",
    "Hand",
    "Pallet",
    "Point",
    "Shift",
    "fits_integer",
    "from_bits",
    "nearest",
    "parameter_names",
    "parameter_ranges",
    "single",
    "to_bits",
    "variable_number",
]

AXES = 6
ROBOTS = 4
#: Maps a kind of data to the number of its entries, which count from 0 (guide, 4.3).
COUNTS = {"points": 30000, "comments": 30000, "pallets": 40, "shifts": 40, "hands": 32}
#: Number of consecutive points that define a pallet.
PALLET_POINTS = 5
#: Number of static variables of each type; SGR0 has the number 256 (guide, 4.4.1).
VARIABLES = 32
FIRST_REAL = 256
#: The parameters that belong to a robot. All other parameters belong to an axis (guide, 4.4.2).
ROBOT_PARAMETERS = ("WEIGHT", "WEIGHTG")
#: The factory values of the parameters. They are assumed, because the manual does not give them.
PARAMETER_DEFAULTS = {
    "WEIGHTG": 0,
    "ACCEL": 100,
    "DECEL": 100,
    "TOLE": 80,
    "OUTPOS": 2000,
    "AXWGHT": 0,
    "ARCHP1": 2000,
    "ARCHP2": 2000,
    "PSHFRC": 100,
    "PSHTIME": 1000,
    "PSHMTD": 0,
    "PSHJGSP": 0,
    "PSHSPD": 100,
}

#: Quantities of the real time output (guide, 4.9). The list of item numbers is in another manual.
#: The guide gives only item 13, motor duty. The items therefore have names here, and the
#: configuration maps numbers to these names. For an axis, option 1 is the robot and option 2 the
#: axis.
QUANTITIES_OF_AXIS = (
    "motor_duty",
    "torque_of_max",
    "torque_of_rated",
    "position_pulses",
    "servo_state",
    "servo_on_count",
    "servo_on_time",
    "moving_distance",
)
_OF_SYSTEM = ("power_on_count", "motor_power_on_count", "operating_time")
HIGH_WORD = ".high"
#: The names of all items. The suffix `.high` means the upper word of a value with two words.
QUANTITIES = tuple(
    name + half for name in (*QUANTITIES_OF_AXIS, *_OF_SYSTEM) for half in ("", HIGH_WORD)
)

#: Maps four bits of a telegram to an arm rotation. All other patterns mean 0.
_TURNS = {1: 1, 15: -1}

#: The data of a shift for axes 1 to 4 [0.001 mm, 0.001 degree] (guide, 4.3.4).
Shift = tuple[int, int, int, int]


@dataclass(frozen=True)
class Point:
    """Point data (guide, 4.3.1): `data` per axis as on the wire, pulses or 0.001 mm.

    `hand` is 0 (none), 1 (right-handed) or 2 (left-handed); `arm1` and `arm2` are -1, 0 or 1.
    """

    data: tuple[int, ...] = (0,) * AXES
    mm: bool = False
    hand: int = 0
    arm1: int = 0
    arm2: int = 0

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> Point:
        """Create a point from the fields of a telegram (guide, 4.3.1)."""
        arm1, arm2 = (_TURNS.get(fields[name], 0) for name in ("arm1", "arm2"))
        hand = fields["hand"] % 3  # both 0 and 3 mean no hand
        return cls(tuple(fields["positions"]), bool(fields["unit"]), hand, arm1, arm2)

    @property
    def fields(self) -> dict[str, Any]:
        """Return the fields of a telegram for this point."""
        turns = {"arm1": self.arm1 & 0xF, "arm2": self.arm2 & 0xF}
        return {"unit": int(self.mm), "hand": self.hand, **turns, "positions": self.data}


@dataclass(frozen=True)
class Pallet:
    """Pallet data (guide, 4.3.3): numbers of work positions in X, Y and Z, and the first point."""

    nx: int
    ny: int
    nz: int
    first: int

    @property
    def count(self) -> int:
        """Return the number of work positions of the pallet, which count from 1."""
        return self.nx * self.ny * self.nz

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> Pallet:
        """Create a pallet from the fields of a telegram."""
        return cls(fields["nx"], fields["ny"], fields["nz"], fields["first_point"])

    @property
    def fields(self) -> dict[str, int]:
        """Return the fields of a telegram for this pallet."""
        return {"nx": self.nx, "ny": self.ny, "nz": self.nz, "first_point": self.first}


@dataclass(frozen=True)
class Hand:
    """Hand data (guide, 4.3.5) as on the wire, in 0.001 mm; data 4 is 1 for a hand on the R axis.

    Data 1 of a SCARA robot's hand that is not on the R axis is an integer without scale.
    """

    data: tuple[int, int, int, int] = (0, 0, 0, 0)

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> Hand:
        """Create a hand from the fields of a telegram."""
        return cls((fields["data1"], fields["data2"], fields["data3"], fields["data4"]))

    @property
    def fields(self) -> dict[str, int]:
        """Return the fields of a telegram for this hand."""
        return {f"data{k}": value for k, value in enumerate(self.data, 1)}

    @property
    def on_r_axis(self) -> bool:
        """Return whether the hand is mounted on the R axis, so that it turns with this axis."""
        return self.data[3] == 1


#: The default points, with which the manual's examples run without a robot file: point 19 (guide,
#: 2; the data are our own), point 100 (4.2.1) and point 50 (4.3.1).
EXAMPLE_POINTS = {
    19: Point((120_000, -45_000, 30_000, 0, 0, 0)),
    50: Point((10_000, -20_000, 5_000, -18_000, 0, 0), mm=True),
    100: Point((123_456, -123, 0, 0, 0, 0)),
}


def variable_number(name: str) -> int | None:
    """Return the remote command number of a variable such as `SGI5`; None for any other name."""
    found = re.fullmatch(r"SG([IR])0*([0-9]{1,2})", name)
    if not found or int(found[2]) >= VARIABLES:
        return None
    return int(found[2]) + (FIRST_REAL if found[1] == "R" else 0)


@lru_cache(maxsize=1)
def parameter_names() -> Mapping[int, str]:
    """Return the names of the parameters by number, from the table of remote commands."""
    field = next(part for part in command("WriteParameter").request if part.name == "parameter")
    return {number: text.partition(",")[0] for number, text in field.values.items()}


@lru_cache(maxsize=1)
def parameter_ranges() -> Mapping[str, tuple[float, float]]:
    """Return the lowest and highest value of each parameter, from the table of commands."""
    field = next(part for part in command("WriteParameter").request if part.name == "value")
    return {parameter_names()[k]: (pair[0], pair[-1]) for k, pair in field.ranges.items()}


# Functions for the number formats of the controller: 32 bit integers, single-precision reals.


def fits_integer(value: int) -> bool:
    """Return whether the value fits into a signed integer of 32 bits."""
    return -(2**31) <= value < 2**31


def nearest(value: Fraction) -> int:
    """Return the nearest integer; a half is rounded away from 0."""
    size = math.floor(abs(value) + Fraction(1, 2))
    return size if value >= 0 else -size


def single(value: float) -> float:
    """Return the nearest single-precision number; infinity if the value is too large."""
    try:
        return from_bits(to_bits(value))
    except OverflowError:
        return math.copysign(math.inf, value)


def from_bits(bits: int) -> float:
    """Return the single-precision number whose 32 bits are `bits`, signed or unsigned."""
    value: float = struct.unpack("<f", struct.pack("<I", bits & 0xFFFFFFFF))[0]
    return value


def to_bits(value: float) -> int:
    """Return the bits of a single-precision number as a signed integer."""
    bits: int = struct.unpack("<i", struct.pack("<f", value))[0]
    return bits
