"""An independent second reading of the remote command guide, and a check of telegrams with it.

tests/spec/second_reading/*.toml describe the printed sections of the commands in another form than
spec/remote_commands.toml. The head of category_1.toml gives the grammar. This module does not use
spec/. tests/spec/test_second_reading.py compares the two descriptions.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from rcx_harness.spec.telegram import WORDS
from structured_text.output.toml_files import load_toml

FOLDER = Path(__file__).resolve().parents[1] / "spec" / "second_reading"

_BITS = re.compile(r"([mn])\+(\d+)\.(\d+)(?:-(\d+))?")
_NUMBER = re.compile(r"([mn])\+(\d+) (u16|s16|u32|s32|f32)(?: x(\d+))?")
_TEXT = re.compile(r"([mn])\+(\d+) text (\d+)")
_WORDS = re.compile(r"([mn])\+(\d+)(?:\.\.([mn])\+(\d+))?")
_CONDITION = re.compile(r"where (.+?) = (.+?): (.+)")
_INTEGER = r"-?(?:0x[0-9A-Fa-f]+|\d+)"
_RANGE = re.compile(rf"({_INTEGER})(?:\.\.({_INTEGER}))?")


@dataclass(frozen=True)
class Place:
    """A field of a telegram with `width` bits. It begins at bit `low` of the word at byte `at`.

    `kind` is `u`, `s`, `f` or `t` (a character of a text).
    """

    side: str
    at: int
    low: int
    width: int
    kind: str = "u"

    def __str__(self) -> str:
        if self.kind in "sf" or self.width > 16 or (self.kind == "u" and self.width == 16):
            return f"{self.side}+{self.at} {self.kind}{self.width}"
        if self.kind == "t":
            return f"{self.side}+{self.at} character in bits {self.low}-{self.low + 7}"
        last = self.low + self.width - 1
        return f"{self.side}+{self.at}.{self.low}" + (f"-{last}" if last > self.low else "")

    @cached_property
    def mask(self) -> int:
        """Return the bits of the field in the telegram as a number; bit 0 is bit 0 of word 0."""
        return ((1 << self.width) - 1) << (8 * self.at + self.low)

    @property
    def limits(self) -> tuple[int, int]:
        """Return the lowest and the highest whole number that fit into the field."""
        if self.kind == "s":
            return -(1 << (self.width - 1)), (1 << (self.width - 1)) - 1
        return 0, (1 << self.width) - 1

    def read(self, words: Sequence[int]) -> int:
        """Return the field's value in the words of a telegram, or the bit pattern of an f32."""
        return self.value_in(_number(words))

    def value_in(self, telegram: int) -> int:
        """Return the field's value in a telegram that is given as a number."""
        raw = (telegram & self.mask) >> (8 * self.at + self.low)
        return raw - (1 << self.width) if self.kind == "s" and raw > self.limits[1] else raw

    def write(self, words: list[int], value: int) -> None:
        """Write `value` into the field. It must be within `limits`."""
        low, high = self.limits
        assert low <= value <= high, f"{self} cannot be {value}"
        raw = (value & ((1 << self.width) - 1)) << (8 * self.at + self.low)
        whole = _number(words) & ~self.mask | raw
        words[:] = [(whole >> (16 * k)) & 0xFFFF for k in range(WORDS)]


@dataclass(frozen=True)
class Legal:
    """A set of legal values, as the grammar describes it."""

    ranges: tuple[tuple[int, int], ...] = ()
    anything: bool = False
    one_bit: bool = False
    zero_fill: bool = False
    space_fill: bool = False

    def holds(self, value: int) -> bool:
        """Return whether the number is legal."""
        if self.anything or (self.one_bit and bin(value).count("1") == 1):
            return True
        return any(low <= value <= high for low, high in self.ranges)

    def edges(self) -> set[int]:
        """Return the limits of all ranges, and the numbers next to the limits."""
        return {edge + beside for pair in self.ranges for edge in pair for beside in (-1, 0, 1)}


