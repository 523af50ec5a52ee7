"""Stored data as a file: as tables of a robot file for the virtual controller, or as CSV."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rcx_harness.robot import RobotConfig
from rcx_harness.robot.stored import Hand, Pallet, Point, Shift
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml, toml_value

__all__ = ["KINDS", "Key", "Stored", "as_csv", "as_toml", "from_toml", "shown", "without_foreign"]

#: The tables in the order of reading and writing. Pallets come after the points that they use.
KINDS = ("points", "comments", "shifts", "hands", "pallets")
_COLUMNS = ("number", "unit", *(f"axis{k}" for k in range(1, 7)), "hand", "arm1", "arm2", "comment")

#: The key of a stored value: kind of data, robot (0 except for hands) and number.
Key = tuple[str, int, int]


@dataclass
class Stored:
    """The stored data of a controller, or a part of them.

    Attributes:
        values: Maps kind, robot and number to a Point, a text, a Shift, a Hand or a Pallet.
            Undefined data and empty comments have no entry.
        asked: All keys that were requested. Some of them may be undefined.
    """

    values: dict[Key, Any] = field(default_factory=dict)
    asked: list[Key] = field(default_factory=list)

    def of(self, kind: str) -> dict[tuple[int, int], Any]:
        """Return all values of a kind, by robot and number."""
        return {key[1:]: value for key, value in self.values.items() if key[0] == kind}


def without_foreign(stored: Stored) -> tuple[Stored, list[int]]:
    """Return the data that a robot file can contain, and the numbers of the dropped comments.

    Comments consist of the characters 16#20 to 16#7E (guide 4.3.2); commands write no others.
    """
    foreign = [
        key
        for key, value in stored.values.items()
        if key[0] == "comments" and not re.fullmatch("[ -~]*", value)
    ]
    values = {key: value for key, value in stored.values.items() if key not in foreign}
    asked = [key for key in stored.asked if key not in foreign]
    return Stored(values, asked), [key[2] for key in foreign]


def as_toml(stored: Stored, head: Iterable[str]) -> str:
    """Return the tables of a robot file; values in mm have three decimals, as in the controller.

    `head` is a comment at the beginning.
    """
    lines = [f"# {line}" for line in head]
    for (_, number), point in sorted(stored.of("points").items()):
        lines += ["", f"[points.{number}]", *_point_lines(point)]
    comments = sorted(stored.of("comments").items())
    lines += _table("comments", ((n, toml_value(text)) for (_, n), text in comments))
    shifts = sorted(stored.of("shifts").items())
    lines += _table("shifts", ((n, _list(map(_mm, shift))) for (_, n), shift in shifts))
    hands = sorted(stored.of("hands").items())
    for robot in sorted({key[0] for key, _ in hands}):
        mine = ((n, _list(map(str, hand.data))) for (one, n), hand in hands if one == robot)
        lines += _table(f"hands.{robot}", mine)
    for (_, number), pallet in sorted(stored.of("pallets").items()):
        sizes = _list(map(str, (pallet.nx, pallet.ny, pallet.nz)))
        lines += ["", f"[pallets.{number}]", f"positions = {sizes}"]
        lines.append(f"first_point = {pallet.first}")
    return "\n".join(lines) + "\n"


def as_csv(stored: Stored) -> str:
    """Return CSV text with a line for each point or comment, in the controller's units."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    points = {number: point for (_, number), point in stored.of("points").items()}
    comments = {number: comment for (_, number), comment in stored.of("comments").items()}
    for number in sorted(points.keys() | comments.keys()):
        cells: list[object] = [""] * (len(_COLUMNS) - 2)
        if point := points.get(number):
            data = map(_mm, point.data) if point.mm else point.data
            unit = "mm" if point.mm else "pulse"
            cells = [unit, *data, point.hand, point.arm1, point.arm2]
        writer.writerow([number, *cells, comments.get(number, "")])
    return text.getvalue()


def from_toml(file: Path) -> Stored:
    """Return the stored data of a file of `rcx points`, or of a robot file."""
    there = [kind for kind in KINDS if kind in load_toml(file)]
    if not there:
        hint = "write one with rcx points backup"
        raise InputError(f"contains none of the tables {', '.join(KINDS)}", file=file, hint=hint)
    config = RobotConfig.load(file)
    stored = Stored()
    for kind in there:
        found: Mapping[Any, Any] = getattr(config, kind)
        for key, value in sorted(found.items()):
            robot, number = key if kind == "hands" else (0, key)
            text = value.rstrip(" ") if kind == "comments" else value
            if text != "":
                stored.values[kind, robot, number] = text
            stored.asked.append((kind, robot, number))
    return stored


def shown(value: Any) -> str:
    """Return a stored value as text for the user."""
    if value is None:
        return "not defined"
    if isinstance(value, str):
        return toml_value(value)
    if isinstance(value, Point):
        return ", ".join(_point_lines(value))
    if isinstance(value, Pallet):
        return f"{value.nx} x {value.ny} x {value.nz} from point {value.first}"
    if isinstance(value, Hand):
        return f"{_list(map(str, value.data))} as on the wire"
    shift: Shift = value
    return f"{_list(map(_mm, shift))} mm"


def _point_lines(point: Point) -> Iterator[str]:
    data = _list(map(_mm if point.mm else str, point.data))
    yield f"{'mm' if point.mm else 'pulses'} = {data}"
    for name in ("hand", "arm1", "arm2"):
        if getattr(point, name):
            yield f"{name} = {getattr(point, name)}"


def _table(name: str, rows: Iterable[tuple[int, str]]) -> list[str]:
    lines = [f"{number} = {value}" for number, value in rows]
    return ["", f"[{name}]", *lines] if lines else []


def _mm(value: int) -> str:
    """Return a number of thousandths as a decimal number without rounding."""
    size = abs(value)
    return f"{'-' if value < 0 else ''}{size // 1000}.{size % 1000:03}"


def _list(values: Iterable[str]) -> str:
    return f"[{', '.join(values)}]"
