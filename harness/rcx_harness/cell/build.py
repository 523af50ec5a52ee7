"""What a cell is made of besides its sources: robot, link and outputs, found and checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from rcx_harness.cell.clock import Agenda, Timing
from rcx_harness.cell.link import DirectLink, Link
from rcx_harness.cell.node import Member
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.spec.wire import check_size
from structured_text.bench.outputs import check_outputs
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml
from structured_text.output.units import whole

if TYPE_CHECKING:
    from rcx_harness.cell.elsewhere import Elsewhere

__all__ = [
    "Areas",
    "Robots",
    "check_outputs",
    "make_agenda",
    "make_link",
    "make_members",
    "make_robot",
    "several",
]

#: No process image is larger.
_LAST_BYTE = 0xFFFFFF

#: Properties of a robot, or a file of them; or several.
Robots = RobotConfig | str | Path | None | Sequence[RobotConfig | str | Path]
#: Where the area of the robot begins, in bytes; or of several robots.
Areas = int | Sequence[int]


def make_robot(
    robot: RobotConfig | str | Path | None, *, size: int | None, seed: int
) -> Controller:
    """A controller from its properties, or from a file of them.

    A size that is not said of the robot is that of the PLC's areas.

    Raises:
        InputError: the file cannot be read or is wrong, or no area has this size.
    """
    if size is not None:
        check_size(size)
    if isinstance(robot, RobotConfig):
        config = robot
    elif robot is None:
        config = RobotConfig() if size is None else RobotConfig(size=size)
    else:
        config = RobotConfig.load(robot)
        if size is not None and "size" not in load_toml(Path(robot)):
            config = replace(config, size=size)
    return Controller(config, seed=seed)


def several(robots: Robots) -> Sequence[RobotConfig | str | Path | None]:
    """The robots one by one, also where there is but one."""
    if robots is None or isinstance(robots, (RobotConfig, str, Path)):
        return [robots]
    return robots


def make_members(
    robots: Robots,
    link: str,
    *,
    size: int | None,
    m: Areas,
    n: Areas,
    timing: Timing,
    seed: int,
    connect: Elsewhere | None = None,
) -> list[Member]:
    """The controllers of a cell, each with its link and its areas.

    Raises:
        InputError: as `make_robot` and `make_link`; areas that overlap, or more than robots;
            properties of a controller that runs elsewhere.
    """
    if connect is not None:
        from rcx_harness.cell.elsewhere import FarLink

        if robots is not None:
            hint = "leave its properties out"
            raise InputError("a controller elsewhere is what it is", hint=hint)
        stand_in = make_robot(None, size=size, seed=seed)
        area = stand_in.config.size
        (begin_m,), (begin_n,) = _begins("m", m, [area]), _begins("n", n, [area])
        return [Member(stand_in, FarLink(area, timing, connect), begin_m, begin_n, far=True)]
    given = several(robots)
    if not given:
        raise InputError("no robot is given")
    if len(given) > 1 and link == "enip-realtime":
        raise InputError("in real time a cell has one robot", hint="run it without --realtime")
    made = [make_robot(one, size=size, seed=seed + k) for k, one in enumerate(given)]
    sizes = [one.config.size if size is None else size for one in made]
    places = zip(made, sizes, _begins("m", m, sizes), _begins("n", n, sizes), strict=True)
    members: list[Member] = []
    try:
        for one, area, begin_m, begin_n in places:
            members.append(Member(one, make_link(link, area, timing), begin_m, begin_n))
    except BaseException:
        for member in members:
            member.link.close()
        raise
    return members


def _begins(name: str, given: Areas, sizes: Sequence[int]) -> list[int]:
    """Where each robot's area begins: as given, the others behind the one before."""
    begins = list(given) or [0] if isinstance(given, Sequence) else [given]
    for begin in begins:
        whole(name, begin, -_LAST_BYTE, _LAST_BYTE)  # a negative one is refused with its image
    if len(begins) > len(sizes):
        raise InputError(f"{len(begins)} offsets {name}, but {len(sizes)} robot(s)")
    while len(begins) < len(sizes):
        begins.append(begins[-1] + sizes[len(begins) - 1])
    for (one, size), (other, _) in pairwise(sorted(zip(begins, sizes, strict=True))):
        if one + size > other:
            raise InputError(
                f"the areas at {name} = {one} and {name} = {other} overlap",
                hint=f"the first of them has {size} bytes",
            )
    return begins


def make_agenda(link: str, connect: Elsewhere | None = None) -> Agenda:
    """The agenda of a cell with this link: at the pace of the clock where its packets are."""
    if link != "enip-realtime" and connect is None:
        return Agenda()
    from rcx_harness.cell.live import RealTimeAgenda

    return RealTimeAgenda()


def make_link(name: str, size: int, timing: Timing) -> Link:
    """The link called `"direct"`, `"enip"` or `"enip-realtime"`.

    Raises:
        InputError: no such link.
    """
    if name == "direct":
        return DirectLink(size)
    if name == "enip":
        from rcx_harness.enip import LockstepLink  # the network only when it is asked for

        return LockstepLink(size)
    if name == "enip-realtime":
        from rcx_harness.cell.live import RealTimeLink

        return RealTimeLink(size, timing)
    raise InputError(f"unknown link {name!r}", hint="use direct or enip")
