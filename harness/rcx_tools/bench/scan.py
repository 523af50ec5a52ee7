"""CPU time per scan on a PLC, with each available compiler.

One program contains ten robots. The program itself simulates their controllers (it answers a
command in the next scan), so the harness is not measured. Each figure is the difference in CPU time
between two programs, per robot or block: with and without areas, with and without idle blocks, with
and without running handshakes, and with areas of 512 and of 48 bytes. The programs run alternately,
and the figures are medians.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from rcx_harness.cell.sources import default_lib
from rcx_tools.bench.figure import Figure, Options, missing, shown
from structured_text.engines.base import Program
from structured_text.engines.load import build, why_not
from structured_text.errors import InputError
from structured_text.projects.needed import needed

__all__ = ["ENGINES", "ROWS", "RUNNING", "Paid", "measure", "paid"]

ENGINES = ("matiec", "strucpp")
#: The names of the measured figures.
ROWS = (
    "an area read and written",
    "of this, the cost of 464 more bytes in RCX_IMAGE",
    "an idle command block",
    "a running handshake",
)

_ROBOTS, _IDLE = 10, 10
_SCAN_US = 10_000
_IMAGE, _SMALL = "[0..511]", "[0..47]"
#: SO(01) CPU OK, SO(02) SERVO, SO(04) MP RDY and SO(08) AUTO of a controller that is ready.
_READY = "InputArea{k}[32] := BYTE#16#16;\n  InputArea{k}[33] := BYTE#16#01;"
_AREA = """  ReadArea{k}(Robot := Robot{k}, Image := InputArea{k}, ImageSize := {size},
            Connected := TRUE);
{blocks}  WriteArea{k}(Robot := Robot{k}, Image := OutputArea{k}, ImageSize := {size},
             EmergencyStopOk := TRUE, StopOk := TRUE);
  {ready}
  IF OutputArea{k}[0] <> BYTE#16#00 OR OutputArea{k}[1] <> BYTE#16#00 THEN
    InputArea{k}[1] := BYTE#16#02;
  ELSE
    InputArea{k}[1] := BYTE#16#00;
  END_IF;
"""
#: Calls between FB_ReadArea and FB_WriteArea of a robot, in the program with handshakes.
RUNNING = """  Move{k}(Robot := Robot{k}, Execute := NOT Move{k}.Done, Point := 19);
  IF Move{k}.Done THEN
    Count := Count + 1;
  END_IF;
"""


@dataclass(frozen=True)
class Paid:
    """The measured figures of one engine, in nanoseconds per scan, in the order of ROWS."""

    area: float
    copies: float
    idle: float
    handshake: float


def paid(engine: str, rounds: int, scans: int) -> Paid:
    """Measure the CPU time per scan on one engine.

    Args:
        engine: `matiec` or `strucpp`.
        rounds: Number of rounds. Each program runs once in a round.
        scans: Scans of each program in a round.

    Raises:
        InputError: the engine is missing or refuses a program, or a handshake does not run.
    """
    every = ("empty", "area", "small", "idle", "running")
    times: dict[str, list[float]] = {name: [] for name in every}
    with tempfile.TemporaryDirectory(prefix="rcx-") as name:
        programs = {one: _built(one, Path(name), engine) for one in every}
        for _ in range(rounds):
            for one, program in programs.items():
                times[one].append(_timed(program, scans))
        count = programs["running"].read("Main.Count")
        for program in programs.values():
            program.close()
    # A command takes at most eight scans: data, code, answer, 0x0000 and the answer to 0x0000.
    if not isinstance(count, int) or count < _ROBOTS * rounds * scans // 8:
        raise InputError(f"{engine}: {count} commands in {rounds * scans} scans are too few")
    ns = {one: median(found) for one, found in times.items()}
    return Paid(
        area=(ns["area"] - ns["empty"]) / _ROBOTS,
        copies=(ns["area"] - ns["small"]) / _ROBOTS,
        idle=(ns["idle"] - ns["area"]) / _ROBOTS / _IDLE,
        handshake=(ns["running"] - ns["area"]) / _ROBOTS,
    )


def _timed(program: Program, scans: int) -> float:
    """Return the CPU time of one scan of a program [ns]."""
    scan = program.scan
    started = time.process_time_ns()
    for now_us in range(0, scans * _SCAN_US, _SCAN_US):
        scan(now_us)
    return (time.process_time_ns() - started) / scans


def _built(name: str, folder: Path, engine: str) -> Program:
    own = folder / name
    own.mkdir()
    main = own / "Main.st"
    main.write_text(_text(name), encoding="utf-8")
    library = sorted(default_lib().rglob("*.st"))
    files = [main, *needed([main], library)]
    if name == "small":
        image = next(path for path in files if path.name == "RCX_IMAGE.st")
        small = own / image.name
        small.write_text(image.read_text(encoding="utf-8").replace(_IMAGE, _SMALL), "utf-8")
        files[files.index(image)] = small
    return build(files, engine).program


def _text(name: str) -> str:
    """Return the Structured Text of one of the measured programs."""
    declared, called = ["    Count : DINT;"], ["  Count := Count;\n"]
    for k in range(0 if name == "empty" else _ROBOTS):
        declared += [
            f"    Robot{k} : RCX_REF;",
            f"    InputArea{k} : RCX_IMAGE;",
            f"    OutputArea{k} : RCX_IMAGE;",
            f"    ReadArea{k} : FB_ReadArea;",
            f"    WriteArea{k} : FB_WriteArea;",
        ]
        blocks = ""
        if name == "idle":
            idle = [f"Idle{k}N{number}" for number in range(_IDLE)]
            declared += [f"    {one} : FB_MovePtp;" for one in idle]
            blocks = "".join(
                f"  {one}(Robot := Robot{k}, Execute := FALSE, Point := 19);\n" for one in idle
            )
        elif name == "running":
            declared.append(f"    Move{k} : FB_MovePtp;")
            blocks = RUNNING.format(k=k)
        size = 48 if name == "small" else 512
        ready = _READY.format(k=k)
        called.append(_AREA.format(k=k, size=size, blocks=blocks, ready=ready))
    text = "\n".join(declared)
    return (
        f"PROGRAM Scanned\n  VAR\n{text}\n  END_VAR\n{''.join(called)}END_PROGRAM\n"
        "CONFIGURATION Config0\n  RESOURCE Res0 ON PLC\n"
        "    TASK Cyclic(INTERVAL := T#10ms, PRIORITY := 0);\n"
        "    PROGRAM Main WITH Cyclic : Scanned;\n  END_RESOURCE\nEND_CONFIGURATION\n"
    )


def measure(options: Options) -> dict[str, Figure]:
    """Measure every figure with every available compiler."""
    rounds, scans = (3, 200) if options.quick else (15, 20_000)
    found: dict[str, Figure] = {}
    for engine in ENGINES:
        if why := why_not(engine):
            found |= {f"{row}, {engine}": missing("ns", "none", why) for row in ROWS}
            continue
        one = paid(engine, rounds, scans)
        values = (one.area, one.copies, one.idle, one.handshake)
        found |= {
            f"{row}, {engine}": shown(value, "ns per scan")
            for row, value in zip(ROWS, values, strict=True)
        }
    return found
