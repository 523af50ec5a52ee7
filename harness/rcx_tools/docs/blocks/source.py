"""Parser of the files of plc/lib. It finds head, pins, errors and inner blocks of each POU."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from rcx_harness.spec.wire import NORMAL_END

__all__ = ["CONTRACT", "ROOT", "Kind", "Pin", "Pou", "Section", "kind_of", "kinds", "pous"]

ROOT = Path(__file__).resolve().parents[4]

#: Pins of the PLCopen rules. All other pins are specific to a block.
CONTRACT = ("Execute", "Enable", "Done", "Valid", "Busy", "Active", "Error", "ErrorID")

_COMMENT = re.compile(r"\(\*.*?\*\)", re.DOTALL)
_SECTION = re.compile(r"^  (VAR\w*)\n(.*?)^  END_VAR", re.DOTALL | re.MULTILINE)
_PIN = re.compile(r"^    (\w+)\s*:\s*(\w+)(?:\s*:=\s*(.*?))?;\s*(?:\(\* (.*?) \*\))?$")
_MEMBER = re.compile(r"^    (\w+),?\s*\(\* (.*?) \*\)$", re.MULTILINE)
_ARRAY = re.compile(r"ARRAY \[(-?\d+)\.\.(-?\d+)\] OF (\w+)")
_UNIT = re.compile(r"(?:^|\s+)\[([^\]]+)\]")
_POU = re.compile(r"\bF[BC]_\w+\b")
_NOWHERE = re.compile(r" \(not in the manual[^()]*\)")
_WHERE = re.compile(r" \(((?:remote command )?(?:chapter|guide)[^()]*)\)")
_ERROR = re.compile(r"WORD#16#(8(?!000)[0-9A-F]{3})\b")

#: ErrorIDs of shared functions that only some callers can get. An error about an odd offset needs
#: an image of words, an error about an odd number needs double words, an abort needs the pin Abort.
_ODD_OFFSET, _ODD_NUMBER, _ABORTED = 0x8032, 0x8035, 0x8050

#: ErrorIDs that FB_RcxJob adds: a time limit, and errors of the turn. A remote command also ends
#: with the result of FB_ReadArea, Robot.Inner.Answer. The channel of a composite block has no
#: queue.
_JOB = "FB_RcxJob"
_CALLED_WRONG = {0x8013, 0x8016, 0x8017}
_OWN = {0x8010} | _CALLED_WRONG
_SEQUENCE, _REMOTE = _OWN | {0x8012}, {0x8011, 0x8012, 0x8015} | _CALLED_WRONG
_ANSWER = re.compile(r"\bRobot\.Inner\.Answer := WORD#16#([0-9A-F]{4});")

#: First words of paragraphs in the head. The page does not show these paragraphs.
_NOT_SAID = ("Generated from", "Tests:")

#: The name of a section of declarations: VAR_IN_OUT, VAR_INPUT or VAR_OUTPUT.
Section = str


@dataclass(frozen=True)
class Pin:
    """A pin as it is declared. `unit` is the text in square brackets in the pin's comment."""

    section: Section
    name: str
    type: str
    default: str
    unit: str
    comment: str


@dataclass(frozen=True)
class Pou:
    """A block or function of the library.

    Attributes:
        file: Source file.
        folder: Name of the topmost folder below plc/lib.
        does: First sentence of the head.
        about: The other paragraphs of the head, except those about tests and generators.
        section: Section of the manual, or empty.
        tests: Tests that the head names.
        pins: Pins in the order of declaration.
        uses: Blocks and functions that the code names.
        said: Blocks and functions that the comments name.
        own_errors: ErrorIDs that the code sets itself.
        answers: ErrorIDs that the code writes to Robot.Inner.Answer. Other blocks read this
            variable.
        job: Arguments of the FB_RcxJob in the block. Empty if the block contains no FB_RcxJob.
        result: Type of the result of a function.
    """

    file: Path
    folder: str
    does: str
    about: tuple[str, ...]
    section: str
    tests: tuple[str, ...]
    pins: tuple[Pin, ...]
    uses: tuple[str, ...]
    said: tuple[str, ...]
    own_errors: frozenset[int]
    answers: frozenset[int]
    job: str
    result: str

    @property
    def name(self) -> str:
        """Return the name of the block, which is also the name of its file."""
        return self.file.stem

    @property
    def is_function(self) -> bool:
        """Return whether the POU is a FUNCTION."""
        return self.name.startswith("FC_")

    @property
    def internal(self) -> bool:
        """Return whether the block is a part of other blocks and is not called by users."""
        head = " ".join((self.does, *self.about))
        inside = any(pin.type == "RCX_CHANNEL" for pin in self.pins)
        return inside or bool(re.search(r"\bPart of\b", head))

    def of(self, *sections: Section) -> list[Pin]:
        """Return the pins of the block in these sections."""
        return [pin for pin in self.pins if pin.section in sections]

    def pin(self, name: str) -> Pin | None:
        """Return the pin with this name, or None."""
        return next((pin for pin in self.pins if pin.name == name), None)

    def errors(self) -> list[int]:
        """Return the possible ErrorIDs of the block and of its inner blocks."""
        found: set[int] = set()
        todo, seen = [self], set[str]()
        while todo:
            pou = todo.pop()
            seen.add(pou.name)
            found |= pou.own_errors | _of_job(pou)
            used = [pous()[name] for name in pou.uses if name in pous() and name not in seen]
            todo += [one for one in used if one.name != _JOB]
        if self.is_function:
            return sorted(found)
        if not any(pin.type == "RCX_IMAGE_WORDS" for pin in self.pins):
            found.discard(_ODD_OFFSET)
        if "DoubleWord" not in self.name and self.pin("FirstWord") is None:
            found.discard(_ODD_NUMBER)
        if self.pin("Abort") is None:
            found.discard(_ABORTED)
        return sorted(found)


