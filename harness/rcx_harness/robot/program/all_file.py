"""The reader of a file with all data of a controller (.ALL): programs, points and other data.

The file has sections that begin with a name in brackets, such as `[PGM]`. Unknown sections and
lines are skipped and listed in `passed_over`. The format is assumed: it is derived from public
files. If the vendor's manual differs, the manual is right.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from rcx_harness.robot.program.reader import text_of
from rcx_harness.robot.stored import (
    AXES,
    COUNTS,
    ROBOT_PARAMETERS,
    Hand,
    Pallet,
    Point,
    Shift,
    parameter_ranges,
    variable_number,
)
from structured_text.errors import InputError

__all__ = ["AllFile", "Source", "data_point", "read_all"]

_SECTION = re.compile(r"\s*\[([A-Z0-9_]+)\]\s*$", re.IGNORECASE)
_NAME = re.compile(r"\s*NAME\s*=\s*(\S+)\s*$", re.IGNORECASE)
_ENTRY = re.compile(r"\s*([A-Z]+)(\d+)\s*=\s*(.*?)\s*$", re.IGNORECASE)
_PALLET = re.compile(r"\s*PL(\d+)\s*$", re.IGNORECASE)
_PALLET_PART = re.compile(r"(NX|NY|NZ|PLP)\s*=\s*(\d+)", re.IGNORECASE)
_PALLET_LINE = re.compile(rf"\s*(?:{_PALLET_PART.pattern}[\s,]*)+$", re.IGNORECASE)
_PARAMETER = re.compile(r"\s*/\s*([^/]+?)\s*/(.*)$")
_PARAMETER_LINE = re.compile(r"\s*([A-Z][A-Z0-9]*)\s*(?:\(\s*(\d+)\s*\))?\s*=\s*(-?\d+)\s*$",
                             re.IGNORECASE)  # fmt: skip
_PARAMETER_VALUE = re.compile(r"\s*([RAM])(\d+)\s*=\s*(-?\d+)[\s,]*", re.IGNORECASE)
_SCALE = 1000


@dataclass(frozen=True)
class Source:
    """A program in the file: its name, its text, and the number of lines of the file before it."""

    name: str
    text: str
    offset: int


@dataclass
class AllFile:
    """The data of a controller.

    Attributes:
        programs: In the order of the file, which is the order of their numbers.
        points: Points by number.
        comments: Comments of points by number.
        shifts: Shifts by number, in 0.001 mm and 0.001 degree.
        hands: Hands by robot (always 1) and number.
        pallets: Pallets by number.
        variables: SGI and SGR by name.
        parameters: Maps the name of a parameter to its values by robot or axis of the controller
            (from 1; 0: all robots or axes).
        passed_over: Sections that were not read, and lines with their numbers.
    """

    programs: list[Source] = field(default_factory=list)
    points: dict[int, Point] = field(default_factory=dict)
    comments: dict[int, str] = field(default_factory=dict)
    shifts: dict[int, Shift] = field(default_factory=dict)
    hands: dict[tuple[int, int], Hand] = field(default_factory=dict)
    pallets: dict[int, Pallet] = field(default_factory=dict)
    variables: dict[str, float] = field(default_factory=dict)
    parameters: dict[str, dict[int, int]] = field(default_factory=dict)
    passed_over: list[str] = field(default_factory=list)


def read_all(path: Path) -> AllFile:
    """Read a file with all data of a controller.

    Raises:
        InputError: the file cannot be read, has no section, or has two programs of the same name.
    """
    content = AllFile()
    lines = text_of(path).splitlines()
    sections = list(_sections(lines))
    if not sections:
        hint = "give a single program as a .PGM file"
        raise InputError("the file has no section such as [PGM]", file=path, hint=hint)
    for name, first, last in sections:
        body = [(number, lines[number - 1]) for number in range(first, last)]
        reader = _READERS.get(name)
        if reader is None and name != "END":
            content.passed_over.append(f"line {first - 1}: section [{name}]")
        elif reader is not None:
            reader(body, content)
    names = [source.name for source in content.programs]
    for number, name in enumerate(names):
        if name in names[:number]:
            line = content.programs[number].offset
            raise InputError(f"there are two programs {name}", file=path, line=line)
    return content


def _sections(lines: list[str]) -> Iterator[tuple[str, int, int]]:
    """Yield the name, the index of the first line and the end index of each section."""
    heads = [
        (k, match[1].upper()) for k, text in enumerate(lines, 1) if (match := _SECTION.match(text))
    ]
    ends = [*(number for number, _ in heads[1:]), len(lines) + 1][: len(heads)]
    for (number, name), end in zip(heads, ends, strict=True):
        yield name, number + 1, end


Body = list[tuple[int, str]]


def _programs(body: Body, content: AllFile) -> None:
    """Read the programs of a section: a line such as `NAME=MAIN`, then the program's lines."""
    heads = [(k, match[1]) for k, (_, text) in enumerate(body) if (match := _NAME.match(text))]
    ends = [*(k for k, _ in heads[1:]), len(body)][: len(heads)]
    for (k, name), end in zip(heads, ends, strict=True):
        texts = [text for _, text in body[k + 1 : end]]
        while texts and not texts[-1].strip():
            texts.pop()
        content.programs.append(Source(name.upper(), "\n".join(texts), body[k][0]))
    _pass_over(list(body[: heads[0][0] if heads else None]), content)


