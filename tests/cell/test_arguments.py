"""A cell rejects an invalid argument at once, with a message of one sentence."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rcx_harness import Cell, InputError, RobotConfig
from rcx_harness.robot.config.config import RobotProgram

_NAN = math.nan


def _build(repository: Path, folder: Path, **options: Any) -> Cell:
    program = repository / "tests" / "cell" / "programs" / "RawArea.st"
    return Cell.build(program, lib=folder, engine="builtin", **options)


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cell]:
    """Return a cell that all tests of this file share. A rejected call does not change the cell."""
    with _build(Path(__file__).parents[2], tmp_path_factory.mktemp("lib")) as made:
        yield made


@pytest.mark.parametrize("number", [-1, _NAN, True, 1.5, "2", None, 10**30])
def test_a_number_of_scans_is_a_whole_number_from_0_on(cell: Cell, number: Any) -> None:
    """Only an integer from 0 on is a valid number of scans. Source: Cell.scan, Cell.takes."""
    with pytest.raises(InputError, match="the number of scans cannot be"):
        cell.scan(number)
    with pytest.raises(InputError, match="scans cannot be"), cell.takes(scans=number):
        raise AssertionError("the call must be refused first")
    assert (cell.scans, cell.now_us) == (0, 0)


@pytest.mark.parametrize("duration", [-1, _NAN, True, 1.5, None, [1], math.inf])
def test_a_duration_is_a_text_a_timedelta_or_whole_microseconds(cell: Cell, duration: Any) -> None:
    """Source: units.parse_us."""
    with pytest.raises(InputError, match=r"duration"):
        cell.run(duration)
    with pytest.raises(InputError, match=r"duration"):
        cell.run_until(lambda: True, within=duration)


_CALLS: list[tuple[Callable[[Cell], object], str]] = [
    (lambda c: c.run_until(False, within="1s"), "run_until needs a function, not False"),  # type: ignore[arg-type]
    (lambda c: c.inject(5), "5 is not an event"),  # type: ignore[arg-type]
    (lambda c: c.inject(["alarm"]), r"\['alarm'\] is not an event"),  # type: ignore[arg-type]
    (lambda c: c.inject("power_off", controller=True), "no controller True; the cell has 1"),
    (lambda c: c.inject("power_off", controller=1.0), "no controller 1.0"),  # type: ignore[arg-type]
    (lambda c: c.inject("power_off", controller=0), "no controller 0"),
    (lambda c: c.inject("parallel_input", port=20, on=7), "on = 7 .* is not a level; use 0 or 1"),
    (lambda c: c.inject("parallel_input", port=20, on=True), "on = True"),
    (lambda c: c.inject("parallel_input", port=99999, on=1), "port = 99999"),
    (lambda c: c.inject("alarm", group=-1, category=0), "group = -1"),
    (lambda c: c.inject("packets_lost", share=_NAN), "share = nan is not a share"),
    (lambda c: c.inject("packets_lost", share=True), "share = True is not a share"),
    (lambda c: c.inject("packets_lost", to=["robot"]), r"to = \['robot'\] is not a direction"),
    (lambda c: c.inject("packets_late", by=50), "by is not a text"),
    (lambda c: c.overrun(-1), "late_us cannot be -1"),
    (lambda c: c.overrun(_NAN), "late_us cannot be nan"),  # type: ignore[arg-type]
    (lambda c: c.change_interval(0), "rpi_us cannot be 0; use a whole number from 1000 to 3200000"),
    (lambda c: c.change_interval(True), "rpi_us cannot be True"),
    (lambda c: c.start_plc("hot"), "start = 'hot' is not a kind of start"),
    (lambda c: c.at(_NAN, lambda: None), "t_us cannot be nan"),  # type: ignore[arg-type]
    (lambda c: c.at(-1, lambda: None), "t_us cannot be -1"),
    (lambda c: c.give_area("00"), "area is '00', not bytes"),  # type: ignore[arg-type]
    (lambda c: c.robot.force("SO02", 2), "SO02 is a bit and cannot be 2"),
    (lambda c: c.robot.force("SO02", 1.0), "SO02 is a bit and cannot be 1.0"),  # type: ignore[arg-type]
    (lambda c: c.robot.force("SOW(2)", _NAN), r"SOW\(2\) is a word and cannot be nan"),  # type: ignore[arg-type]
    (lambda c: c.robot.force("SOW(2)", 0x10000), "is a word and cannot be 65536"),
    (lambda c: c.robot.hold(2), "2 is not an output"),  # type: ignore[arg-type]
    (lambda c: c.robot.hold(f"SOW({'9' * 9})"), "no signal is called"),
    (lambda c: c.robot.place_workpiece(1.5, 0), "there is no axis 1.5"),  # type: ignore[arg-type]
    (lambda c: c.robot.place_workpiece(True, 0), "there is no axis True"),
    (lambda c: c.robot.place_workpiece(1, _NAN), "a workpiece stands at"),  # type: ignore[arg-type]
]


@pytest.mark.parametrize(("call", "message"), _CALLS)
def test_an_impossible_argument_is_refused(
    cell: Cell, call: Callable[[Cell], object], message: str
) -> None:
    """A call with an invalid argument is rejected, and changes nothing.

    Source: the docstring of each method.
    """
    with pytest.raises(InputError, match=message):
        call(cell)
    assert (cell.scans, cell.now_us) == (0, 0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": 48.0}, "an area of 48.0 bytes does not exist"),
        ({"m": True}, "m cannot be True"),
        ({"n": 1.5}, "n cannot be 1.5"),
        ({"m": [_NAN]}, "m cannot be nan"),
        ({"seed": -1}, "seed cannot be -1"),
        ({"seed": True}, "seed cannot be True"),
        ({"seed": _NAN}, "seed cannot be nan"),
        ({"keep": -1}, "keep cannot be -1"),
        ({"scan": _NAN}, "the scan: nan is not a duration"),
        ({"rpi": True}, "the RPI: True is not a duration"),
        ({"jitter": 1.5}, "the jitter: 1.5 is not a duration"),
    ],
)
def test_a_cell_is_built_with_whole_numbers(
    repository: Path, tmp_path: Path, options: dict[str, Any], message: str
) -> None:
    """Source: Cell.build."""
    with pytest.raises(InputError, match=message):
        _build(repository, tmp_path, **options)


def test_two_programs_of_a_robot_cannot_have_the_same_name(tmp_path: Path) -> None:
    """Two programs of the same name are rejected: a remote command selects a program by name.

    Source: guide 4.6.1, program_name.
    """
    with pytest.raises(InputError, match="two programs named PICK; give each"):
        RobotConfig(programs=(RobotProgram("PICK"), RobotProgram("PICK", duration=5.0)))
    file = tmp_path / "robot.toml"
    file.write_text('[[programs]]\nname = "A"\n[[programs]]\n[[programs]]\nname = "A"\n')
    with pytest.raises(InputError, match=r"robot.toml:1: 'programs' has two programs named A"):
        RobotConfig.load(file)
    file.write_text('[[programs]]\n[[programs]]\nname = "MAIN"\n')
    with pytest.raises(InputError, match=r"robot.toml:1: 'programs' has two programs named MAIN"):
        RobotConfig.load(file)
