"""Compare the library's SCARA kinematics with the model's.

The poses are random, and cover every SCARA robot of spec/robots.toml within its soft limits. Hands
are on the R axis or not; shifts, distant zeros and whole turns occur. Both blocks are compared with
the virtual controller's arithmetic in double precision. For FB_ScaraInverse, the tool position of
its pulses is also compared with the requested position.
"""

from __future__ import annotations

import random
import struct
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from rcx_harness.cell.sources import default_lib
from rcx_harness.robot.config.models import axis_keys
from rcx_harness.robot.geometry import Frame
from rcx_harness.robot.kinematics import Scara
from rcx_harness.spec.robots import robot_models
from structured_text.engines import build
from structured_text.projects.needed import needed

#: Pulses are not compared if axis 2 is closer than this angle to the stretched or folded arm [deg].
_NEAR = 20.0
#: If pulses differ by more than this limit, they belong to another pose [pulse].
_SAME = 1000
_MOST_HAND, _MOST_SHIFT = 300, 500
#: Additional tolerance for a shift and a hand on the R axis, and another for distant zeros [pulse].
_MOST_TURNS, _MOST_ZERO = 10, 900_000_000

#: Tolerances as in the header comments of the blocks. The keys are attributes of `Worst`.
LIMITS = {"place": 0.002, "turn": 0.001, "pulses": 2.0, "back": 0.02}

_PROGRAM = """PROGRAM Kinematics
  VAR
    Arm     : RCX_SCARA;
    Pulses  : RCX_PULSES;
    Place   : RCX_POSITION;
    Hand    : RCX_HAND_SYSTEM;
    Forward : FB_ScaraForward;
    Inverse : FB_ScaraInverse;
  END_VAR
  Forward(Arm := Arm, Pulses := Pulses);
  Inverse(Arm := Arm, PositionMm := Place, HandSystem := Hand);
END_PROGRAM
"""


@dataclass(frozen=True)
class Pose:
    """A robot, its hand and shift, and the positions of its axes.

    Attributes:
        model: Name in spec/robots.toml.
        hand: Hand data 1 to 3 as on the wire.
        on_r: Whether the hand is on the R axis.
        shift: X, Y, Z and R [0.001 mm, 0.001 degree].
        pulses: Pulses of axes 1 to 4.
        away: Distance of the axes' zeros from those of the model [pulse].
    """

    model: str
    hand: tuple[int, int, int]
    on_r: bool
    shift: tuple[int, int, int, int]
    pulses: tuple[int, ...]
    away: tuple[int, ...] = (0, 0, 0, 0)

    @property
    def zeros(self) -> tuple[int, ...]:
        """Return the pulses of axes 1 to 4 at 0 degrees and 0 mm."""
        own = (axis["zero"] for axis in _axes(self.model))
        return tuple(zero + by for zero, by in zip(own, self.away, strict=True))

    def frame(self, *, left: bool = False) -> Frame:
        """Return the controller's coordinates, as `rcx_harness.robot.arm` calculates them."""
        return _frame(self.model, self.hand, self.on_r, self.shift, self.zeros, left)

    def arm(self) -> dict[str, Any]:
        """Return the fields of RCX_SCARA."""
        axes = _axes(self.model)
        arm1, arm2 = robot_models()[self.model].arms
        data1, data2, data3 = self.hand
        return {
            "Arm1": float(arm1),
            "Arm2": float(arm2),
            "PulsesPerUnit": [*(axis["pulses_per_mm"] for axis in axes), 0.0, 0.0],
            "Zero": [*self.zeros, 0, 0],
            "HandMount": "HAND_ON_R_AXIS" if self.on_r else "HAND_NOT_ON_R_AXIS",
            "HandData1": data1 / 1000 if self.on_r else 0.0,
            "HandData1Integer": 0 if self.on_r else data1,
            "HandData2": data2 / 1000,
            "HandData3": data3 / 1000,
            "Shift": [one / 1000 for one in self.shift],
        }


@dataclass
class Worst:
    """The largest differences between the blocks and the model.

    Attributes:
        poses: Number of poses.
        place: Largest position difference of the forward direction [mm].
        turn: Largest R difference of the forward direction [degree].
        pulses: Largest difference between inverse and model, if the arm is not nearly straight.
        back: Largest distance between the requested position and the position of FB_ScaraInverse's
        pulses [mm].
        The rounding to whole pulses is part of it.
    """

    poses: int = 0
    place: float = 0.0
    turn: float = 0.0
    pulses: float = 0.0
    back: float = 0.0


@cache
def _axes(model: str) -> list[dict[str, Any]]:
    return axis_keys(model, 1)


@lru_cache(maxsize=8)
def _frame(
    model: str,
    hand: tuple[int, int, int],
    on_r: bool,
    shift: tuple[int, int, int, int],
    zeros: tuple[int, ...],
    left: bool,
) -> Frame:
    axes = _axes(model)
    arm1, arm2 = (1000.0 * one for one in robot_models()[model].arms)
    offset, tool = 0.0, hand
    if not on_r:
        offset = 1000 * hand[0] / axes[1]["pulses_per_mm"]
        arm2, tool = arm2 + hand[1], (0, 0, hand[2])
    return Frame(
        tuple(axis["pulses_per_mm"] for axis in axes),
        shift=shift,
        hand=tool,
        on_r=on_r,
        zeros=zeros,
        kinematics=Scara(arm1, arm2, offset, left=left),
    )


