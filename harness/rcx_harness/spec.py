"""The manual's tables as data: dedicated signals, alarms and remote commands.

The tables live once, in the folder `spec` of the repository (inside the package where it is
installed). Words are lists of 16: word k is at byte 2k of the area, word 0 the code or status.
"""

from __future__ import annotations

import importlib
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from rcx_harness.errors import InputError

__all__ = [
    "Alarm",
    "Command",
    "Field",
    "FieldValue",
    "Signal",
    "Signals",
    "alarms",
    "command",
    "commands",
    "folder",
    "load_toml",
    "signals",
]

#: A number, or as many as the field's count says, or a text.
FieldValue = int | float | str | tuple[int, ...] | tuple[float, ...]

WORDS = 16
_FORMATS = {"u16": "<H", "s16": "<h", "u32": "<I", "s32": "<i", "f32": "<f"}
_T = TypeVar("_T")


@dataclass(frozen=True)
class Signal:
    """One dedicated bit (manual chapter 5, 1 and 2).

    `name` is how the library calls it, `signal` how the manual does; `address` is `m+32` or
    `n+33`; `acts` says whether an input is taken by its level or its OFF to ON edge.
    """

    name: str
    signal: str
    address: str
    bit: int
    title: str
    meaning: str
    section: str
    acts: str = ""

    @property
    def byte(self) -> int:
        """Byte within the area."""
        return int(self.address[2:])

    @property
    def short(self) -> str:
        """`SO02` for `SO02_ServoOn`."""
        return self.name.partition("_")[0]


@dataclass(frozen=True)
class Signals:
    """All dedicated bits, and the bytes that are reserved altogether."""

    output: tuple[Signal, ...]
    input: tuple[Signal, ...]
    reserved_bytes: tuple[int, ...]

    def find(self, name: str) -> Signal:
        """The signal called `SO02_ServoOn`, `SO02` or `SO(02)`.

        Raises:
            InputError: there is none of that name.
        """
        every = self.output + self.input
        for signal in every:
            if name in (signal.name, signal.short, signal.signal):
                return signal
        near = get_close_matches(name, [s.name for s in every] + [s.short for s in every])
        raise InputError(f"no signal is called {name!r}", hint=_near(near))


@dataclass(frozen=True)
class Alarm:
    """An alarm that the manual names; `number` is `"12.600"`."""

    number: str
    group: int
    category: int
    name: str
    cause: str
    remedy: str
    section: str