def _entries(
    kind: str, store: Callable[[int, str, AllFile], bool]
) -> Callable[[Body, AllFile], None]:
    """Return a function that reads a section with lines such as `P1 = 100.00 50.00 ...`."""

    def read(body: Body, content: AllFile) -> None:
        for number, text in body:
            match = _ENTRY.match(text)
            if not match or match[1].upper() != kind or not store(int(match[2]), match[3], content):
                _pass_over([(number, text)], content)

    return read


def _pass_over(body: Body, content: AllFile) -> None:
    content.passed_over += [f"line {number}: {text.strip()[:40]}" for number, text in body
                            if text.strip()]  # fmt: skip


def _point(number: int, text: str, content: AllFile) -> bool:
    point = data_point(text)
    if point is None or number >= COUNTS["points"]:
        return False
    content.points[number] = point
    return True


def data_point(text: str) -> Point | None:
    """Return a point from its numbers. Numbers with a decimal point are in mm, others in pulses."""
    values = _values(text)
    if values is None or not 1 <= len(values) <= AXES + 3:
        return None
    mm = any("." in part for part in text.split())
    data = [round(value * (_SCALE if mm else 1)) for value in values[:AXES]]
    flags = [int(value) for value in values[AXES:]] + [0, 0, 0]
    return Point((*data, *[0] * (AXES - len(data))), mm, flags[0] % 3, flags[1], flags[2])


def _comment(number: int, text: str, content: AllFile) -> bool:
    quoted = len(text) > 1 and text[0] == text[-1] == '"'
    content.comments[number] = (text[1:-1] if quoted else text).rstrip()
    return number < COUNTS["comments"]


def _shift(number: int, text: str, content: AllFile) -> bool:
    values = _values(text)
    if values is None or len(values) != 4 or number >= COUNTS["shifts"]:
        return False
    x, y, z, r = (round(value * _SCALE) for value in values)
    content.shifts[number] = (x, y, z, r)
    return True


def _hand(number: int, text: str, content: AllFile) -> bool:
    on_r = text.upper().rstrip().endswith("R")
    values = _values(text.rstrip("Rr "))
    if values is None or len(values) != 3 or number >= COUNTS["hands"]:
        return False
    first = round(values[0] * (_SCALE if "." in text.split()[0] else 1))
    second, third = (round(value * _SCALE) for value in values[1:])
    content.hands[1, number] = Hand((first, second, third, int(on_r)))
    return True


def _variables(body: Body, content: AllFile) -> None:
    for number, text in body:
        match = _ENTRY.match(text)
        values = _values(match[3]) if match else None
        name = f"{match[1].upper()}{match[2]}" if match else ""
        if not values or len(values) != 1 or variable_number(name) is None:
            _pass_over([(number, text)], content)
        else:
            content.variables[name] = values[0] if name.startswith("SGR") else int(values[0])


def _pallets(body: Body, content: AllFile) -> None:
    """Read the pallets: `PL0`, then `NX=3`, `NY=4`, `NZ=2`, and the first point as `PLP=3996`."""
    number, parts = -1, dict[str, int]()
    for line, text in [*body, (0, "PL0")]:
        if head := _PALLET.match(text):
            if number >= 0 and len(parts) == 4:
                content.pallets[number] = Pallet(
                    parts["NX"], parts["NY"], parts["NZ"], parts["PLP"]
                )
            number, parts = int(head[1]), {}
        elif _PALLET_LINE.match(text):
            found = _PALLET_PART.findall(text)
            parts.update((name.upper(), int(value)) for name, value in found)
        else:
            _pass_over([(line, text)], content)


def _parameters(body: Body, content: AllFile) -> None:
    """Read parameters: `/ACCEL/`, then `A1=80` (an axis) or `R1=2` (a robot); or `ACCEL(1)=80`.

    Only the parameters of the remote command guide (4.4.2) are read. All others are skipped.
    """
    label, known = "", parameter_ranges()
    for number, text in body:
        rest = text.partition("'")[0].rstrip()
        if head := _PARAMETER.match(rest):
            label, rest = head[1].upper(), head[2]
            if label not in known:
                _pass_over([(number, f"parameter {label}")], content)
        elif line := _PARAMETER_LINE.match(rest):
            name = line[1].upper()
            if name in known:
                label = ""
                if not _parameter(name, int(line[2] or 0), int(line[3]), content):
                    _pass_over([(number, text)], content)
                continue
        at = 0
        while value := _PARAMETER_VALUE.match(rest, at):
            at = value.end()
            owner = "R" if label in ROBOT_PARAMETERS else "AM"
            right = label in known and value[1].upper() in owner
            if right and not _parameter(label, int(value[2]), int(value[3]), content):
                _pass_over([(number, value[0])], content)
        if rest[at:].strip() and label in ("", *known):
            _pass_over([(number, rest[at:])], content)


def _parameter(name: str, place: int, value: int, content: AllFile) -> bool:
    low, high = parameter_ranges()[name]
    if not low <= value <= high:
        return False
    content.parameters.setdefault(name, {})[place] = value
    return True


def _values(text: str) -> list[float] | None:
    try:
        return [float(part) for part in text.split()]
    except ValueError:
        return None


_READERS: dict[str, Callable[[Body, AllFile], None]] = {
    "PGM": _programs,
    "PNT": _entries("P", _point),
    "PCM": _entries("PC", _comment),
    "SFT": _entries("S", _shift),
    "HND": _entries("H", _hand),
    "PLT": _pallets,
    "SGI": _variables,
    "SGR": _variables,
    "PRM": _parameters,
}
