"""Stored data as the data sections of a file with all data of a controller (.ALL).

The format is described in robot/program/all_file.py. It is assumed, because no public file was
found.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from rcx_harness.look.points.stored import KINDS, Key, Stored, from_toml
from rcx_harness.robot.program.all_file import AllFile, read_all
from rcx_harness.robot.stored import Hand, Pallet, Point, Shift
from structured_text.errors import InputError

__all__ = ["as_all", "beyond_all", "from_file", "is_all"]

_SCALE = 1000


def is_all(file: Path) -> bool:
    """Return whether the name of a file ends with .ALL."""
    return file.suffix.lower() == ".all"


def from_file(file: Path) -> tuple[Stored, list[str]]:
    """Return the stored data of a TOML or .ALL file, and the names of its skipped parts.

    Raises:
        InputError: the file cannot be read, or it contains no stored data.
    """
    if not is_all(file):
        return from_toml(file), []
    content = read_all(file)
    stored = Stored()
    for kind in KINDS:
        found = getattr(content, kind)
        for key, value in sorted(found.items()):
            robot, number = key if kind == "hands" else (0, key)
            stored.asked.append((kind, robot, number))
            if value != "":
                stored.values[kind, robot, number] = value
    if not stored.asked:
        hint = "write one with rcx points backup"
        raise InputError(f"contains no {', '.join(KINDS)}", file=file, hint=hint)
    return stored, [*content.passed_over, *_others(content)]


def _others(content: AllFile) -> Iterator[str]:
    """Yield the number of programs, variables and parameters, which are not stored data."""
    for name in ("programs", "variables", "parameters"):
        if count := len(getattr(content, name)):
            yield f"{count} {name if count > 1 else name[:-1]}"


def beyond_all(stored: Stored) -> list[Key]:
    """Return the keys of data that the sections cannot contain: hands of robots 2 to 4."""
    return [key for key in stored.values if key[0] == "hands" and key[1] != 1]


def as_all(stored: Stored) -> str:
    """Return the data sections as text. Values in mm have three decimals, as in the controller."""
    sections: dict[str, Iterable[str]] = {
        "PNT": (f"P{n}={_point(point)}" for n, point in _sorted(stored, "points")),
        "PCM": (f"PC{n}={_comment(text)}" for n, text in _sorted(stored, "comments")),
        "SFT": (f"S{n}={_shift(shift)}" for n, shift in _sorted(stored, "shifts")),
        "HND": (f"H{n}={_hand(hand)}" for n, hand in _sorted(stored, "hands")),
        "PLT": (line for n, one in _sorted(stored, "pallets") for line in _pallet(n, one)),
    }
    lines: list[str] = []
    for name, body in sections.items():
        if entries := list(body):
            lines += [f"[{name}]", *entries, ""]
    return "\n".join(lines) + "\n"


def _sorted(stored: Stored, kind: str) -> Iterator[tuple[int, object]]:
    for (robot, number), value in sorted(stored.of(kind).items(), key=lambda entry: entry[0]):
        if robot in (0, 1):
            yield number, value


def _point(point: object) -> str:
    assert isinstance(point, Point)
    data = [_mm(value) if point.mm else str(value) for value in point.data]
    flags = [str(value) for value in (point.hand, point.arm1, point.arm2)]
    return " ".join(data + (flags if any(map(int, flags)) else []))


def _comment(text: object) -> str:
    quoted = str(text).startswith((" ", '"')) or str(text).endswith('"')
    return f'"{text}"' if quoted else str(text)


def _shift(shift: object) -> str:
    values: Shift = shift  # type: ignore[assignment]
    return " ".join(map(_mm, values))


def _hand(hand: object) -> str:
    """Return hand data as text.

    The first value is in mm if it has a decimal point, else in the unit of remote commands.
    """
    assert isinstance(hand, Hand)
    first = _mm(hand.data[0]) if hand.on_r_axis else str(hand.data[0])
    return " ".join([first, *map(_mm, hand.data[1:3]), *(["R"] if hand.on_r_axis else [])])


def _pallet(number: int, pallet: object) -> list[str]:
    assert isinstance(pallet, Pallet)
    return [f"PL{number}", f"NX={pallet.nx}", f"NY={pallet.ny}", f"NZ={pallet.nz}",
            f"PLP={pallet.first}"]  # fmt: skip


def _mm(value: int) -> str:
    """Return a number of thousandths as a decimal number without rounding."""
    size = abs(value)
    return f"{'-' if value < 0 else ''}{size // _SCALE}.{size % _SCALE:03}"
