"""Classification of refused files: a missing library, a gap of the front end, or another reason.

A refusal counts as a gap unless there is evidence for another kind:

- missing library: the refused name is not declared in the program and is not part of the language,
  and the project refers to libraries that are not available.
- other: the body is graphical or the file is not Structured Text; or the name is not declared and
  the project refers to no library, so the tool also refuses the file; or a person has read the
  message (`Reviewed`).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.registry import ConsequenceError
from structured_text.language.source import source_text

__all__ = ["Kind", "Refusals", "Reviewed", "classified", "references"]

#: Pattern of names and numbers in a message. They are replaced to group messages by reason.
_NAMES = re.compile(r"\b(?:\w*\d\w*|[A-Z_]\w*|\w+[A-Z]\w*)(?:\.\w+)*\b")
#: Patterns of messages about an undeclared name. A group of the pattern contains the name.
_UNKNOWN = re.compile(
    r"there is no (?:type|namespace|function|interface|variable or namespace|variable|"
    r"global variable|program) ([\w.]+)|([\w.]+) is not declared|"
    r"([\w.]+) is not an? (?:function block|structure|type|interface)"
)
#: Functions and types of the language, which do not need a declaration in a library.
_TYPES = (
    r"(?:BOOL|BYTE|[DL]?WORD|U?[SDL]?INT|L?REAL|W?STRING|L?TIME|L?DATE|DATE_AND_TIME|L?DT|L?TOD|"
    r"TIME_OF_DAY|BIT)"
)
_LANGUAGE = re.compile(
    rf"__\w+|(?:(?:{_TYPES}|ANY|ANY_NUM)_)?TO_{_TYPES}|{_TYPES}|X?SIZEOF|ADR|BITADR|INDEXOF|INI|"
    r"TRUNC(?:_INT)?|MOVE|MUX|SEL|LIMIT|MIN|MAX|ABS|SQRT|LN|LOG|EXP|EXPT|A?SIN|A?COS|A?TAN|ATAN2|"
    r"SH[LR]|RO[LR]|LEN|LEFT|RIGHT|MID|CONCAT|INSERT|DELETE|REPLACE|FIND|[RF]_TRIG|SR|RS|"
    r"CT[UD]{1,2}|TON|TOF|TP|ANY",
    re.IGNORECASE,
)
_WORD = re.compile(r"\w+")
_WRONG_ARGUMENT = re.compile(r"an? .* is expected here|.* takes \d+ arguments|.* has no input")
#: Keywords that are not replaced in a reason.
_WORDS = frozenset(
    (
        *("ABSTRACT", "FINAL", "CLASS", "METHOD", "VAR", "CONSTANT", "EXTENDS", "IMPLEMENTS"),
        *("CONFIGURATION", "POINTER", "REFERENCE", "TO", "ARRAY", "OF", "FB_init", "FB_Init"),
        *("JMP", "LTIME", "TIME", "Ladder", "Diagram", "Function", "Block"),
    )
)
_DECLARED = re.compile(
    r"^\s*(?:FUNCTION_BLOCK|FUNCTION|PROGRAM|TYPE|INTERFACE|CLASS|NAMESPACE|"
    r"METHOD|PROPERTY|ACTION)\s+"
    r"(?:(?:PUBLIC|INTERNAL|PRIVATE|PROTECTED|ABSTRACT|FINAL)\s+)*\"?([\w.]+)"
    r"|(?:^|;|\bVAR\w*)\s*(\w+(?:\s*,\s*\w+)*)\s*:(?!=)",
    re.IGNORECASE | re.MULTILINE,
)
#: Patterns of a reference to a library in a project: TwinCAT, CODESYS (PLCopen XML), SIMATIC AX.
_REFERENCES = {
    ".plcproj": re.compile(r"<(?:Placeholder|Library)Reference Include=\"([^\",]+)"),
    ".xml": re.compile(r"<Library Name=\"#?([^\",]+)"),
    "apax.yml": re.compile(r"^\s+[\"']?(@[\w-]+/[\w-]+)[\"']?\s*:\s*[\"']?[\^~\d]", re.MULTILINE),
}


def _reason_name(name: re.Match[str]) -> str:
    """Replace a name in a reason by a placeholder. Names of the language stay unchanged."""
    return name[0] if _LANGUAGE.fullmatch(name[0]) or name[0] in _WORDS else "…"


class Kind(Enum):
    """The kind of reason for which a file is refused."""

    GAP = "gap"
    MISSING = "missing library"
    OTHER = "other"


@dataclass(frozen=True)
class Reviewed:
    """A refusal that a person has found correct, because the tool also refuses the file.

    Attributes:
        message: A pattern that matches the message with its file and line.
        why: The reason why the refusal is correct.
    """

    message: str
    why: str


@dataclass
class Refusals:
    """The refused files of a program with their kinds, and the number of files for each reason."""

    files: dict[Path, Kind] = field(default_factory=dict)
    reasons: dict[Kind, Counter[str]] = field(default_factory=dict)
    examples: dict[str, str] = field(default_factory=dict)

    def count(self, kind: Kind) -> int:
        """Return the number of refused files of a kind."""
        return sum(one is kind for one in self.files.values())

    def add(self, file: Path, kind: Kind, messages: Iterable[InputError | str]) -> None:
        """Add a refused file with the messages that decide its kind."""
        self.files[file] = kind
        reasons = self.reasons.setdefault(kind, Counter())
        seen: dict[str, str] = {}
        for message in messages:
            text = message.message if isinstance(message, InputError) else message
            seen.setdefault(_NAMES.sub(_reason_name, text), str(message))
        reasons.update(list(seen))
        for reason, example in seen.items():
            self.examples.setdefault(reason, example)

    def merge(self, other: Refusals) -> None:
        """Add the refusals of another program of the same repository."""
        self.files |= other.files
        for kind, reasons in other.reasons.items():
            self.reasons.setdefault(kind, Counter()).update(reasons)
        self.examples = {**other.examples, **self.examples}


def references(folder: Path) -> frozenset[str]:
    """Return the names of the libraries to which the projects in a folder refer."""
    found: set[str] = set()
    for file in folder.rglob("*"):
        pattern = _REFERENCES.get(file.name) or _REFERENCES.get(file.suffix.lower())
        if pattern is not None and file.is_file():
            found |= set(pattern.findall(file.read_text("utf-8", errors="replace")))
    return frozenset(found)


def classified(
    files: Sequence[Path],
    errors: Mapping[Path, Sequence[InputError]],
    libraries: frozenset[str],
    reviewed: Sequence[Reviewed] = (),
) -> Refusals:
    """Return the refused files of a program, each with its reason.

    Args:
        files: All files of the program.
        errors: The errors of each refused file, including errors that follow from another error.
        libraries: The libraries that the project refers to and that are not available.
        reviewed: Messages that a person has read and found correct.
    """
    declared = _declared(files)
    kinds = {
        file: [
            (error, _kind(error, declared, libraries, reviewed, _lacks_namespace(found)))
            for error in found
        ]
        for file, found in errors.items()
    }
    result = Refusals()
    for file, found in kinds.items():
        decided = [(error, kind) for error, kind in found if isinstance(kind, Kind)]
        for kind in Kind:  # a gap has priority over a missing library
            if messages := [error for error, one in decided if one is kind]:
                result.add(file, kind, messages)
                break
    for file, found in kinds.items():
        if file not in result.files:
            _add_consequence(file, found, declared, result)
    return result


def _kind(
    error: InputError,
    declared: Mapping[str, Path],
    libraries: frozenset[str],
    reviewed: Sequence[Reviewed],
    lacks_namespace: bool,
) -> Kind | str:
    """Return the kind of an error.

    If the error follows from an error in another declaration, return the name of this declaration
    as text.
    """
    if isinstance(error, ConsequenceError):
        return error.message
    if any(re.search(one.message, str(error)) for one in reviewed):
        return Kind.OTHER
    if error.message.startswith("C code in a pragma"):
        return Kind.OTHER  # the body of the declaration is not Structured Text
    name = _unknown_name(error)
    if not name and lacks_namespace and libraries and _is_argument(error, declared):
        return Kind.MISSING
    if not name:
        return Kind.GAP
    first, _, _ = name.partition(".")
    if name in declared or first in declared:
        return name if name in declared else first
    if _LANGUAGE.fullmatch(name):
        return Kind.GAP
    return Kind.MISSING if libraries else Kind.OTHER


def _lacks_namespace(errors: Sequence[InputError]) -> bool:
    """Return whether a file uses functions of a namespace that is not available.

    AxUnit is the unit-test framework in the SDK of SIMATIC AX. Even if a project adds its own
    function to `AxUnit.Assert`, the other functions are missing.
    """
    if any(error.message.startswith("there is no namespace ") for error in errors):
        return True
    files = {error.file for error in errors if error.file is not None}
    return any(b"AxUnit." in Path(file).read_bytes() for file in files)


def _is_argument(error: InputError, declared: Mapping[str, Path]) -> bool:
    """Return whether an error refuses the value of an argument, in a call of a declared name.

    If a file uses a namespace that is not available, the call may refer to a function of the same
    name in this namespace. SIMATIC AX selects among functions of one name by their arguments: a
    project and its test library may both contain `Equal`.
    """
    line = _line_of(error)[: max(0, (error.column or 1) - 1)]
    called = re.findall(r"(\w+)\s*\(", line)
    wrong = _WRONG_ARGUMENT.match(error.message)
    return wrong is not None and any(name.upper() in declared for name in called)


def _line_of(error: InputError) -> str:
    if error.file is None:
        return ""
    lines = Path(error.file).read_bytes().decode("latin-1").splitlines()
    return lines[error.line - 1] if error.line and error.line <= len(lines) else ""


def _unknown_name(error: InputError) -> str:
    """Return the refused name in upper case if a missing declaration may have caused the error."""
    said = _UNKNOWN.match(error.message)
    if said is not None:
        return str(said[1] or said[2] or said[3]).upper()
    if not error.message.startswith("a constant is expected here") or error.file is None:
        return ""
    words = _WORD.findall(_line_of(error), max(0, (error.column or 1) - 1))
    if len(words) > 1 and words[0].upper() in ("SIZEOF", "XSIZEOF"):
        words = words[1:]  # the type of an argument is not known
    return words[0].upper() if words else ""


def _declared(files: Sequence[Path]) -> dict[str, Path]:
    """Return the declared names in upper case, each with a file that declares it."""
    found: dict[str, Path] = {}
    for file in files:
        try:
            text = source_text(file)
        except InputError:  # even a file that is not UTF-8 declares names
            text = file.read_bytes().decode("latin-1")
        for said in _DECLARED.finditer(text):
            for name in (said[1] or said[2]).split(","):
                found.setdefault(name.strip().upper(), file)
    return found


def _add_consequence(
    file: Path,
    found: Sequence[tuple[InputError, Kind | str]],
    declared: Mapping[str, Path],
    result: Refusals,
) -> None:
    """Add a file if all of its errors follow from errors of other declarations."""
    names = {name.upper() for _, text in found for name in _WORD.findall(str(text))}
    causes = {declared[name] for name in names if name in declared}
    kinds = {result.files[one] for one in causes if one in result.files}
    kind = next((kind for kind in Kind if kind in kinds), Kind.GAP)
    result.add(file, kind, ["follows from the error of another file"])