@dataclass(frozen=True)
class Field:
    """One field of a telegram; see the head of remote_commands.toml for its keys."""

    name: str
    at: int
    type: str = "bits"
    bits: tuple[int, int] = (0, 15)
    count: int = 1
    length: int = 0
    range: tuple[float, float] | None = None
    values: Mapping[int, str] = field(default_factory=dict)
    by: str = ""
    ranges: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    unit: str = ""
    meaning: str = ""

    @property
    def mask(self) -> int:
        """Bits of its (first) word that it covers."""
        if self.type != "bits":
            return 0xFFFF
        low, high = self.bits
        return ((1 << (high - low + 1)) - 1) << low

    @property
    def words(self) -> Sequence[int]:
        """Indices of the words it covers."""
        if self.type == "bits":
            size = 2
        elif self.type == "text":
            size = self.length + self.length % 2
        else:
            size = struct.calcsize(_FORMATS[self.type]) * self.count
        return range(self.at // 2, (self.at + size) // 2)

    def read(self, words: Sequence[int]) -> FieldValue:
        """Its value in a telegram; numbers as they are on the wire, without scaling."""
        if self.type == "bits":
            return (words[self.at // 2] & self.mask) >> self.bits[0]
        raw = b"".join(words[k].to_bytes(2, "little") for k in self.words)
        if self.type == "text":
            return raw[: self.length].decode("latin-1").rstrip("\0 ")
        every = tuple(part[0] for part in struct.iter_unpack(_FORMATS[self.type], raw))
        return every if self.count > 1 else every[0]

    def write(self, words: list[int], value: FieldValue) -> None:
        """Put `value` into a telegram.

        Raises:
            InputError: it does not fit, or is not of the field's kind.
        """
        try:
            if self.type == "bits":
                self._write_bits(words, int(value))  # type: ignore[arg-type]
                return
            if self.type == "text":
                raw = str(value).encode("ascii").ljust(2 * len(self.words))
                fits = len(raw) == 2 * len(self.words)
            else:
                parts: list[Any] = list(value) if isinstance(value, (tuple, list)) else [value]
                fits = len(parts) <= self.count
                parts += [0] * (self.count - len(parts))
                raw = b"".join(struct.pack(_FORMATS[self.type], part) for part in parts)
        except (struct.error, UnicodeEncodeError, TypeError, ValueError) as error:
            raise InputError(f"{self.name} cannot be {value!r}: {error}") from error
        if not fits:
            raise InputError(f"{self.name} has no room for {value!r}")
        for k in self.words:
            start = 2 * (k - self.at // 2)
            words[k] = int.from_bytes(raw[start : start + 2], "little")

    def _write_bits(self, words: list[int], value: int) -> None:
        shifted = value << self.bits[0]
        if value < 0 or shifted & ~self.mask:
            width = self.bits[1] - self.bits[0] + 1
            raise InputError(f"{self.name} cannot be {value}", hint=f"it has {width} bit(s)")
        words[self.at // 2] = words[self.at // 2] & ~self.mask | shifted

    def problem(self, values: Mapping[str, FieldValue]) -> str:
        """What is wrong with its value among all `values` of the telegram; empty if nothing."""
        value = values[self.name]
        allowed = self.range
        if self.by:
            selector = values[self.by]
            allowed = self.ranges.get(selector) if isinstance(selector, int) else None
        if self.values and value not in self.values:
            return f"{self.name} is {value}, which has no meaning"
        if allowed is None:
            return ""
        parts = value if isinstance(value, tuple) else (value,)
        for part in parts:
            if not isinstance(part, str) and not allowed[0] <= part <= allowed[1]:
                return f"{self.name} is {part}, not {allowed[0]} to {allowed[1]}"
        return ""


@dataclass(frozen=True)
class Command:
    """One remote command: its code, and the fields of its telegrams."""

    code: int
    name: str
    title: str
    category: int
    section: str
    robot: bool
    pendant: bool
    request: tuple[Field, ...] = ()
    response: tuple[Field, ...] = ()
    exclusive: tuple[tuple[str, str], ...] = ()

    @property
    def shown(self) -> str:
        """The code as the manual writes it, `0xR001` or `0x0100`."""
        return f"0xR{self.code:03X}" if self.robot else f"0x{self.code:04X}"

    def decode(self, words: Sequence[int]) -> dict[str, FieldValue]:
        """The request's fields by name; nothing is checked."""
        return {part.name: part.read(words) for part in self.request}

    def encode(self, values: Mapping[str, FieldValue], robot: int = 0) -> tuple[int, ...]:
        """The 16 words of a request; fields that are not given are 0.

        Raises:
            InputError: unknown field, value out of its range, or a robot where none is allowed.
        """
        if robot and not (self.robot and 0 < robot <= 4):
            raise InputError(f"{self.shown} {self.name} cannot designate robot {robot}")
        words = self._fill(self.request, values)
        problem = self.problem(words)
        if problem:
            raise InputError(f"{self.shown} {self.name}: {problem}")
        words[0] = self.code | robot << 12
        return tuple(words)

    def respond(self, values: Mapping[str, FieldValue]) -> tuple[int, ...]:
        """The 15 response words of a normal end; fields that are not given are 0."""
        return tuple(self._fill(self.response, values)[1:])

    def read_response(self, words: Sequence[int]) -> dict[str, FieldValue]:
        """The response's fields by name, from the 16 words at m."""
        return {part.name: part.read(words) for part in self.response}

    def problem(self, words: Sequence[int], *, unused_words: bool = True) -> str:
        """What is wrong with a request's data words; empty if nothing.

        Args:
            words: The 16 words at n; word 0 is not looked at.
            unused_words: Words without any field must be 0, too.
        """
        covered = [0] * WORDS
        for part in self.request:
            for k in part.words:
                covered[k] |= part.mask
        for k in range(1, WORDS):
            stray = words[k] & ~covered[k]
            if stray and (covered[k] or unused_words):
                kind = "fixed 0" if covered[k] else "not used"
                return f"n+{2 * k} has bits 0x{stray:04X} set, which are {kind}"
        values = self.decode(words)
        for part in self.request:
            problem = part.problem(values)
            if problem:
                return problem
        for first, second in self.exclusive:
            if values[first] and values[second]:
                return f"{first} and {second} cannot both be 1"
        return ""

    def _fill(self, fields: Sequence[Field], values: Mapping[str, FieldValue]) -> list[int]:
        by_name = {part.name: part for part in fields}
        words = [0] * WORDS
        for name, value in values.items():
            if name not in by_name:
                near = _near(get_close_matches(name, by_name))
                hint = near or f"its fields are: {', '.join(by_name) or 'none'}"
                raise InputError(f"{self.shown} {self.name} has no field {name!r}", hint=hint)
            by_name[name].write(words, value)
        return words


def load_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises:
        InputError: it cannot be read, or is not TOML (with the line).
    """
    try:
        toml: Any = importlib.import_module("tomllib")
    except ModuleNotFoundError:  # Python 3.10
        toml = importlib.import_module("tomli")
    try:
        content: dict[str, Any] = toml.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise InputError(f"cannot read it: {reason}", file=path) from error
    except toml.TOMLDecodeError as error:
        raise InputError(f"not valid TOML: {error}", file=path) from error
    return content


@lru_cache(maxsize=1)
def folder() -> Path:
    """The folder with the tables: the repository's, else the one installed with the package."""
    here = Path(__file__).resolve()
    for candidate in (here.parents[2] / "spec", here.parent / "_data" / "spec"):
        if (candidate / "signals.toml").is_file():
            return candidate
    raise InputError("the folder spec/ is missing", hint="install rcx-harness again")


@lru_cache(maxsize=1)
def signals() -> Signals:
    """All dedicated bits."""
    path = folder() / "signals.toml"
    table = load_toml(path)
    return Signals(
        output=_build(Signal, table["output"], path),
        input=_build(Signal, table["input"], path),
        reserved_bytes=tuple(table["reserved_bytes"]),
    )


@lru_cache(maxsize=1)
def alarms() -> Mapping[str, Alarm]:
    """The alarms by number."""
    path = folder() / "alarms.toml"
    return {alarm.number: alarm for alarm in _build(Alarm, load_toml(path)["alarm"], path)}


@lru_cache(maxsize=1)
def commands() -> Mapping[int, Command]:
    """The remote commands by code, without the robot's digit."""
    path = folder() / "remote_commands.toml"
    table = _build(_command, load_toml(path)["command"], path)
    return {entry.code: entry for entry in table}


def command(name: str) -> Command:
    """The remote command of that name (`MovePtp`) or code (`0x001`, `0x1001`, `0xR001`).

    Raises:
        InputError: there is none.
    """
    by_name = {entry.name.lower(): entry for entry in commands().values()}
    if name.lower() in by_name:
        return by_name[name.lower()]
    try:
        code = int(name.lower().replace("0xr", "0x0"), 0) & 0x0FFF
    except ValueError:
        code = -1
    if code in commands():
        return commands()[code]
    near = [by_name[key].name for key in get_close_matches(name.lower(), by_name)]
    raise InputError(f"no remote command is called {name!r}", hint=_near(near))


def _command(**entry: Any) -> Command:
    entry["request"] = tuple(_field(**part) for part in entry.get("request", ()))
    entry["response"] = tuple(_field(**part) for part in entry.get("response", ()))
    entry["exclusive"] = tuple(tuple(pair) for pair in entry.get("exclusive", ()))
    return Command(**entry)


def _field(**entry: Any) -> Field:
    for key in ("bits", "range"):
        if key in entry:
            entry[key] = tuple(entry[key])
    entry["values"] = {int(key): text for key, text in entry.get("values", {}).items()}
    entry["ranges"] = {int(key): tuple(pair) for key, pair in entry.get("ranges", {}).items()}
    return Field(**entry)


def _build(kind: Callable[..., _T], entries: list[dict[str, Any]], path: Path) -> tuple[_T, ...]:
    built = []
    for number, entry in enumerate(entries, 1):
        try:
            built.append(kind(**entry))
        except (TypeError, ValueError) as error:
            raise InputError(f"entry {number}: {error}", file=path) from error
    return tuple(built)


def _near(names: Sequence[str]) -> str:
    return f"did you mean {' or '.join(names)}" if names else ""
