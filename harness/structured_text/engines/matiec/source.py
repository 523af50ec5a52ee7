"""The joined text of all sources for iec2c, and the user's lines for the errors in this text."""

from __future__ import annotations

import re
import signal
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from structured_text.engines.matiec.build import Matiec, RefusedCodeError, TranslationError
from structured_text.errors import InputError
from structured_text.language.project import Project
from structured_text.language.source import origin, source_text

__all__ = [
    "HIDDEN_INSTANCE",
    "SourceText",
    "explain",
    "explain_code",
    "hidden_instance",
    "join_sources",
]

#: C name of the program instance if the sources have no CONFIGURATION. The default `Main` may be
#: the name of the program itself, and matiec refuses an instance with the name of its type.
HIDDEN_INSTANCE = "HARNESS_HIDDEN_INSTANCE"

_CONFIGURATION = f"""
CONFIGURATION HARNESS_HIDDEN_CONFIGURATION
  RESOURCE HARNESS_HIDDEN_RESOURCE ON PLC
    TASK HARNESS_HIDDEN_TASK(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM {HIDDEN_INSTANCE} WITH HARNESS_HIDDEN_TASK : {{program}};
  END_RESOURCE
END_CONFIGURATION
"""
_IN_LIBRARY = re.compile(r"^([\w.]+\.txt):(\d+)-", re.MULTILINE)
_WORD = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True)
class SourceText:
    """All sources in one text.

    Attributes:
        text: The text for iec2c.
        files: The source files, in the order in which the text contains them.
        starts: The line of the text at which each file starts; the first line is 1.
    """

    text: str
    files: tuple[Path, ...]
    starts: tuple[int, ...]

    def place(self, line: int) -> tuple[Path, int]:
        """Return the file, and the line in this file, for a line of the joined text."""
        index = bisect_right(self.starts, line) - 1
        file = self.files[index]
        return file, origin(file, line - self.starts[index] + 1, 1)[0]


def hidden_instance(name: str, project: Project) -> str:
    """Return the C name of an instance, which differs from the names of all POUs."""
    clashes = any(pou.upper() == name.upper() for pou in project.pous)
    return f"{HIDDEN_INSTANCE}_{name.upper()}" if clashes else name


def join_sources(project: Project) -> SourceText:
    """Join the files in the order of the project, and add a CONFIGURATION if there is none."""
    parts: list[str] = []
    starts: list[int] = []
    line = 1
    for file in project.files:
        part = "\n".join(source_text(file).splitlines()) + "\n"
        for name in project.instances if project.configured else ():
            if hidden_instance(name, project) != name:
                named = re.compile(rf"(\bPROGRAM\s+){name}(?=\s*(?:WITH\b|:))", re.IGNORECASE)
                part = named.sub(rf"\g<1>{hidden_instance(name, project)}", part)
        starts.append(line)
        parts.append(part)
        line += part.count("\n")
    if not project.configured:
        (program,) = project.instances.values()
        parts.append(_CONFIGURATION.format(program=program.name))
    return SourceText("".join(parts), project.files, tuple(starts))


def explain(
    error: TranslationError, source: SourceText, project: Project, matiec: Matiec
) -> InputError:
    """Return iec2c's error as an InputError at the user's file and line."""
    for message in error.messages:
        file, line = source.place(message.line)
        return InputError(
            f"matiec: {message.text}",
            file=file,
            line=line,
            column=message.column,
            hint="write it another way, or use the built-in engine, which accepts it",
        )
    for unit, word in _clashes(error.output, project, matiec):
        return InputError(
            f"matiec uses the name {word} inside its own library",
            file=unit[0],
            line=unit[1],
            hint="choose another name, for instance with a prefix",
        )
    if error.status < 0:
        return _crash(error, source)
    lines = [line for line in error.output.splitlines() if line.strip()]
    said = lines[0] if lines else "nothing"
    return InputError(
        f"iec2c failed with status {error.status} and said: {said}",
        file=source.files[0] if len(source.files) == 1 else None,
        hint=f"check the installation of matiec: {matiec.iec2c}",
    )


def explain_code(error: RefusedCodeError, project: Project) -> InputError:
    """Return the error for C code that the C compiler refuses, at the POU that iec2c translated."""
    pou = project.pous.get(error.pou)
    unit = next((unit for unit in project.units if unit.name.upper() == error.pou), None)
    said = error.reason.split("error: ", 1)[-1]
    return InputError(
        f"matiec makes C code{f' of {pou.name}' if pou else ''} that does not compile: {said}",
        file=unit.file if unit else None,
        line=unit.line if unit else None,
        hint="this is a fault of matiec: write it another way, or use --engine builtin",
    )


def _crash(error: TranslationError, source: SourceText) -> InputError:
    """Return the error for a crash of iec2c by a signal.

    The fault is in matiec, but something in the user's program has triggered it.
    """
    try:
        name = signal.Signals(-error.status).name
    except ValueError:
        name = f"signal {-error.status}"
    several = f" or one of {len(source.files) - 1} more files" if len(source.files) > 1 else ""
    return InputError(
        f"iec2c, the compiler of matiec, crashed on this program{several} ({name})",
        file=source.files[-1],
        hint="run it with --engine builtin; for matiec divide long expressions and deep nesting",
    )


def _clashes(
    output: str, project: Project, matiec: Matiec
) -> Iterator[tuple[tuple[Path, int], str]]:
    """Yield declarations with a name that matiec's library uses for a variable.

    With forward references allowed, every type and block of the user is known before the library
    is read. Therefore a variable of the library must not have the name of such a type or block.
    """
    units = {unit.name.upper(): unit for unit in project.units}
    for match in _IN_LIBRARY.finditer(output):
        path = matiec.library / match[1]
        if not path.is_file():
            continue
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
        for word in _WORD.findall(lines[int(match[2]) - 1]):
            if unit := units.get(word.upper()):
                yield (unit.file, unit.line), unit.name