@dataclass(frozen=True)
class Kind:
    """A type of the library: an enumeration, an array or a structure.

    Attributes:
        file: Source file.
        does: Description from the head.
        members: Members of an enumeration with their meanings. Empty for other types.
        fields: Fields of a structure with their types. Empty for other types.
        defaults: Initial values of the fields that have an initial value.
        first: Lower bound of an array.
        count: Number of elements of an array; 0 for other types.
        element: Type of the elements of an array.
    """

    file: Path
    does: str
    members: Mapping[str, str]
    fields: Mapping[str, str]
    defaults: Mapping[str, str]
    first: int
    count: int
    element: str


@cache
def pous() -> dict[str, Pou]:
    """Return the blocks and functions by name, folder by folder."""
    files = sorted((ROOT / "plc/lib").rglob("F[BC]_*.st"))
    return {file.stem: _pou(file) for file in files}


@cache
def kinds() -> dict[str, Kind]:
    """Return all types of the library by name."""
    return {file.stem: kind_of(file) for file in sorted((ROOT / "plc/lib").rglob("RCX_*.st"))}


def _pou(file: Path) -> Pou:
    text = file.read_text(encoding="utf-8")
    first, *rest = _head(text)
    _, _, does = first.partition(": ")
    where = _WHERE.search(does)
    does = (does.replace(where[0], "", 1) if where else _NOWHERE.sub("", does)).strip()
    tests = re.findall(r"tests/[\w/]+\.py", text.partition("*)")[0])
    code = _COMMENT.sub(" ", text)
    said = dict.fromkeys(_POU.findall(" ".join(_COMMENT.findall(text))))
    answers = _ANSWER.findall(code)
    own = _ANSWER.sub(" ", code)
    job = re.search(r"\bJob\((.*?)\);", code, re.DOTALL)
    result = re.search(r"^FUNCTION \w+ : (\w+)", code, re.MULTILINE)
    return Pou(
        file=file,
        folder=file.relative_to(ROOT / "plc/lib").parts[0],
        does=does[:1].upper() + does[1:],
        about=tuple(one for one in rest if one and not one.startswith(_NOT_SAID)),
        section=where[1] if where else "",
        tests=tuple(tests),
        pins=tuple(_pins(text)),
        uses=tuple(name for name in dict.fromkeys(_POU.findall(code)) if name != file.stem),
        said=tuple(name for name in said if name != file.stem),
        own_errors=frozenset(int(number, 16) for number in _ERROR.findall(own)),
        answers=frozenset(int(number, 16) for number in answers) - {0, NORMAL_END},
        job=job[1] if job and _JOB in code else "",
        result=result[1] if result else "",
    )


def _of_job(pou: Pou) -> set[int]:
    """Return the ErrorIDs that a block gets from its FB_RcxJob."""
    if not pou.job:
        return set()
    found = set(_SEQUENCE)
    if "Remote := TRUE" in pou.job:
        found = set(_REMOTE)
    elif "Channel := Own" in pou.job:
        found = set(_OWN)
    if "Robot.Inner.Answer" in pou.job:
        found |= {error for one in pous().values() for error in one.answers}
    return found


def _head(text: str) -> list[str]:
    """Return the paragraphs of the comment at the head of a file. Each paragraph is one line."""
    comment = text.partition("*)")[0]
    lines = [re.sub(r"^\s*\(?\*", "", line).strip() for line in comment.splitlines()]
    whole = "\n".join(lines).strip()
    paragraphs = [" ".join(one.split()) for one in re.split(r"\n\n+", whole)]
    return [part for one in paragraphs for part in re.split(r" (?=Tests: )", one)]


def _pins(text: str) -> list[Pin]:
    found = []
    for section, body in _SECTION.findall(text):
        if section == "VAR":
            continue
        for line in body.splitlines():
            name, kind, default, comment = _groups(line)
            if name:
                unit, said = _unit(comment)
                found.append(Pin(section, name, kind, default, unit, said))
    return found


def _groups(line: str) -> tuple[str, str, str, str]:
    """Return name, type, default and comment of a declaration. For other lines they are empty."""
    match = _PIN.match(line)
    if match is None:
        return "", "", "", ""
    name, kind, default, comment = match.groups(default="")
    return name, kind, default.strip(), comment


def _unit(comment: str) -> tuple[str, str]:
    """Return the unit in square brackets, and the comment without it.

    If the comment contains several units, it stays unchanged.
    """
    units = _UNIT.findall(comment)
    if len(units) != 1:
        return ", ".join(units), comment
    return units[0], _UNIT.sub("", comment, count=1).strip()


def kind_of(file: Path) -> Kind:
    """Return the type that a file declares."""
    text = file.read_text(encoding="utf-8")
    does = _WHERE.sub("", _head(text)[0].partition(": ")[2])
    array = _ARRAY.search(_COMMENT.sub("", text))
    enumeration = f"{file.stem} : (\n" in text
    members = dict(_MEMBER.findall(text)) if enumeration else {}
    fields, defaults = {}, {}
    if f"{file.stem} : STRUCT" in text:
        rows = [row for row in map(_groups, text.splitlines()) if row[0]]
        fields = {name: kind for name, kind, _, _ in rows}
        defaults = {name: value for name, _, value, _ in rows if value}
    first, count = 0, 0
    if array and file.stem + " : ARRAY" in text:
        first, count = int(array[1]), int(array[2]) - int(array[1]) + 1
    element = array[3] if array and count else ""
    return Kind(file, does, members, fields, defaults, first, count, element)
