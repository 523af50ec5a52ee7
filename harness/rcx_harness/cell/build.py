"""Construction of a cell's robots, links and agenda from the user's arguments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from rcx_harness.cell.clock import Timing
from rcx_harness.cell.link import DirectLink, Link
from rcx_harness.cell.node import Member
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.spec.wire import check_size
from structured_text.bench.agenda import Agenda
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml
from structured_text.output.units import whole

__all__ = ["Areas", "Robots", "make_agenda", "make_link", "make_members", "make_robot", "several"]

if TYPE_CHECKING:
    from rcx_harness.cell.elsewhere import Elsewhere

#: The largest offset of an area in a process image [bytes].
_LAST_BYTE = 0xFFFFFF

#: The robots of a cell: properties of a robot, a robot file, or a sequence of both.
Robots = RobotConfig | str | Path | None | Sequence[RobotConfig | str | Path]
#: The offset of a robot's area in bytes, or the offsets of the areas of several robots.
Areas = int | Sequence[int]


def make_robot(
    robot: RobotConfig | str | Path | None, *, size: int | None, seed: int
) -> Controller:
    """Return a controller made from its properties or from a robot file.

    If the properties contain no size, the size of the PLC's areas is used.
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
    """Return the robots as a sequence; a single robot becomes a sequence of length 1."""
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
    """Return the controllers of a cell, each with its link and its areas."""
    if connect is not None:
        from rcx_harness.cell.elsewhere import FarLink

        if robots is not None:
            hint = "leave --robot out, in Python robots="
            raise InputError("an external controller cannot be configured", hint=hint)
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
    """Return the offset of each robot's area.

    Without a given offset, an area follows the last area.
    """
    begins = list(given) or [0] if isinstance(given, Sequence) else [given]
    for begin in begins:
        # find_image later rejects negative offsets
        whole(name, begin, -_LAST_BYTE, _LAST_BYTE)
    if len(begins) > len(sizes):
        raise InputError(f"{len(begins)} offsets {name} are given for {len(sizes)} robot(s)")
    while len(begins) < len(sizes):
        begins.append(begins[-1] + sizes[len(begins) - 1])
    for (one, size), (other, _) in pairwise(sorted(zip(begins, sizes, strict=True))):
        if one + size > other:
            raise InputError(
                f"the areas at {name} = {one} and {name} = {other} overlap",
                hint=f"leave {size} bytes for the first of them",
            )
    return begins


def make_agenda(link: str, connect: Elsewhere | None = None) -> Agenda:
    """Return the agenda of a cell; with a link in real time, the agenda waits for the clock."""
    if link != "enip-realtime" and connect is None:
        return Agenda()
    from rcx_harness.cell.live import RealTimeAgenda

    return RealTimeAgenda()


def make_link(name: str, size: int, timing: Timing) -> Link:
    """Create the link named `"direct"`, `"enip"` or `"enip-realtime"`."""
    if name == "direct":
        return DirectLink(size)
    if name == "enip":
        # import the network only if it is used
        from rcx_harness.enip.links import LockstepLink

        return LockstepLink(size)
    if name == "enip-realtime":
        from rcx_harness.cell.live import RealTimeLink

        return RealTimeLink(size, timing)
    raise InputError(f"unknown link {name!r}", hint="use direct or enip")
