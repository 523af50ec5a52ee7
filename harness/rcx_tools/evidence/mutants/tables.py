"""Mutation operators for the tables of spec/: a value, a bit, a limit, a default, or a name.

Only values that have an effect are changed. Texts for people stay unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

from rcx_tools.evidence.mutants.sample import Change
from structured_text.mutants.text import Edit, Span
from structured_text.output.toml_files import parse_toml

__all__ = ["TABLE_OPERATORS", "entry_at", "marks_of", "table_changes", "table_meaning"]

TABLE_OPERATORS = ("number", "constant", "default", "swapped values", "swapped names")

#: Keys whose values are texts for people only.
_SPOKEN = re.compile(
    r"\b(?:meaning|title|does|about|done|comment|unit|section|cause|remedy|robot_zero"
    r"|name_ja|cause_ja|remedy_ja)\s*=\s*\"(?:[^\"\\]|\\.)*\""
)
_TEXT = re.compile(r"\"(?:[^\"\\]|\\.)*\"")
_NUMBER = re.compile(r"(?<![\w.#\"-])-?(?:0x[0-9A-Fa-f]+|\d+(?:\.\d+)?)(?![\w.#])")
_FLAG = re.compile(r"(?<==\s)(?:true|false)\b")
_DURATION = re.compile(r"(?<=\"T#)(\d+)(?=s\")")
_CODE = re.compile(r"(?<=\"16#)([0-9A-F]{4})(?=\")")
_NAMED = [
    re.compile(rf"^{key}\s*=\s*(\"[^\"]*\")", re.MULTILINE) for key in ("name", "pin", "signal")
]
_MEMBER = re.compile(r"\[\"[^\"]*\", (-?\d+), \"(?:[^\"\\]|\\.)*\"\]")
_LIST = re.compile(r"(?:commands|to|zero|fields)\s*=\s*\[(\"[^\"\]]*\"(?:, \"[^\"\]]*\")+)\]")
_TABLE_OF_VALUES = re.compile(r"values = \{ ([^}]*) \}")
_COMMANDS = re.compile(r"^commands = \[([^\]]*)\]", re.MULTILINE)
_SIGNAL = re.compile(r"^(S[IO]\d\d)_.*")
_CASE = re.compile(r"\w+ = (\"[^\"]*\")")


def table_changes(text: str) -> list[Change]:
    """Return all possible changes of a table in spec/."""
    return [Change(operator, entry_at(text, edits[0].span.start), edits)
            for operator, edits in _changes(text)]  # fmt: skip


def table_meaning(text: str) -> str:
    """Return a text that is equal for tables with the same content.

    Raises:
        InputError: the text is not TOML.
    """
    return repr(parse_toml(text, Path("spec")))


def _changes(text: str) -> Iterator[tuple[str, tuple[Edit, ...]]]:
    hidden = [match.span() for match in _SPOKEN.finditer(text)]
    hidden += [match.span() for match in re.finditer(r"^\s*#.*$", text, re.MULTILINE)]
    texts = [match.span() for match in _TEXT.finditer(text)]

    def shown(match: re.Match[str], spans: list[tuple[int, int]]) -> bool:
        return not any(low <= match.start() < high for low, high in spans)

    for match in _NUMBER.finditer(text):
        is_key = text[match.end() : match.end() + 2] == " ="
        if shown(match, hidden) and shown(match, texts) and not is_key:
            yield "number", (_edit(match, _other_number(match[0])),)
    for match in _FLAG.finditer(text):
        if shown(match, hidden):
            yield "constant", (_edit(match, "false" if match[0] == "true" else "true"),)
    for match in _DURATION.finditer(text):
        if shown(match, hidden):
            yield "default", (_edit(match, str(int(match[0]) * 2)),)
    for match in _CODE.finditer(text):
        yield "number", (_edit(match, f"{int(match[0], 16) + 1:04X}"),)
    yield from _defaults(text)
    for group in _groups(text, _MEMBER):
        yield "swapped values", group
    for pattern, inner in ((_LIST, _TEXT), (_TABLE_OF_VALUES, _CASE)):
        for match in pattern.finditer(text):
            if shown(match, hidden):
                yield from _pairs(match, inner)
    for pattern in _NAMED:
        names = list(pattern.finditer(text))
        for one, other in pairwise(names):
            yield "swapped names", (_group(one, other[1]), _group(other, one[1]))


def _defaults(text: str) -> Iterator[tuple[str, tuple[Edit, ...]]]:
    """Yield changes of a default value: to another number, or another enumeration member."""
    members = re.findall(r"\[\"([A-Z_0-9]+)\", ", text)
    for match in re.finditer(r"default = (\"([^\"]*)\")", text):
        old = match[2]
        if re.fullmatch(r"-?\d+", old):
            yield "default", (_group(match, f'"{int(old) + 1}"'),)
        elif old in members:
            other = members[(members.index(old) + 1) % len(members)]
            yield "default", (_group(match, f'"{other}"'),)


def _groups(text: str, pattern: re.Pattern[str]) -> Iterator[tuple[Edit, ...]]:
    """Yield exchanges of the values of two adjacent matches of a pattern."""
    found = list(pattern.finditer(text))
    for one, other in pairwise(found):
        if other.start() - one.end() < 8:
            yield _group(one, other[1]), _group(other, one[1])


def _pairs(match: re.Match[str], inner: re.Pattern[str]) -> Iterator[tuple[str, tuple[Edit, ...]]]:
    """Yield exchanges of two adjacent elements of a list."""
    group = 1 if inner.groups else 0
    spans = [
        (Span(match.start(1) + one.start(group), match.start(1) + one.end(group)), one[group])
        for one in inner.finditer(match[1])
    ]
    for (here, one), (there, other) in pairwise(spans):
        yield "swapped values", (Edit(here, other), Edit(there, one))


def _other_number(text: str) -> str:
    if text.startswith("0x"):
        return f"0x{int(text, 16) + 1:0{len(text) - 2}X}"
    return str(float(text) * 10) if "." in text else str(int(text) + 1)


def _edit(match: re.Match[str], text: str) -> Edit:
    return Edit(Span(*match.span()), text)


def _group(match: re.Match[str], text: str) -> Edit:
    return Edit(Span(*match.span(1)), text)


def entry_at(text: str, offset: int) -> str:
    """Return the name of the table entry at an offset."""
    start = max(text.rfind("\n[[", 0, offset), 0)
    named = re.compile(r"(?:name|pin|number|id) = \"?([^\"\n]+)\"?").search(text, start)
    return named[1] if named else ""


def marks_of(entry: str, files: Sequence[Path]) -> tuple[str, ...]:
    """Return texts that occur in the names of tests about an entry.

    The texts are the names of the entry, of all entries that directly or indirectly name it, and of
    the commands of these blocks.
    """
    found, waiting = {entry}, [entry]
    parts = [part for file in files for part in re.split(r"\n(?=\[\[)", file.read_text("utf-8"))]
    named = [(part, entry_at(part, 0)) for part in parts]
    while waiting:
        name = f'"{waiting.pop()}"'
        for part, own in named:
            if own and own not in found and name in part:
                found.add(own)
                waiting.append(own)
    for part, own in named:
        commands = _COMMANDS.search(part)
        if own in found and commands:
            found.update(re.findall(r"\w+", commands[1]))
    plain = (one.removeprefix("0x").removeprefix("FB_") for one in found)
    return tuple(sorted({_SIGNAL.sub(r"\1", one) for one in plain}))
