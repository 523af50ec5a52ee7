"""The time that an editor waits for the language server, in a project of 300 files."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from lsprotocol import types

from rcx_tools.bench.figure import Figure, Options, at_most, shown
from structured_text.editor.extras import Plain
from structured_text.editor.features.completion import completion
from structured_text.editor.features.hover import hover
from structured_text.editor.index import Index
from structured_text.editor.programs import Program, Programs
from structured_text.editor.settings import Settings

__all__ = ["measure"]

_FILES, _LINES, _OTHER_LINES = 300, 1000, 85
#: Longest time from the end of the pause to the diagnostics [ms].
_TARGET_MS = 150
_TIMES = 9
_PINS = 10


def measure(options: Options) -> dict[str, Figure]:
    """Measure the check after a change, hover and completion."""
    times = 3 if options.quick else _TIMES
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for number in range(_FILES - 1):
            lines = _LINES if number == _FILES - 2 else _OTHER_LINES
            (folder / f"Part{number}.st").write_text(_block(number, lines), encoding="utf-8")
        (folder / "Main.st").write_text(_main(_FILES - 2), encoding="utf-8")
        return _measured(folder, folder / f"Part{_FILES - 2}.st", times)


def _measured(folder: Path, file: Path, times: int) -> dict[str, Figure]:
    programs = Programs([folder], Settings(), Plain().find)
    text = file.read_text(encoding="utf-8")
    programs.documents.put(file, file.as_uri(), text)
    program = programs.of(file)
    place = f"a file of {text.count(chr(10)):,} lines, {_FILES} files"
    first = _ms(program.check)

    def typed(new: Callable[[int], str]) -> float:
        """Return the median time of a check after a change [ms]."""
        found = []
        for number in range(times):
            programs.documents.put(file, file.as_uri(), new(number))
            found.append(_ms(program.check))
        return statistics.median(found)

    def value(number: int) -> str:
        return text.replace("MOD 7;", f"MOD {number + 8};", 1)

    def mistake(number: int) -> str:
        return text.replace("MOD 7;", f"MOD Wrong{number};", 1)

    def line(number: int) -> str:
        return text.replace("Total :=", "\n" * (number + 1) + "Total :=", 1)

    def variable(number: int) -> str:
        return text.replace("END_VAR", f"    More{number} : INT;\nEND_VAR", 1)

    found = {
        "editor: check after a change in a body": at_most(typed(value), "ms", _TARGET_MS, place),
        "editor: check after a mistake": at_most(typed(mistake), "ms", _TARGET_MS, place),
        "editor: check after a new line": at_most(typed(line), "ms", _TARGET_MS, place),
        "editor: check after a new pin": shown(typed(variable), "ms", place),
        "editor: first check": shown(first, "ms", place),
    }
    programs.documents.put(file, file.as_uri(), text)
    at = types.Position(text[: text.index("Inner(In0")].count("\n"), 3)
    where = (file, text, at)
    hovered = _ms(lambda: hover(_index(program), *where))
    found["editor: first hover after a change"] = shown(hovered, "ms", place)
    hovers = [_ms(lambda: hover(_index(program), *where)) for _ in range(times)]
    found["editor: hover"] = at_most(statistics.median(hovers), "ms", _TARGET_MS, place)
    items = [_ms(lambda: completion(_index(program), *where)) for _ in range(times)]
    found["editor: completion"] = at_most(statistics.median(items), "ms", _TARGET_MS, place)
    return found


def _index(program: Program) -> Index:
    found = program.index()
    assert found is not None
    return found


def _ms(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return (time.perf_counter() - begin) * 1000


def _block(number: int, lines: int) -> str:
    """Return a function block of this length, which uses another block."""
    found = [f"FUNCTION_BLOCK Part{number}", "VAR_INPUT"]
    found += [f"    In{pin} : INT; (* input {pin} *)" for pin in range(_PINS)]
    found += ["END_VAR", "VAR_OUTPUT", "    Done : BOOL;", "    Total : DINT;", "END_VAR", "VAR"]
    found += [f"    Inner : Part{(number - 1) // 2};"] if number else []
    found += ["    Delay : TON;", "    Count : INT;", "    Limit : REAL := 1.5;", "END_VAR", ""]
    step = 0
    while len(found) < lines - 5:
        found += [
            f"IF In{step % _PINS} > {step} AND NOT Done THEN",
            f"    Count := Count + In{(step + 3) % _PINS} * 2;",
            "ELSE",
            f"    Limit := Limit * 1.01 + INT_TO_REAL(Count);  // step {step}",
            "END_IF;",
            f"Total := INT_TO_DINT(Count) + Total MOD {step + 1};",
        ]
        step += 6
    if number:
        found.append("Inner(In0 := Count, In1 := In2);")
    found += ["Delay(IN := Count > 3, PT := T#1s);", "Done := Delay.Q;", "END_FUNCTION_BLOCK", ""]
    return "\n".join(found)


def _main(last: int) -> str:
    variable = f"VAR\n    P : Part{last};\nEND_VAR"
    return f"PROGRAM Main\n{variable}\nP(In0 := 1);\nEND_PROGRAM\n"
