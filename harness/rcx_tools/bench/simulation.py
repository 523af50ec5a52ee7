"""How fast a cell is simulated, and how long the library takes to compile."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from rcx_harness.cell import Cell
from rcx_harness.cell.sources import default_lib, source_files
from rcx_harness.robot import RobotConfig, RobotProgram
from rcx_harness.watch.calls_source import steady_instances
from rcx_tools.bench.figure import (
    OUT_OF_REACH,
    Figure,
    Options,
    at_least,
    at_most,
    missing,
    shown,
)
from rcx_tools.bench.pace import Cost, beside, paced, paced_throughout
from rcx_tools.bench.processes import keeping, on_one_processor
from structured_text.engines.load import build, find_c_compiler, find_matiec

__all__ = ["compile_library", "demo_cell", "demo_program", "measure"]

_RUNS = 5
_EXAMPLE, _EXAMPLE_S = Path("plc/examples/01_power_up"), 3
_OUT = Path("out")
#: How many times real time: what it must be, and what is wanted.
_TARGETS = {"matiec": (300, 1_500), "builtin": (50, 600)}


def demo_program(robots: int = 1, blocks: int = 1) -> str:
    """A program that keeps each robot busy: servo on, then one command after the other.

    Args:
        robots: Robots of one PLC; the others have no network, their blocks wait for the link.
        blocks: Command blocks of each robot, called in every scan; they take turns.
    """
    declared, called = [], []
    for robot in range(1, robots + 1):
        declared += [f"Robot{robot} : RCX_REF;", f"Read{robot} : FB_ReadArea;"]
        declared += [f"Write{robot} : FB_WriteArea;", f"Servo{robot} : FB_ServoOn;"]
        area = "InputArea" if robot == 1 else f"In{robot}"
        out = "OutputArea" if robot == 1 else f"Out{robot}"
        if robot > 1:
            declared.append(f"{area}, {out} : RCX_IMAGE;")
        link = "Connected" if robot == 1 else "FALSE"
        ref = f"Robot := Robot{robot}"
        called.append(f"Read{robot}({ref}, Image := {area}, Connected := {link});")
        called.append(f"Servo{robot}({ref}, Execute := Go);")
        for block in range(1, blocks + 1):
            name = f"Position{robot}x{block}"
            declared.append(f"{name} : FB_ReadPositionPulses;")
            ready = f"Servo{robot}.Done AND NOT {name}.Done AND NOT {name}.Error"
            called.append(f"{name}({ref}, Execute := {ready});")
        called.append(
            f"Write{robot}({ref}, Image := {out}, Margin := T#20ms, EmergencyStopOk := TRUE,"
            " StopOk := TRUE);"
        )
    return (
        "PROGRAM Demo\n  VAR\n    InputArea, OutputArea : RCX_IMAGE;\n"
        "    Connected, Go : BOOL;\n    " + "\n    ".join(declared) + "\n  END_VAR\n  "
        "Go := Connected;\n  " + "\n  ".join(called) + "\nEND_PROGRAM\n"
    )


def demo_cell(
    engine: str, *, link: str = "direct", robots: int = 1, blocks: int = 1,
    trace: Path | None = None,
) -> Cell:  # fmt: skip
    """A cell with `demo_program`, 10 ms scan, its servo on and commands under way."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "Demo.st"
        file.write_text(demo_program(robots, blocks), encoding="utf-8")
        robot = RobotConfig(programs=(RobotProgram(),))
        cell = Cell.build(file, scan="10ms", engine=engine, link=link, robot=robot, trace=trace)
    cell.run_until(lambda: cell.commands > 0, within="5s")
    return cell


def measure(options: Options) -> dict[str, Figure]:
    """Speed on both engines, compile times."""
    with on_one_processor():
        return _speed(2.0 if options.quick else 20.0) | compile_library()


