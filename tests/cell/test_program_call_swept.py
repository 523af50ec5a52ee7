"""FB_ProgramCall and plc/robot/JOBS.PGM are tested with every fault at every scan of two jobs.

Each job has its own number. The robot program turns SO(22) ON if it begins a job for the second
time, and returns the values that it received. The PLC requests a job until it is done, or until the
robot program reports an interruption. The conditions for each run are in
tests/data/program_call/demands.toml; `rcx sweep` uses this file as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from example_runs import changes
from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.cell.surroundings import opposite
from rcx_harness.cli.app import main
from rcx_harness.robot.program import read_program
from rcx_harness.robot.program.checks import problems
from structured_text.engines.base import Value

_FOLDER = ROOT / "tests/data/program_call"
_LASTING = (
    *("emergency_stop", "link_down", "packets_lost", "packets_late", "packets_doubled", "plc_stop"),
    *("plc_power_off", "power_off", "main_power_off", "warning", "pendant_on", "manual_mode"),
    *("auto_input_off", "manual_lock_on", "safety_on", "parallel_stop", "CellSafe"),
)
_SHORT = ("plc_overrun", "power_cycle", "alarm", "program_end")
_FAULTS = (*_LASTING, *_SHORT)
#: After these faults the robot program begins at its first line, even in the variants of _WAYS in
#: which it continues after other faults.
_RESETTING = ("power_off", "power_cycle", "program_end")
#: Variants of a run, with the pins of Caller.st. "reset" restarts the robot program after each
#: fault, and "go on" continues it. "beside a command" repeats another remote command during the
#: jobs. "slow" executes one statement in each cycle of 5 ms.
_WAYS: dict[str, dict[str, Value]] = {
    "reset": {},
    "go on": {"Keep": True},
    "beside a command": {"Beside": True},
    "slow": {},
    "slow, go on": {"Keep": True},
}


#: Maximum number of scans in which two jobs must be complete.
_LONGEST = 100


def _jobs() -> str:
    """Return the text of JOBS.PGM, with its last routine replaced by JOB2.PGM of the test."""
    text = (ROOT / "plc/robot/JOBS.PGM").read_text(encoding="utf-8")
    before, mark, _ = text.partition("*JOB2:\n")
    assert mark
    return before + (_FOLDER / "JOB2.PGM").read_text(encoding="utf-8")


def test_the_robot_program_as_it_is_shipped_has_no_error_and_no_warning() -> None:
    """JOBS.PGM has no errors or warnings. Its lines have at most 80 characters."""
    text = (ROOT / "plc/robot/JOBS.PGM").read_text(encoding="ascii")
    read, errors = read_program(text)
    assert errors == []
    assert read is not None
    assert problems(read, 48) == []
    assert max(map(len, text.splitlines())) <= 80


class Swept:
    """A cell that has a snapshot before each scan of two jobs.

    Args:
        way: The variant of the run, a key of _WAYS.
        jobs: The text of the robot program.
        lib: Folder of the library; None for plc/lib.
    """

    def __init__(self, way: str, jobs: str | None = None, lib: Path | None = None) -> None:
        with TemporaryDirectory() as folder:
            robot = Path(folder) / "robot.toml"
            robot.with_name("JOBS.PGM").write_text(jobs or _jobs(), encoding="utf-8")
            speed = "program_statements = 1\n" if way.startswith("slow") else ""
            robot.write_text(f'{speed}[[programs]]\nfile = "JOBS.PGM"\n', encoding="utf-8")
            caller = _FOLDER / "Caller.st"
            self.cell = Cell.build(caller, lib=lib, engine="builtin", robot=robot)
        self["CellSafe"] = True
        for name, value in _WAYS[way].items():
            self[name] = value
        self.cell.run("500ms")
        self.press()
        self.cell.run_until(lambda: self["Count"] == 1, within="4s")
        self.moments = list(self._two_jobs())

    def __getitem__(self, name: str) -> Value:
        return self.cell[f"Main.{name}"]

    def __setitem__(self, name: str, value: Value) -> None:
        self.cell[f"Main.{name}"] = value

    def _two_jobs(self) -> Iterator[object]:
        for _ in range(_LONGEST):
            # Count was 1 at the first snapshot, so 3 means that two more jobs are done
            if self["Count"] == 3:
                return
            yield self.cell.snapshot()
            self.cell.scan()

    def press(self) -> None:
        """Press Start, and run the cell until power-up is complete."""
        self["Start"] = True
        self.cell.run("50ms")
        self["Start"] = False
        self.cell.run_until(lambda: not self["PowerUp.Busy"], within="20s")

    def disturb(self, fault: str) -> None:
        """Inject a fault. If the fault lasts, remove it after 300 ms."""
        if fault == "CellSafe":
            self["CellSafe"] = False
            self.cell.run("300ms")
            self["CellSafe"] = True
        elif fault in _LASTING:
            self.cell.inject(fault)
            self.cell.run("300ms")
            event, args = opposite(fault, {})
            self.cell.inject(event, **args)
        else:
            self.cell.inject(fault)
            self.cell.run("300ms")
        self.cell.run("100ms")

    def judge(self, moment: int, fault: str) -> str:
        """Inject a fault before scan `moment`, and return the resulting errors, or ""."""
        self.cell.restore(self.moments[moment])
        self.disturb(fault)
        self.cell.run_until(lambda: not self["PowerUp.Busy"], within="20s")
        self.press()
        count = self["Count"]
        try:
            self.cell.run_until(lambda: self["Count"] > count, within="8s")
        except AssertionError as error:
            return f"does not come back: {error}"
        wrong = [name for name in ("Twice", "Wrong", "Unknown") if self[name]]
        if self["Interrupted"] and self["Keep"] and fault not in _RESETTING:
            wrong.append("nothing has reset the program")
        lost = self["Number"] != 1 + self["Count"] + self["Interrupted"]
        broken = [one.text for one in self.cell.violations]
        return ", ".join([*wrong, *(["a job is lost"] if lost else []), *broken[:1]])


@cache
def _swept(way: str) -> Swept:
    return Swept(way)


def _failures(swept: Swept, fault: str) -> list[str]:
    found = ((moment, swept.judge(moment, fault)) for moment in range(len(swept.moments)))
    return [f"scan {moment} of {len(swept.moments)}: {wrong}" for moment, wrong in found if wrong]


@pytest.mark.exhaustive(but=["go on-CellSafe"])
@pytest.mark.parametrize("fault", _FAULTS)
@pytest.mark.parametrize("way", list(_WAYS))
def test_no_job_is_executed_twice_or_lost_and_the_next_one_is_done(way: str, fault: str) -> None:
    """Every fault is injected before every scan.

    Source: docs/how-to/robot-program.md, FB_ProgramCall.
    """
    assert _failures(_swept(way), fault) == []


@pytest.mark.exhaustive
def test_ethernet_ip_and_the_direct_link_have_the_same_areas(tmp_path: Path) -> None:
    """The direct link and EtherNet/IP have the same areas at the same virtual times."""
    (tmp_path / "JOBS.PGM").write_text(_jobs(), encoding="utf-8")
    robot = tmp_path / "robot.toml"
    robot.write_text('[[programs]]\nfile = "JOBS.PGM"\n', encoding="utf-8")
    seen = []
    for link in ("direct", "enip"):
        with Cell.build(_FOLDER / "Caller.st", engine="builtin", link=link, robot=robot) as cell:
            cell["Main.CellSafe"] = True
            cell.run("500ms")
            cell["Main.Start"] = True
            cell.run_until(lambda: cell["Main.Count"] == 2, within="4s")
            seen.append(list(changes(cell.trace.lines())))
    assert seen[0] == seen[1]


#: Mistakes in JOBS.PGM: a text, its replacement, the key of _WAYS, and a fault that reveals the
#: mistake.
_SLIPS = {
    "it begins again what it has begun": (
        ("  IF CALLTICKET%=SGI30 THEN", "  IF 1=0 THEN"),
        *("reset", "CellSafe", "Twice"),
    ),
    "it forgets what is complete": (
        ("  IF CALLTICKET%=SGI31 THEN *CALLSHOW", "  'IF"),
        *("go on", "link_down", "nothing has reset the program"),
    ),
    "its outputs stay at the beginning": (
        ("SO(21)=0\nSO(20)=0\n*CALLNEXT", "*CALLNEXT"),
        *("reset", "CellSafe", "does not come back"),
    ),
    "complete comes before the result": (
        ("*CALLSHOW:\n", "*CALLSHOW:\n  SO(21)=1\n"),
        *("slow", "link_down", "Wrong"),
    ),
    "it is complete before it was executed": (
        ("  SELECT CASE CALLJOB%", "  SGI31=CALLTICKET%\n  SELECT CASE CALLJOB%"),
        *("slow", "CellSafe", "Wrong"),
    ),
}


@pytest.mark.exhaustive
@pytest.mark.parametrize("mistake", list(_SLIPS))
def test_a_mistake_in_the_robot_program_is_found(mistake: str) -> None:
    """The sweep reports each mistake that was put into JOBS.PGM, so the sweep can fail."""
    (before, after), way, fault, wrong = _SLIPS[mistake]
    assert _jobs().count(before) == 1
    failures = _failures(Swept(way, jobs=_jobs().replace(before, after)), fault)
    assert any(wrong in failure for failure in failures), failures


@pytest.mark.exhaustive
def test_the_command_sweep_finds_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`rcx sweep` finds no fault after which the program does not recover.

    The conditions are in a file, and every 23rd scan is tested.
    """
    (tmp_path / "JOBS.PGM").write_text(_jobs(), encoding="utf-8")
    robot = tmp_path / "robot.toml"
    robot.write_text('[[programs]]\nfile = "JOBS.PGM"\n', encoding="utf-8")
    options = {
        "robot": robot,
        "properties": _FOLDER / "demands.toml",
        "stimulus": _FOLDER / "stimulus.toml",
        "for": "1800ms",
        "inject": "emergency_stop,link_down,plc_stop,power_cycle,manual_mode,Main.CellSafe=false",
        "every": 23,
        "engine": "builtin",
        "workers": 0,
        "out": tmp_path / "out",
    }
    given = [f"--{name}={value}" for name, value in options.items()]
    assert main(["sweep", str(_FOLDER / "Caller.st"), *given]) == 0
    assert "the cell recovers from all of them" in capsys.readouterr().out
