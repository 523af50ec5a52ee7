"""How fast a cell is simulated, how that grows, and how long the library takes to compile."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from statistics import median

from rcx_harness.cell import Cell
from rcx_harness.cell.build import default_lib, source_files
from rcx_harness.engine.load import build, find_c_compiler, find_matiec
from rcx_harness.robot import RobotConfig, RobotProgram
from rcx_harness.watch.calls_source import steady_instances
from rcx_tools.bench.figure import Figure, Options, at_least, at_most, missing, shown
from rcx_tools.bench.processes import peak_memory

__all__ = ["bend", "compile_library", "demo_cell", "demo_program", "measure"]

_RUNS, _LONG_ROUNDS = 5, 3
_BLOCKS = (1, 10, 50)
_ROBOTS = (1, 2, 4)
_SCAN_US = 10_000
_EXAMPLE, _EXAMPLE_S = Path("plc/examples/01_power_up"), 3
_OUT = Path("out")
_TARGETS = {"matiec": 300, "builtin": 50}
#: A trace that grows in memory would need so much for a minute [KiB]; it must stay well below.
_GROWTH_KIB = 1_000


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
    """Speed on both engines, its growth, memory, compile times."""
    seconds = 2.0 if options.quick else 20.0
    found = _speed(seconds) | _growth(seconds)
    if not options.quick:
        found |= _long_runs()
    return found | compile_library()


def _speed(seconds: float) -> dict[str, Figure]:
    found: dict[str, Figure] = {}
    for engine, least in _TARGETS.items():
        if engine == "matiec" and (find_matiec() is None or find_c_compiler() is None):
            why = "matiec or a C compiler is missing"
            found[f"simulation_{engine}"] = missing("x real time", f">= {least}", why)
            continue
        with _example_cell(engine) as cell:
            factor = _EXAMPLE_S / _example_cost(cell)
        beside = "the run of make demo, CPU time"
        found[f"simulation_{engine}"] = at_least(factor, "x real time", least, beside)
        with demo_cell(engine) as cell:
            factor = seconds / _cost(cell, seconds)
        beside = "one command after the other"
        found[f"simulation_{engine}_busy"] = shown(factor, "x real time", beside)
    return found


def _example_cell(engine: str) -> Cell:
    """The program and the robot of `make demo`."""
    return Cell.build(_EXAMPLE, scan="10ms", engine=engine, robot=_EXAMPLE / "robot.toml")


def _example_cost(cell: Cell) -> float:
    """CPU time of its run, from power-on to its last command; the median of several [s]."""
    start, costs = cell.snapshot(), []
    for _ in range(4 * _RUNS):
        cell.restore(start)
        begun = time.process_time()
        cell.run("500ms")
        cell["Main.Start"] = True
        cell.run(_EXAMPLE_S * 1_000_000 - 500_000)
        costs.append(time.process_time() - begun)
    return median(costs)


def _growth(seconds: float) -> dict[str, Figure]:
    """Cost of a scan with more blocks and more robots: a straight line."""
    found: dict[str, Figure] = {}
    for what, sizes in (("blocks", _BLOCKS), ("robots", _ROBOTS)):
        with ExitStack() as held:
            cells = []
            for size in sizes:
                robots, blocks = (size, 1) if what == "robots" else (1, size)
                cells.append(held.enter_context(demo_cell("builtin", robots=robots, blocks=blocks)))
            rounds = [[_cost(cell, seconds / _RUNS) for cell in cells] for _ in range(_RUNS)]
        # In turns, and the shortest of each: what else the machine does is no growth.
        costs = [min(each) / (seconds / _RUNS) * _SCAN_US for each in zip(*rounds, strict=True)]
        for size, cost in zip(sizes, costs, strict=True):
            found[f"scan_{size}_{what}"] = shown(cost, "us/scan", "built-in engine")
        found[f"growth_{what}"] = at_most(bend(sizes, costs), "off a straight line", 0.1)
    return found


def _long_runs() -> dict[str, Figure]:
    """Cost of a scan and memory in runs of several lengths that write a trace file."""
    found: dict[str, Figure] = {}
    kept_s = 150  # as long as records are still added to those in memory
    lengths = (kept_s, 2 * kept_s, 4 * kept_s)
    rounds = [[_long_run_alone(length) for length in lengths] for _ in range(_LONG_ROUNDS)]
    shortest = [min(each) for each in zip(*rounds, strict=True)]
    results = dict(zip(lengths, shortest, strict=True))
    for length, (cost, _) in results.items():
        found[f"scan_{length}s_trace"] = shown(cost, "us/scan", "trace file written")
    grown = max(0, results[4 * kept_s][1] - results[kept_s][1])
    found["trace_memory_growth"] = at_most(grown, "KiB", _GROWTH_KIB, "600 s beside 150 s")
    off = bend(lengths, [results[length][0] * length for length in lengths])
    found["growth_trace"] = at_most(off, "off a straight line", 0.1)
    return found


def _long_run_alone(seconds: int) -> tuple[float, int]:
    """One run with a trace file in a process of its own: us/scan, and its memory [KiB]."""
    done = subprocess.run(
        [sys.executable, "-m", __name__, str(seconds)], stdout=subprocess.PIPE, check=True
    )
    cost, memory = done.stdout.split()
    return float(cost) / seconds * _SCAN_US, int(memory)


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
        environment = {name: os.environ[name] for name in os.environ if name != "RCX_CACHE"}
        # Nothing of temporary files is kept, and the repository may be among them.
        environment["TMPDIR"] = str(Path(folder) / "tmp")
        Path(environment["TMPDIR"]).mkdir()
        first: list[float] = []
        again: list[float] = []
        for number in range(_RUNS):
            environment["XDG_CACHE_HOME"] = str(Path(folder) / f"cache{number}")
            for times in (first, again):
                done = subprocess.run(
                    [sys.executable, "-m", __name__, "compile", str(program), str(library)],
                    stdout=subprocess.PIPE, check=True, env=environment,
                )  # fmt: skip
                times.append(float(done.stdout))
    beside = f"{len(blocks)} blocks, CPU time, without the start of Python"
    return {
        "compile_library": at_most(median(first), "s", 2, beside),
        "compile_library_again": at_most(median(again), "s", 0.3, beside),
    }


def bend(sizes: Sequence[int], costs: Sequence[float]) -> float:
    """How far the cost of the middle size is off the line of the others, as a part of the last."""
    first, middle, last = sizes
    share = (middle - first) / (last - first)
    expected = costs[0] + (costs[2] - costs[0]) * share
    return abs(costs[1] - expected) / costs[2]


def _cost(cell: Cell, seconds: float) -> float:
    """CPU time of so many seconds of a cell; the median of several runs [s]."""
    costs = []
    for _ in range(_RUNS):
        start = time.process_time()
        cell.run(round(seconds * 1e6))
        costs.append(time.process_time() - start)
    return median(costs)


def _long_run(seconds: int) -> None:
    """One run with a trace file: its CPU time [s] and the memory it took [KiB]."""
    with (
        tempfile.TemporaryDirectory() as folder,
        demo_cell("builtin", trace=Path(folder) / "trace.jsonl") as cell,
    ):
        start = time.process_time()
        cell.run(seconds * 1_000_000)
        print(time.process_time() - start, peak_memory())


def _compile(program: Path, library: Path) -> None:
    """Find the files, compile them, and look which instances are steady: what a cell needs."""
    start = time.process_time()
    files = source_files(program, library)
    build(files.all, "builtin").program.close()
    steady_instances(files.own, files.lib)
    print(time.process_time() - start)


if __name__ == "__main__":
    if sys.argv[1] == "compile":
        _compile(Path(sys.argv[2]), Path(sys.argv[3]))
    else:
        _long_run(int(sys.argv[1]))
