"""Generators of parts of diagnosis.md: a program, a panel with values of a run, tables of texts.

The page is handwritten, except the parts between `<!-- made: NAME -->` and `<!-- end -->`. The
panel shows a run of docs/how-to/diagnosis/Diagnosis.st in the virtual cell.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import redirect_stdout
from functools import lru_cache
from pathlib import Path
from typing import Any

from rcx_harness import spec
from rcx_harness.cli.codec import decode
from structured_text.output.toml_files import load_toml

__all__ = ["PROGRAM", "diagnosis_page", "panel", "run_panel"]

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = ROOT / "docs/how-to/diagnosis/Diagnosis.st"

_PART = re.compile(r"(<!-- made: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
_WIDTH = 92


def diagnosis_page() -> str:
    """Return diagnosis.md with new generated parts."""
    text = (ROOT / "docs/how-to/diagnosis.md").read_text(encoding="utf-8")
    return _PART.sub(lambda found: f"{found[1]}{_MAKERS[found[2]]()}\n{found[3]}", text)


@lru_cache(maxsize=1)
def run_panel() -> Mapping[str, Any]:
    """Return the outputs of the blocks after the second movement has failed, 3 s after Start.

    Returns:
        `Recorder`, `Channels` and `Why` of the program, each with its outputs by name.
    """
    from rcx_harness.cell import Cell  # imported here, because other pages do not need this import

    shown = {
        "Recorder": ("Rows", "Fault", "FaultCode", "FaultData", "Frozen", "Total"),
        "Channels": ("Command", "Sequence"),
        "Why": ("Subject", "Text"),
    }
    robot = PROGRAM.with_name("robot.toml")
    with Cell.build([PROGRAM], scan="10ms", engine="builtin", robot=robot) as cell:
        cell["Main.CellSafe"] = True
        cell.run("500ms")
        cell["Main.Start"] = True
        cell.run("3s")
        assert not cell.violations
        return {
            block: {name: cell[f"Main.{block}.{name}"] for name in names}
            for block, names in shown.items()
        }


def panel() -> str:
    """Return the panel as text, with the values of the run."""
    now = run_panel()
    recorder, why, turns = now["Recorder"], now["Why"], now["Channels"]
    fault, text = recorder["Fault"], why["Text"]
    line = "+" + "-" * _WIDTH + "+"
    state = "recording stopped" if recorder["Frozen"] else "recording"
    rows = [
        f"Fault at {fault['Moment']} ms: {why['Subject']}, {_result(fault)}",
        text["Name"],
        *(text[name] for name in ("Cause1", "Cause2") if text[name]),
        *(f"> {text[name]}" for name in ("Remedy1", "Remedy2") if text[name]),
    ]
    log = [f"{'[ms]':>6}  {'what':<44}{'result':<26}{'lasted [ms]':>11}"]
    for row in recorder["Rows"]:
        lasted = str(row["Duration"]) if row["Kind"] == "LOG_COMMAND" else ""
        log.append(f"{row['Moment']:>6}  {_subject(row):<44}{_result(row):<26}{lasted:>11}")
    log.append(f"{state}, {recorder['Total']} entries since the start")
    held = [_turn(name, turns[name]) for name in ("Command", "Sequence")]
    parts = ((rows, "[ Reset ]"), (log, "[ Page ]"), (held, ""))
    made = [line]
    for lines, button in parts:
        made += _framed(lines, button)
        made.append(line)
    return "```text\n" + "\n".join(made) + "\n```"


def _framed(lines: list[str], button: str) -> Iterator[str]:
    for number, one in enumerate(lines, 1):
        right = button if number == len(lines) else ""
        yield f"| {one:<{_WIDTH - 2 - len(right)}}{right} |"


def _subject(row: Mapping[str, Any]) -> str:
    """Return the text for Kind and Number in a panel (from docs/reference/texts.csv)."""
    kind, number = row["Kind"], row["Number"]
    if kind == "LOG_COMMAND":
        return spec.commands()[number & 0x0FFF].name
    if kind in ("LOG_INPUT", "LOG_OUTPUT"):
        signal = spec.signals().find(f"{'SI' if kind == 'LOG_INPUT' else 'SO'}{number:02X}")
        return f"{signal.signal} {signal.title}"
    return {"LOG_LINK": "Connection", "LOG_ERROR": "Block"}[kind]


def _result(row: Mapping[str, Any]) -> str:
    if row["Kind"] in ("LOG_INPUT", "LOG_OUTPUT", "LOG_LINK"):
        return "ON" if row["Result"] else "OFF"
    alarm = f", {row['Group']}.{row['Category']}" if row["Group"] else ""
    return f"16#{row['Result']:04X}{alarm}"


def _turn(name: str, turn: Mapping[str, Any]) -> str:
    holder = f"16#{turn['Holder']:04X} for {turn['Held']} ms" if turn["Taken"] else "free"
    longest = f"longest {turn['Longest']} ms (16#{turn['LongestHolder']:04X})"
    return f"{name} channel: {holder}, {turn['Waiting']} waiting, {longest}"


def _program() -> str:
    """Return the statements of the program Diagnosis.st."""
    body = PROGRAM.read_text(encoding="utf-8").rpartition("END_VAR\n")[2]
    lines = body.partition("END_PROGRAM")[0].strip("\n").splitlines()
    return "```iecst\n" + "\n".join(line.removeprefix("  ") for line in lines) + "\n```"


def _telegram() -> str:
    recorder = run_panel()["Recorder"]
    words = [recorder["FaultCode"], *recorder["FaultData"]]
    last = max(number for number, word in enumerate(words) if word)
    given = [f"0x{word:04X}" for word in words[: last + 1]]
    page = io.StringIO()
    with redirect_stdout(page):
        decode(given, "")
    return f"```text\n$ rcx decode {' '.join(given)}\n{page.getvalue()}```"


def _alarms() -> str:
    rows = [(row["number"], row, "") for row in load_toml(spec.folder() / "alarms.toml")["alarm"]]
    return "\n".join(_both("Alarm", rows))


def _errors() -> str:
    rows = [
        (f"`16#{row['id']:04X}`", row, "../reference/errors.md")
        for row in load_toml(spec.folder() / "errors.toml")["error"]
    ]
    return "\n".join(_both("ErrorID", rows))


def _both(title: str, rows: list[tuple[str, Mapping[str, Any], str]]) -> Iterator[str]:
    """Yield a table in English and Japanese, with details only if no other page has them."""
    yield f"| {title} | English | 日本語 |\n|---|---|---|"
    for number, row, page in rows:
        english = row["name"] if page else f"**{row['name']}**<br>{row['cause']}<br>{row['remedy']}"
        japanese = f"**{row['name_ja']}**<br>{row['cause_ja']}<br>{row['remedy_ja']}"
        yield f"| {number} | {english} | {japanese} |"


_MAKERS: Mapping[str, Callable[[], str]] = {
    "program": _program,
    "panel": panel,
    "telegram": _telegram,
    "alarms": _alarms,
    "errors": _errors,
}
