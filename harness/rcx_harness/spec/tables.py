"""The manual's tables as data: dedicated signals, alarms and remote commands.

The tables exist once, in the folder `spec` of the repository (inside the package if it is
installed). telegram.py defines the parts of a telegram.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, TypeVar

from rcx_harness.spec.telegram import Command, Field, Product
from structured_text.errors import InputError, did_you_mean
from structured_text.output.toml_files import load_toml

__all__ = [
    "Alarm",
    "Signal",
    "Signals",
    "alarms",
    "command",
    "command_name",
    "commands",
    "folder",
    "public_alarms",
    "signals",
    "whole_number",
]

_T = TypeVar("_T")


@dataclass(frozen=True)
class Signal:
    """One dedicated bit (manual chapter 5, 1 and 2).

    `name` is its name in the library, `signal` its name in the manual. `address` is `m+32` or
    `n+33`. `acts` is `level` or `edge`: an input acts by its level or by its OFF to ON edge.
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
        """Return the number of the byte with the signal, counted from the start of the area."""
        return int(self.address[2:])

    @property
    def short(self) -> str:
        """Return `SO02` for `SO02_ServoOn`."""
        return self.name.partition("_")[0]


@dataclass(frozen=True)
class Signals:
    """All dedicated bits, and the bytes that are reserved completely."""

    output: tuple[Signal, ...]
    input: tuple[Signal, ...]
    reserved_bytes: tuple[int, ...]

    def find(self, name: str) -> Signal:
        """Return the signal with the name `SO02_ServoOn`, `SO02` or `SO(02)`."""
        every = self.output + self.input
        for signal in every:
            if name in (signal.name, signal.short, signal.signal):
                return signal
        meant = get_close_matches(name, [s.name for s in every] + [s.short for s in every])
        raise InputError(f"no signal is called {name!r}", hint=did_you_mean(meant))


@dataclass(frozen=True)
class Alarm:
    """An alarm with its texts; `number` is `"12.600"`.

    Fields that end in `_ja` are texts in Japanese.

    Its source is the `section` of the manual, or another `source`.
    """

    number: str
    group: int
    category: int
    name: str
    cause: str
    remedy: str
    name_ja: str
    cause_ja: str
    remedy_ja: str
    section: str = ""
    source: str = ""


@lru_cache(maxsize=1)
def folder() -> Path:
    """Return the folder with the tables: the repository's folder, else the package's folder."""
    here = Path(__file__).resolve()
    for candidate in (here.parents[3] / "spec", here.parents[1] / "_data" / "spec"):
        if (candidate / "signals.toml").is_file():
            return candidate
    raise InputError("the folder spec/ is missing", hint="install rcx-harness again")


@lru_cache(maxsize=1)
def signals() -> Signals:
    """Return all dedicated bits."""
    path = folder() / "signals.toml"
    table = load_toml(path)
    return Signals(
        output=_build(Signal, table["output"], path),
        input=_build(Signal, table["input"], path),
        reserved_bytes=tuple(table["reserved_bytes"]),
    )


@lru_cache(maxsize=1)
def alarms() -> Mapping[str, Alarm]:
    """Return the alarms of the manual by number."""
    path = folder() / "alarms.toml"
    return {alarm.number: alarm for alarm in _build(Alarm, load_toml(path)["alarm"], path)}


@lru_cache(maxsize=1)
def public_alarms() -> Mapping[str, str]:
    """Return alarm names by number, from a public list, which contains all alarms of the manual."""
    names: Mapping[str, str] = load_toml(folder() / "public_alarms.toml")["names"]
    return names


@lru_cache(maxsize=1)
def commands() -> Mapping[int, Command]:
    """Return the remote commands by code, without the robot's digit."""
    path = folder() / "remote_commands.toml"
    tables = load_toml(path)
    groups = {group["name"]: group for group in tables.get("group", ())}
    table = _build(partial(_command, groups), tables["command"], path)
    return {entry.code: entry for entry in table}


def command(name: str) -> Command:
    """Return the remote command of a name (`MovePtp`) or code (`16#1001`, `0x001`, `0xR001`)."""
    by_name = {entry.name.lower(): entry for entry in commands().values()}
    if name.lower() in by_name:
        return by_name[name.lower()]
    try:
        code = whole_number(name.lower().replace("0xr", "0x0").replace("16#r", "16#0"))
    except ValueError:
        code = -1
    if 0 <= code <= 0xFFFF and code & 0x0FFF in commands():
        return commands()[code & 0x0FFF]
    meant = [by_name[key].name for key in get_close_matches(name.lower(), by_name)]
    hint = did_you_mean(meant) or "docs/reference/commands.md lists all names and codes"
    raise InputError(f"no remote command is called {name!r}", hint=hint)


def command_name(word: int) -> str:
    """Return the label of a code: `MovePtp`, for robot 2 `MovePtp R2`; `0xFFFF` if unknown."""
    found, robot = commands().get(word & 0x0FFF), word >> 12
    if found is None or (robot and not found.robot):
        return f"0x{word:04X}"
    return f"{found.name} R{robot}" if robot else found.name


def whole_number(text: str) -> int:
    """Parse `16#00FF`, `0x00FF` or `255`."""
    if not text.isascii():
        raise ValueError("foreign digits")
    return int(text[3:], 16) if text.startswith("16#") and text[3:4].isalnum() else int(text, 0)


def _command(groups: Mapping[str, Mapping[str, Any]], /, **entry: Any) -> Command:
    used = []
    for name in entry.pop("groups", ()):
        if name not in groups:
            hint = did_you_mean(get_close_matches(name, groups))
            raise ValueError(f"there is no group {name!r}; {hint}")
        used.append(groups[name])
    for side in ("request", "response"):
        parts = [_field(**part) for table in (*used, entry) for part in table.get(side, ())]
        entry[side] = tuple(sorted(parts, key=lambda part: (part.at, part.bits[0])))
    entry["exclusive"] = tuple(tuple(pair) for pair in entry.get("exclusive", ()))
    if "product" in entry:
        limits = entry["product"]
        entry["product"] = Product(tuple(limits["fields"]), tuple(limits["range"]))
    return Command(**entry)


def _field(**entry: Any) -> Field:
    for key in ("bits", "range"):
        if key in entry:
            entry[key] = tuple(entry[key])
    entry["values"] = {int(key, 0): text for key, text in entry.get("values", {}).items()}
    entry["ranges"] = {int(key, 0): tuple(pair) for key, pair in entry.get("ranges", {}).items()}
    return Field(**entry)


def _build(kind: Callable[..., _T], entries: list[dict[str, Any]], path: Path) -> tuple[_T, ...]:
    built = []
    for number, entry in enumerate(entries, 1):
        try:
            built.append(kind(**entry))
        except (TypeError, ValueError) as error:
            raise InputError(f"entry {number}: {error}", file=path) from error
    return tuple(built)
