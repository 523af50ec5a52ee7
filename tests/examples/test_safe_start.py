"""In no program that users may copy can the robot move before the user wires CellSafe."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from rcx_harness.cli.app import main

_ROOT = Path(__file__).resolve().parents[2]
_COPIED = ("plc/examples", "docs", "harness/rcx_harness/new/template")
_PIN = re.compile(r"\b(?:EmergencyStopOk|StopOk)\s*:=\s*([^,;)]+)")
_PINS_ON = re.compile(r"\b(?:EmergencyStopOk|StopOk)\b[^;]*:\s*BOOL\s*:=\s*TRUE", re.IGNORECASE)


def _texts() -> Iterator[tuple[str, str]]:
    """Yield the name and text of each program, and of each code snippet in the pages."""
    files = [_ROOT / "README.md"]
    for folder in _COPIED:
        files += [one for one in (_ROOT / folder).rglob("*") if one.suffix in (".st", ".md")]
    for file in files:
        text, name = file.read_text(encoding="utf-8"), str(file.relative_to(_ROOT))
        if file.suffix == ".st":
            yield name, text
        else:
            yield from ((name, one) for one in re.findall(r"```[^\n]*\n(.*?)```", text, re.DOTALL))


def _unwired(text: str) -> list[str]:
    """Return the parts of a program that turn SI(00) or SI(06) ON without a signal from outside.

    Such parts are the constant TRUE, or a variable with the initial value TRUE.
    """
    names = {name for given in _PIN.findall(text) for name in re.findall(r"\b[A-Za-z_]\w*", given)}
    on = [name for name in names if re.search(rf"\b{name}\b[^:;]*:\s*BOOL\s*:=\s*TRUE", text)]
    return [*on, *(["TRUE"] if "TRUE" in names else []), *_PINS_ON.findall(text)]


def test_si00_and_si06_stay_off_until_the_user_has_wired_them() -> None:
    """No program turns SI(00) or SI(06) ON by itself.

    Source: manual chapter 5, 2; design, section 7.
    """
    programs = list(_texts())
    found = {name: one for name, text in programs if (one := _unwired(text))}
    assert not found
    assert sum("EmergencyStopOk :=" in text for _, text in programs) > 170


@pytest.mark.parametrize(
    "text",
    [
        "CellSafe : BOOL := TRUE;\nWriteArea(Robot := Robot, EmergencyStopOk := CellSafe);",
        "Closed, Guarded : BOOL := TRUE;\nWriteArea(StopOk := Closed AND NOT Halt);",
        "WriteArea(Robot := Robot, EmergencyStopOk := TRUE, StopOk := CellSafe);",
        "EmergencyStopOk : BOOL := TRUE;",
    ],
)
def test_the_check_finds_inputs_that_are_on_without_wiring(text: str) -> None:
    assert _unwired(text)


@pytest.mark.parametrize("with_stimulus", [False, True])
def test_a_run_without_cell_safe_shows_how_to_set_it(
    capsys: pytest.CaptureFixture[str], with_stimulus: bool
) -> None:
    """If SI(00) stays OFF for the whole run, a hint shows how to set CellSafe.

    Source: manual chapter 5, 2, SI(00): OFF is the emergency stop.
    """
    folder = _ROOT / "plc/examples/01_power_up"
    beside = folder / "stimulus.toml"
    options = ["--robot", str(folder / "robot.toml"), "--for", "500ms", "--engine", "builtin"]
    options += ["--stimulus", str(beside)] if with_stimulus else []
    assert main(["run", str(folder), *options]) == 0
    told = [line for line in capsys.readouterr().out.splitlines() if "SI(00)" in line]
    if with_stimulus:
        assert told == []
    else:
        (line,) = told
        assert 'at = [{ time = "100ms", set = { "Main.CellSafe" = true } }]' in line
        assert line.endswith(f"there is one beside the program: --stimulus {beside}")
