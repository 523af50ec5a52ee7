"""Examples 04 and 07 recover from every fault of `rcx sweep` at a sample of scans.

To test every scan, use the same calls without `--every`, `--workers 0` and `--engine`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.cli.app import main
from rcx_harness.robot.ports import port
from rcx_tools.docs.examples import examples

_LONG_FAULTS = (
    *("emergency_stop", "link_down", "packets_lost", "packets_late", "packets_doubled", "plc_stop"),
    *("plc_power_off", "power_off", "main_power_off", "warning", "pendant_on", "manual_mode"),
    *("auto_input_off", "manual_lock_on", "safety_on", "parallel_stop"),
)
_SHORT = ("plc_overrun", "power_cycle", "alarm", "program_end")
_FAULTS = (*_LONG_FAULTS, *_SHORT, "Main.CellSafe=false")
#: Duration of the run without faults. The run of 07 ends after the pallet is full.
_RUNS = {"04_pick_and_place": "4200ms", "07_pallet": "9000ms"}
_HAND, _TRAY = port("DO(20)"), (-60_000, 80_000)


def _sweep(name: str, out: Path, program: Path, faults: tuple[str, ...], every: int) -> int:
    example = ROOT / "plc/examples" / name
    return main(
        [
            *("sweep", str(program), f"--robot={example / 'robot.toml'}", f"--out={out}"),
            f"--properties={ROOT / 'tests/data/sweeps' / f'{name}.toml'}",
            *(f"--stimulus={example / 'stimulus.toml'}", f"--for={_RUNS[name]}"),
            *(f"--inject={','.join(faults)}", f"--every={every}", "--engine=builtin"),
            "--workers=0",
        ]
    )


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("name", "every"), [("04_pick_and_place", 157), ("07_pallet", 283)], ids=list(_RUNS)
)
def test_the_example_recovers_from_every_fault(
    name: str, every: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The example meets the conditions in tests/data/sweeps after each fault.

    Source: docs/how-to/campaign.md.
    """
    program = ROOT / "plc/examples" / name
    assert _sweep(name, tmp_path / "out", program, _FAULTS, every) == 0
    assert "the cell recovers from all of them" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_a_program_that_starts_by_itself_is_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The sweep finds a changed program that starts by itself after Reset."""
    example = ROOT / "plc/examples/04_pick_and_place"
    text = (example / "PickPlace.st").read_text(encoding="utf-8")
    for before, after in (
        ("Start := Start,", "Start := Start OR Again,"),
        ("  WriteArea(", "  Again := Cycle.State = WORK_IDLE AND Cycle.Count > 0;\n  WriteArea("),
        ("    Robot      :", "    Again : BOOL;\n    Robot      :"),
    ):  # fmt: skip
        assert before in text
        text = text.replace(before, after, 1)
    program = tmp_path / "plc"
    program.mkdir()
    (program / "PickPlace.st").write_text(text, encoding="utf-8")
    (program / "Config.st").write_bytes((example / "Config.st").read_bytes())
    out = tmp_path / "out"
    assert _sweep("04_pick_and_place", out, program, ("emergency_stop",), 280) == 1
    assert "always nothing starts without Start" in capsys.readouterr().out


def _opened_at(event: str, at_ms: int) -> list[tuple[int, ...]]:
    """Run example 04 with a fault, Reset and Start; return each position where the hand opened."""
    opened = []
    with examples()["04_pick_and_place"].build("builtin") as cell:

        def run(ms: int) -> None:
            for _ in range(ms // 10):
                was = _closed(cell)
                cell.scan()
                if was and not _closed(cell):
                    opened.append(tuple(cell.robot.positions[:2]))

        run(at_ms)
        if event == "door":
            cell["Main.CellSafe"] = False
        else:
            cell.inject(event)
        run(500)
        if event == "door":
            cell["Main.CellSafe"] = True
        else:
            cell.inject({"link_down": "link_up"}.get(event, f"{event}_release"))
        run(2800 - at_ms)  # end before the stimulus presses Stop at 3 s
        for button in ("Main.Reset", "Main.Start"):
            cell[button] = True
            run(100)
            cell[button] = False
            run(100)
        count = cell["Main.Cycle.Count"]
        run(3000)
        assert cell["Main.Cycle.Count"] > count
    return opened


def _closed(cell: Cell) -> bool:
    return bool(cell.robot.machine.ports.read(_HAND))


@pytest.mark.exhaustive(but=["door"])
@pytest.mark.parametrize("event", ["door", "emergency_stop", "link_down"])
def test_after_each_interruption_the_hand_opens_only_at_the_tray(event: str) -> None:
    """After a fault while the robot grips, carries or places, the hand opens only at the tray.

    Source: head of FB_PickPlace.
    """
    for at_ms in (1240, 1290, 1500, 1780):
        opened = _opened_at(event, at_ms)
        assert len(opened) >= 2
        assert set(opened) == {_TRAY}, f"{event} at {at_ms} ms"
