"""Each command lets counters count beyond PV, or up to PV in the dialect of OpenPLC."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from rcx_harness.cli.debug import launched

Captured = pytest.CaptureFixture[str]

_PROGRAM = """PROGRAM Main
  VAR Entry : BOOL; Parts : CTU; END_VAR
  Parts(CU := Entry, R := Parts.CV > 2, PV := 2);
  (* prove: Parts.CV <= 2 *)
END_PROGRAM
"""
_DIALECTS = [([], 3), (["--dialect", "tia"], 3), (["--dialect", "openplc"], 2)]


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("RCX_MATIEC", raising=False)
    Path("parts.st").write_text(_PROGRAM, encoding="utf-8")
    return "parts.st"


@pytest.mark.parametrize("command", ["explore", "prove"])
@pytest.mark.parametrize(("dialect", "most"), _DIALECTS)
def test_counters_count_beyond_pv_unless_the_dialect_limits_them(
    file: str, command: str, dialect: list[str], most: int, capsys: Captured
) -> None:
    """The third pulse breaks the property only if counters count beyond PV.

    Source: IEC 61131-3, counters: CV < PVmax; matiec, lib/counter.txt.
    """
    inputs = ["--input", "Main.Entry"] if command == "explore" else []
    assert main([command, file, "--no-robot", *inputs, *dialect]) == (1 if most > 2 else 0)
    said = capsys.readouterr().out
    assert ("in scan 5" in said or "after 5 scans" in said) is (most > 2)


@pytest.mark.parametrize("coverage", [[], ["--coverage"]])
@pytest.mark.parametrize(("dialect", "most"), _DIALECTS)
def test_a_run_with_coverage_counts_as_a_run_without_it(
    file: str, coverage: list[str], dialect: list[str], most: int
) -> None:
    """A run with coverage counts as a run without it.

    Source: IEC 61131-3, counters: CV < PVmax; matiec, lib/counter.txt.
    """
    steps = [
        f'{{ time = "{10 * scan}ms", set = {{ "Main.Entry" = {str(scan % 2 == 0).lower()} }} }}'
        for scan in range(6)
    ]
    Path("s.toml").write_text(f"at = [{', '.join(steps)}]", encoding="utf-8")
    run = ["run", file, "--no-robot", "--for", "60ms", "--stimulus", "s.toml"]
    main([*run, "--watch", "Main.Parts.CV", "--trace", "t.jsonl", *coverage, *dialect])
    trace = [json.loads(line) for line in Path("t.jsonl").read_text("utf-8").splitlines()]
    counted = [one["vars"]["Main.Parts.CV"] for one in trace if "Main.Parts.CV" in
               one.get("vars", {})]  # fmt: skip
    assert max(counted) == most


@pytest.mark.parametrize(("dialect", "most"), _DIALECTS)
def test_the_debugger_counts_as_the_dialect_says(file: str, dialect: list[str], most: int) -> None:
    """In the debugger, counters count as in the dialect of the launch.

    Source: IEC 61131-3, counters: CV < PVmax; matiec, lib/counter.txt.
    """
    launch = {"program": file, "noRobot": True, "for": "1s"}
    machine = launched({**launch, **({"dialect": dialect[1]} if dialect else {})}, []).machine
    for scan in range(5):  # the inputs give pulses in scans 1, 3 and 5
        machine.program.write("Main.Entry", scan % 2 == 0)
        machine.scan()
    assert machine.program.read("Main.Parts.CV") == most
    machine.close()


def test_check_names_the_line_and_the_effect(file: str, capsys: Captured) -> None:
    """The warning names the counter's line and effect. Source: docs/reference/engines.md."""
    assert main(["check", file]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "parts.st:3:" in said
    assert "counter beyond PV or below 0 (CV of Parts): matiec stops CV at PV upwards" in said
    assert main(["check", file, "--dialect", "openplc"]) == 0
    assert "beyond PV" not in capsys.readouterr().out