@dataclass(frozen=True)
class Row:
    """A row of the table: consecutive fields of equal type, and their legal values."""

    places: tuple[Place, ...]
    what: str
    legal: Legal = field(default_factory=Legal)
    conditions: tuple[tuple[Place, Legal, Legal], ...] = ()

    def allowed(self, words: Sequence[int]) -> Legal:
        """Return the legal values of the row's fields, given the words of this telegram."""
        return self.allowed_in(_number(words))

    def allowed_in(self, telegram: int) -> Legal:
        """Return the legal values of the row's fields, given this telegram as a number."""
        if not self.conditions:
            return self.legal
        for other, when, legal in self.conditions:
            if when.holds(other.value_in(telegram)):
                return legal
        return Legal(anything=True)

    def problem(self, words: Sequence[int]) -> str:
        """Return a text about an illegal value in this telegram, or an empty text."""
        return self.problem_in(_number(words))

    def problem_in(self, telegram: int) -> str:
        """Return a text about an illegal value in this telegram, a number, or an empty text."""
        allowed = self.allowed_in(telegram)
        values = [part.value_in(telegram) for part in self.places]
        filler = values[-1]
        if (allowed.zero_fill and filler == 0) or (allowed.space_fill and filler == ord(" ")):
            while values and values[-1] == filler:
                values.pop()
        for part, value in zip(self.places, values, strict=False):
            if not allowed.holds(value):
                return f"{part} ({self.what}) is {value}"
        return ""


@dataclass(frozen=True)
class Reading:
    """A command as its section in the guide describes it."""

    code: int
    robot: bool
    section: str
    pendant: bool
    robot_zero: str
    request: tuple[Row, ...]
    zero: tuple[Place, ...]
    response: tuple[Row, ...]
    unused: tuple[Place, ...]
    not_both: tuple[tuple[Place, Place], ...]

    def __str__(self) -> str:
        return f"{'0xR' if self.robot else '0x0'}{self.code:03X} ({self.section})"

    def problem(self, words: Sequence[int]) -> str:
        """Return a text about an illegal value in a request, or an empty text.

        Word 0 is not checked.
        """
        telegram = _number(words)
        for part in self.zero:
            if part.value_in(telegram):
                return f"{part} is not 0"
        for entry in self.request:
            problem = entry.problem_in(telegram)
            if problem:
                return problem
        for first, second in self.not_both:
            if first.value_in(telegram) and second.value_in(telegram):
                return f"{first} and {second} are both 1"
        return ""

    def mend(self, words: list[int], keep: int = 0) -> None:
        """Make a request legal by changing illegal values. Fields in the mask `keep` do not change.

        If the bits in `keep` are illegal, the request stays illegal.
        """
        for _ in range(3):  # a changed value may change the legal values of another row
            before = _number(words)
            for entry in self.request:
                telegram = _number(words)
                if not entry.problem_in(telegram):
                    continue
                value = first(entry.allowed_in(telegram))
                for part in entry.places:
                    if not part.mask & keep:
                        part.write(words, value)
            if _number(words) == before:
                return


def every_reading() -> dict[int, Reading]:
    """Return all commands of the second reading by code."""
    found: dict[int, Reading] = {}
    for path in sorted(FOLDER.glob("*.toml")):
        for entry in _load(path):
            assert entry.code not in found, f"{path.name}: {entry} twice"
            found[entry.code] = entry
    return found


def reading(entry: dict[str, Any]) -> Reading:
    """Return the command that a TOML table describes.

    Raises:
        ValueError: an entry of the table does not follow the grammar.
    """
    entry = {**_shared("answer").get(entry.get("answer", ""), {}), **entry}
    known = {"code", "section", "pendant", "robot_zero", "request", "zero"}
    known |= {"answer", "response", "unused", "not_both", "doubt"}
    nothing = () if entry.get("response") else ("m+2..m+30",)
    code = str(entry["code"])
    if set(entry) - known or not re.fullmatch("R?[0-9A-F]{3}", code):
        raise ValueError(f"{code}: not in the grammar: {sorted(set(entry) - known) or code}")
    found = Reading(
        code=int(code.removeprefix("R"), 16),
        robot=code.startswith("R"),
        section=entry["section"],
        pendant=entry.get("pendant", False),
        robot_zero=entry.get("robot_zero", ""),
        request=tuple(row(text) for text in _expanded(entry.get("request", ()))),
        zero=tuple(part for text in entry.get("zero", ()) for part in _zeros(text)),
        response=tuple(row(text) for text in entry.get("response", ())),
        unused=tuple(part for text in entry.get("unused", nothing) for part in _zeros(text)),
        not_both=tuple((place(one)[0], place(two)[0]) for one, two in entry.get("not_both", ())),
    )
    wrong = [part for part in _sides(found) if part[0] != part[1].side]
    if wrong:
        raise ValueError(
            f"{found}: {wrong[0][1]} is in a request instead of a response, or the reverse"
        )
    return found


