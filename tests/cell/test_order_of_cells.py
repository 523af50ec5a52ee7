"""If cells of one program run one after the other, no cell depends on earlier cells.

A process caches the compiled program, its first state, results about its sources, and the robot's
properties for the next cell. The tests therefore perform all actions of a list on cells: in the
order of the list, in reverse and in random order. Each run must equal a run in a new process.
"""

from __future__ import annotations

import os
import random
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from rcx_harness import Cell
from rcx_harness.new import new_project
from rcx_harness.robot.stored import Point
from structured_text.engines.load import why_not

_WATCH = ("Main.Stage", "Main.Parts", "Main.Robot.Status")


def _starts(cell: Cell) -> None:
    cell["Main.CellSafe"] = True
    cell.run("600ms")
    cell["Main.Start"] = True
    cell.run("50ms")
    cell["Main.Start"] = False
    cell.run("1s")


def _waits(cell: Cell) -> None:
    cell.run("1s")


def _loses_its_link(cell: Cell) -> None:
    _starts(cell)
    cell.inject("link_down")
    cell.run("500ms")
    cell.inject("link_up")
    cell.run("500ms")


def _loses_its_power(cell: Cell) -> None:
    _starts(cell)
    cell.inject("plc_power_off")
    cell.run("100ms")
    cell.inject("plc_power_on", start="cold")
    cell.inject("power_cycle")
    cell.run("1s")


def _has_other_points(cell: Cell) -> None:
    cell.robot.points[1] = Point((5000, 5000, 0, 0, 0, 0))
    cell.robot.positions[0] = 777
    _starts(cell)


def _is_held_and_disturbed(cell: Cell) -> None:
    cell.robot.hold("SO02")
    cell.inject("packets_late", share=0.5, by="30ms")
    cell.inject("packet_interval", rpi="20ms")
    _starts(cell)
    cell.inject("alarm")
    cell.run("300ms")


def _goes_back(cell: Cell) -> None:
    begun = cell.snapshot()
    _starts(cell)
    cell.restore(begun)
    cell.run("300ms")


def _has_variables_set(cell: Cell) -> None:
    cell["Main.Parts"] = 41
    cell["Main.LastPart"] = True
    _starts(cell)


_ACTIONS: dict[str, Callable[[Cell], None]] = {
    act.__name__: act
    for act in (
        *(_starts, _waits, _loses_its_link, _loses_its_power, _has_other_points),
        *(_is_held_and_disturbed, _goes_back, _has_variables_set),
    )
}


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder with the program and the robot that `rcx new` writes."""
    folder = tmp_path_factory.mktemp("rcx") / "cell"
    new_project(folder)
    return folder


def _run(project: Path, act: str, engine: str) -> tuple[object, ...]:
    """Build a cell, perform one action on it, and return the trace and all values at the end."""
    with Cell.build(
        sorted(project.glob("plc/*.st")), robot=project / "robot.toml", engine=engine,
        watch=_WATCH, positions="pulses",
    ) as cell:  # fmt: skip
        _ACTIONS[act](cell)
        every = {path: cell[path] for path, _ in cell.program.walk()}
        return list(cell.trace), list(cell.violations), dict(cell.robot.points), every


def _alone(project: Path, act: str, engine: str) -> str:
    """Run the same action in a new process, and return its printed results."""
    here = Path(__file__)
    code = (
        f"import sys; sys.path.insert(0, {os.fspath(here.parent)!r}); "
        f"from pathlib import Path; import {here.stem} as it; "
        f"print(it._run(Path({os.fspath(project)!r}), {act!r}, {engine!r}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        check=True, stdout=subprocess.PIPE, encoding="utf-8", env={**os.environ, "PYTHONUTF8": "1"},
    )  # fmt: skip
    return done.stdout.removesuffix("\n")


def _orders() -> list[Sequence[str]]:
    """Return the actions in reverse order and in a random order."""
    return [list(reversed(_ACTIONS)), random.Random(1).sample(list(_ACTIONS), len(_ACTIONS))]


@pytest.mark.exhaustive
@pytest.mark.parametrize("engine", ["builtin", "matiec"])
def test_every_order_of_cells_gives_the_same_runs(project: Path, engine: str) -> None:
    """Each action has the same result in every order. Source: docs/how-to/testing.md, `cell`."""
    if engine != "builtin" and (missing := why_not(engine)):
        pytest.skip(missing)
    first = {act: _run(project, act, engine) for act in _ACTIONS}
    assert len(set(map(repr, first.values()))) == len(_ACTIONS), "two acts have the same effect"
    for order in _orders():
        for act in order:
            assert _run(project, act, engine) == first[act], (
                f"{act}, in the order {', '.join(order)}"
            )


@pytest.mark.exhaustive
def test_a_run_after_other_runs_equals_a_run_in_a_new_process(project: Path) -> None:
    """A run after others equals a run in a new process. Source: docs/how-to/testing.md, `cell`."""
    for act in ("_has_other_points", "_loses_its_power", "_starts"):
        found = _run(project, act, "builtin")
    assert repr(found) == _alone(project, act, "builtin")