def poses(chance: random.Random, each: int) -> Iterator[Pose]:
    """Return poses of all SCARA robots, `each` poses for every robot.

    Every tenth pose has a new hand, shift and zeros.
    """
    for name, model in robot_models().items():
        if not model.scara:
            continue
        axes = _axes(name)
        hand, on_r, shift, turns = (0, 0, 0), True, (0, 0, 0, 0), 0
        away: tuple[int, ...] = (0, 0, 0, 0)
        for number in range(each):
            if number % 10 == 9:
                on_r = chance.random() < 0.5
                lengths = [chance.randint(-1000 * _MOST_HAND, 1000 * _MOST_HAND) for _ in range(3)]
                if not on_r:  # data 1 turns the hand by up to half a turn, data 2 lengthens arm 2
                    most = round(180 * axes[1]["pulses_per_mm"])
                    lengths = [chance.randint(-most, most), abs(lengths[1]), lengths[2]]
                hand = (lengths[0], lengths[1], lengths[2])
                moved = [chance.randint(-1000 * _MOST_SHIFT, 1000 * _MOST_SHIFT) for _ in range(3)]
                turn = 360_000 * chance.randint(-_MOST_TURNS, _MOST_TURNS)
                # a multiple of 0.125 degrees, which is exact in a REAL
                turn += 125 * chance.randint(-1440, 1440)
                shift = (moved[0], moved[1], moved[2], turn)
                away = tuple(chance.randint(-_MOST_ZERO, _MOST_ZERO) for _ in axes)
                turns = chance.randint(-_MOST_TURNS, _MOST_TURNS)
            own = [chance.randint(axis["soft_low"], axis["soft_high"]) for axis in axes]
            own[3] += round(360 * turns * axes[3]["pulses_per_mm"])
            pulses = tuple(one + by for one, by in zip(own, away, strict=True))
            yield Pose(name, hand, on_r, shift, pulses, away)


def compare(some: Iterable[Pose], engine: str = "auto") -> Worst:
    """Run both blocks for these poses, and return the largest differences from the model.

    Args:
        some: The poses. The run is faster if poses with the same robot and hand follow each other.
        engine: The engine that runs the blocks.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "Kinematics.st"
        file.write_text(_PROGRAM, encoding="utf-8")
        library = sorted(default_lib().rglob("*.st"))
        program = build([file, *needed([file], library)], engine).program
    worst = Worst()
    equipment: tuple[object, ...] = ()
    look = program.reader(
        ["Main.Forward.PositionMm", "Main.Forward.ErrorID", "Main.Inverse.Pulses",
         "Main.Inverse.ErrorID", "Main.Forward.HandSystem"]
    )  # fmt: skip
    for pose in some:
        if equipment != (pose.model, pose.hand, pose.shift, pose.away):
            equipment = (pose.model, pose.hand, pose.shift, pose.away)
            for field, value in pose.arm().items():
                program.write(f"Main.Arm.{field}", value)
        frame = pose.frame()
        bend = frame.bend(pose.pulses) or 0.0
        place = frame.to_mm(pose.pulses)
        asked = [_real(round(one) / 1000) for one in place]
        hand = "HAND_LEFT" if bend < 0 else "HAND_RIGHT"
        program.write("Main.Pulses", [*pose.pulses, 0, 0])
        program.write("Main.Place", [*asked, 0.0, 0.0])
        program.write("Main.Hand", hand)
        program.scan(0)
        found, no_place, pulses, no_pulses, shown = look()
        if no_place or no_pulses or shown != hand:
            raise AssertionError(f"{pose}: {no_place:04X} {no_pulses:04X} {shown}")
        _note(worst, pose, bend, place, found, [1000 * one for one in asked], pulses)
    return worst


def _note(
    worst: Worst,
    pose: Pose,
    bend: float,
    place: Sequence[float],
    found: Sequence[float],
    asked: Sequence[float],
    pulses: Sequence[int],
) -> None:
    """Update the largest differences with `found` against `place`, and `pulses` against `asked`."""
    worst.poses += 1
    apart = max(abs(a - b / 1000) for a, b in zip(found[:3], place[:3], strict=True))
    worst.place = max(worst.place, apart)
    worst.turn = max(worst.turn, abs(found[3] - place[3] / 1000))
    if _NEAR <= abs(bend) <= 180 - _NEAR:
        exact = pose.frame(left=bend < 0).to_pulses(asked)
        gap = max(abs(a - b) for a, b in zip(pulses[:4], exact, strict=True))
        worst.pulses = max(worst.pulses, gap)
        if any(abs(a - b) > _SAME for a, b in zip(pulses, pose.pulses, strict=False)):
            raise AssertionError(f"{pose}: {pulses} belong to another pose")
    there = pose.frame().to_mm(pulses[:4])
    way = max(abs(a - b) / 1000 for a, b in zip(there[:3], asked[:3], strict=True))
    worst.back = max(worst.back, way)


def _real(value: float) -> float:
    """Return the number as a REAL, which differs by up to 0.00024 near 8000 degrees."""
    return float(struct.unpack("f", struct.pack("f", value))[0])