def _expanded(texts: Sequence[str]) -> Iterator[str]:
    """Replace each name of a group (`+name`) by the rows of the group."""
    for text in texts:
        yield from _shared("group")[text[1:]] if text.startswith("+") else [text]


def row(text: str) -> Row:
    """Parse the text of a row.

    Raises:
        ValueError: the text does not follow the grammar.
    """
    parts = text.split(" | ")
    if len(parts) != 3:
        raise ValueError(f"not the text of a row: {text!r}")
    where, what, values = parts
    if not values.startswith("where "):
        return Row(place(where), what, _legal(values))
    conditions = []
    for clause in values.split("; "):
        match = _CONDITION.fullmatch(clause)
        if not match:
            raise ValueError(f"not the text of a condition: {clause!r}")
        conditions.append((place(match[1])[0], _legal(match[2]), _legal(match[3])))
    return Row(place(where), what, conditions=tuple(conditions))


def place(text: str) -> tuple[Place, ...]:
    """Parse the text of a place, and return its consecutive fields of equal size.

    Raises:
        ValueError: the text does not follow the grammar.
    """
    found: list[Place] = []
    if match := _BITS.fullmatch(text):
        low, high = int(match[3]), int(match[4] or match[3])
        if low <= high <= 15:
            found = [Place(match[1], int(match[2]), low, high - low + 1)]
    elif match := _NUMBER.fullmatch(text):
        kind, width = match[3][0], int(match[3][1:])
        starts = range(0, int(match[4] or 1) * width // 8, width // 8)
        found = [Place(match[1], int(match[2]) + start, 0, width, kind) for start in starts]
    elif match := _TEXT.fullmatch(text):
        at = int(match[2])
        found = [Place(match[1], at + k - k % 2, k % 2 * 8, 8, "t") for k in range(int(match[3]))]
    last = found[-1] if found else None
    if last is None or found[0].at % 2 or found[0].at < 2 or last.at + last.width / 8 > 32:
        raise ValueError(f"not the text of a place: {text!r}")
    return tuple(found)


def first(legal: Legal) -> int:
    """Return the first legal value."""
    if legal.ranges:
        return legal.ranges[0][0]
    return 1 if legal.one_bit else 0


def _legal(text: str) -> Legal:
    ranges = []
    words = set()
    for item in text.split(", "):
        match = _RANGE.fullmatch(item)
        if match:
            ranges.append((int(match[1], 0), int(match[2] or match[1], 0)))
        elif item in ("any", "one bit", "zero fill", "space fill"):
            words.add(item)
        else:
            raise ValueError(f"not a set of values: {text!r}")
    flags = (name in words for name in ("any", "one bit", "zero fill", "space fill"))
    return Legal(tuple(ranges), *flags)


def _zeros(text: str) -> Iterator[Place]:
    match = _WORDS.fullmatch(text)
    if not match:
        yield from place(text)
        return
    for at in range(int(match[2]), int(match[4] or match[2]) + 1, 2):
        yield from place(f"{match[1]}+{at} u16")


def _sides(found: Reading) -> Iterator[tuple[str, Place]]:
    for side, rows, zeros in (
        ("n", found.request, found.zero),
        ("m", found.response, found.unused),
    ):
        for part in zeros:
            yield side, part
        for entry in rows:
            for part in entry.places:
                yield side, part
            for other, _, _ in entry.conditions:
                yield "n", other  # fields of a response may depend on the request


def _number(words: Sequence[int]) -> int:
    return int.from_bytes(struct.pack(f"<{WORDS}H", *words), "little")


@cache
def _shared(kind: str) -> dict[str, Any]:
    """Return the tables `group` or `answer`, which several commands share."""
    shared: dict[str, Any] = load_toml(FOLDER / "category_1.toml")[kind]
    return shared


@cache
def _load(path: Path) -> tuple[Reading, ...]:
    return tuple(reading(entry) for entry in load_toml(path)["command"])
