"""Example 04 also runs with a SCARA model, with points in mm that the model can reach."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rcx_harness.cli.app import main

EXAMPLE = Path(__file__).parents[2] / "plc" / "examples" / "04_pick_and_place"


def test_parts_are_moved_between_places_in_mm(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The robot reaches point 10 left-handed and point 20 right-handed, as its points demand.

    Source: remote command guide 4.2.1 and 4.2.19
    """
    trace = tmp_path / "trace.jsonl"
    run = [
        *("run", *map(str, sorted(EXAMPLE.glob("*.st"))), "--for=4s", "--engine=builtin"),
        *(f"--stimulus={EXAMPLE / 'stimulus.toml'}", f"--robot={EXAMPLE / 'scara.toml'}"),
        *(f"--trace={trace}", "--positions=mm"),
    ]
    assert main(run) == 0
    assert "no violations" in capsys.readouterr().out
    lines = [json.loads(line) for line in trace.read_text(encoding="utf-8").splitlines()]
    places = [tuple(line["positions"]) for line in lines if "positions" in line]
    for point in ((250, 400, 120, 0), (-300, 350, 80, 90)):
        assert any(place == pytest.approx(point, abs=0.01) for place in places), point
