"""Changes of a program that a user may make; each returns the changed program."""

from __future__ import annotations

import re
from dataclasses import fields, replace

from rcx_harness.robot import Axis, RobotConfig, RobotProgram
from rcx_tools.evidence.metamorphic.course import slowed
from rcx_tools.evidence.metamorphic.programs import Subject

__all__ = ["in_bytes", "in_words", "resized", "shifted", "slower"]

_OFFSET = re.compile(r"\b[mn]\s*:=\s*\d+\s*,\s*")
_SIZE = re.compile(r"\bSize\s*:=\s*\d+\s*,\s*")
_BOTH = re.compile(r"\b(FB_(?:Read|Write)(?:Bit|Port|Word|DoubleWord)|FB_RealTimeValue)\b")
_AREA = re.compile(r"\b(FB_(?:Read|Write)Area|RCX_IMAGE)\b")
_DELAY = re.compile(r"(?<=DELAY )\d+")
_TIME = re.compile(r"\bT#(\d+)(ms|s)\b", re.IGNORECASE)
_WRITE_AREA = re.compile(r"\bWriteArea\(Robot := Robot,")
_MARGIN = re.compile(r"\s*\bMargin\s*:=\s*T#\d+m?s\s*,")
#: Interval and Margin of FB_WriteArea if the program does not set them [ms].
_INTERVAL, _DEFAULT_MARGIN = 100, 150


def shifted(subject: Subject, m: int, n: int) -> Subject:
    """Return the program with the areas at other offsets of the images."""
    return _placed(subject, m, n, subject.size)


def resized(subject: Subject, size: int) -> Subject:
    """Return the program with areas of another size, at controller, scanner and blocks."""
    return _placed(subject, subject.m, subject.n, size)


def _placed(subject: Subject, m: int, n: int, size: int) -> Subject:
    files = {}
    for name, text in subject.files.items():
        changed = _SIZE.sub("", _OFFSET.sub("", text))
        changed = re.sub(
            r"Image := InputArea", f"Image := InputArea, m := {m}, Size := {size}", changed
        )
        changed = re.sub(
            r"Image := OutputArea", f"Image := OutputArea, n := {n}, Size := {size}", changed
        )
        files[name] = changed
    robot = replace(subject.robot, size=size)
    return replace(subject, files=files, m=m, n=n, size=size, robot=robot)


def in_words(subject: Subject) -> Subject:
    """Return the program with images of words instead of bytes, and the blocks for them."""
    files = {
        name: _AREA.sub(_words_of, _BOTH.sub(r"\1InWords", text))
        for name, text in subject.files.items()
    }
    return replace(subject, files=files)


def in_bytes(subject: Subject) -> Subject:
    """Return the program with images of bytes instead of words, and the blocks for them."""
    files = {
        name: re.sub(r"\bRCX_IMAGE_WORDS\b", "RCX_IMAGE", text)
        .replace("AreaWords", "Area")
        .replace("InWords", "")
        for name, text in subject.files.items()
    }
    return replace(subject, files=files)


def _words_of(match: re.Match[str]) -> str:
    name = match[1]
    return "RCX_IMAGE_WORDS" if name == "RCX_IMAGE" else f"{name}Words"


def slower(subject: Subject, factor: int) -> Subject:
    """Multiply every time of the program, its stimulus and the controller by a factor."""
    files = {}
    for name, text in subject.files.items():
        margin = re.search(r"Margin\s*:=\s*T#(\d+)ms", text)
        value = int(margin[1]) if margin else _DEFAULT_MARGIN
        pace = f" Interval := T#{_INTERVAL}ms, Margin := T#{value}ms,"
        changed = _WRITE_AREA.sub(lambda match, pace=pace: match[0] + pace, _MARGIN.sub("", text))  # type: ignore[misc]
        files[name] = _TIME.sub(lambda match: f"T#{int(match[1]) * factor}{match[2]}", changed)
    return replace(
        subject,
        files=files,
        stimulus=slowed(subject.stimulus, factor),
        robot=_slower_robot(subject.robot, factor),
    )


def _slower_robot(robot: RobotConfig, factor: int) -> RobotConfig:
    changed: dict[str, object] = {}
    for one in fields(robot):
        if one.name.endswith(("_delay", "_time")) or one.name in ("min_interval",):
            value = getattr(robot, one.name)
            ranged = isinstance(value, tuple)
            changed[one.name] = tuple(t * factor for t in value) if ranged else value * factor
    return replace(
        robot,
        axes=tuple(_slower_axis(axis, factor) for axis in robot.axes),
        programs=tuple(_slower_program(program, factor) for program in robot.programs),
        **changed,  # type: ignore[arg-type]
    )


def _slower_axis(axis: Axis, factor: int) -> Axis:
    return replace(
        axis,
        max_speed=axis.max_speed / factor,
        max_acceleration=axis.max_acceleration / factor**2,
    )


def _slower_program(program: RobotProgram, factor: int) -> RobotProgram:
    steps = [_DELAY.sub(lambda ms: str(int(ms[0]) * factor), step) for step in program.steps]
    return replace(program, duration=program.duration * factor, steps=tuple(steps))