def _speed(seconds: float) -> dict[str, Figure]:
    found: dict[str, Figure] = {}
    for engine, (least, wanted) in _TARGETS.items():
        if engine == "matiec" and (find_matiec() is None or find_c_compiler() is None):
            why = "matiec or a C compiler is missing"
            found[f"simulation_{engine}"] = missing("x real time", f">= {least}", why)
            continue
        with _example_cell(engine) as cell:
            costs = _example_costs(cell)
        peer = f"the run of make demo, {_EXAMPLE_S} s; {beside(costs)}"
        factor = _EXAMPLE_S / _median(costs)
        found[f"simulation_{engine}"] = at_least(factor, "x real time", least, peer)
        peer = "what is wanted" + OUT_OF_REACH
        found[f"simulation_{engine}_wanted"] = at_least(factor, "x real time", wanted, peer)
        with demo_cell(engine) as cell:
            factor = seconds / _median(_costs(cell, seconds))
        peer = "one command after the other"
        found[f"simulation_{engine}_busy"] = shown(factor, "x real time", peer)
    return found


def _example_cell(engine: str) -> Cell:
    """The program and the robot of `make demo`."""
    return Cell.build(_EXAMPLE, scan="10ms", engine=engine, robot=_EXAMPLE / "robot.toml")


def _example_costs(cell: Cell) -> list[Cost]:
    """Several runs of it, from power-on to its last command."""
    start = cell.snapshot()

    def whole() -> float:
        cell.restore(start)
        begun = time.process_time()
        cell["Main.CellSafe"] = True
        cell.run("500ms")
        cell["Main.Start"] = True
        cell.run(_EXAMPLE_S * 1_000_000 - 500_000)
        return time.process_time() - begun

    return [paced(whole) for _ in range(4 * _RUNS)]


def compile_library() -> dict[str, Figure]:
    """Every block of the library in one program, without the cache and from it."""
    with tempfile.TemporaryDirectory(dir=_OUT) as folder:
        library = Path(folder) / "lib"
        shutil.copytree(default_lib(), library)
        blocks = sorted(file.stem for file in library.rglob("FB_*.st"))
        declared = "".join(f"    X{k} : {name};\n" for k, name in enumerate(blocks))
        program = Path(folder) / "All.st"
        program.write_text(
            f"PROGRAM All\n  VAR\n    InputArea, OutputArea : RCX_IMAGE;\n{declared}  END_VAR\n"
            "  OutputArea[0] := InputArea[0];\nEND_PROGRAM\n",
            encoding="utf-8",
        )
        first: list[Cost] = []
        again: list[Cost] = []
        for number in range(_RUNS):
            words = [sys.executable, "-m", __name__, str(program), str(library)]
            environment = keeping(Path(folder) / f"cache{number}")
            for costs in (first, again):
                costs.append(_said(words, environment))
    peer = f"{len(blocks)} blocks, without the start of Python; "
    return {
        "compile_library": at_most(_median(first), "s", 2, peer + beside(first)),
        "compile_library_again": at_most(_median(again), "s", 0.3, peer + beside(again)),
    }


def _said(words: list[str], environment: dict[str, str]) -> Cost:
    """The CPU time that a process tells of itself."""
    done = subprocess.run(words, stdout=subprocess.PIPE, check=True, env=environment)
    return Cost(*map(float, done.stdout.split()))


def _costs(cell: Cell, seconds: float) -> list[Cost]:
    """Several times so many seconds of a cell."""

    def run() -> float:
        start = time.process_time()
        cell.run(round(seconds * 1e6))
        return time.process_time() - start

    return [paced(run) for _ in range(_RUNS)]


def _median(costs: list[Cost]) -> float:
    """Of a quiet processor [s]."""
    return median(cost.quiet for cost in costs)


def _compile(program: Path, library: Path) -> None:
    """Find the files, compile them, and look which instances are steady: what a cell needs."""

    def work() -> None:
        files = source_files(program, library)
        build(files.all, "builtin").program.close()
        steady_instances(files.own, files.lib)

    print(*paced_throughout(work))


if __name__ == "__main__":
    _compile(Path(sys.argv[1]), Path(sys.argv[2]))
