"""What a scan costs on a PLC: matiec's C beside a C program written by hand (peer.c).

Both are compiled with the same options, replay the same recorded inputs and must write the same
outputs in every scan; then they take turns, and the medians are compared. Two programs: example 01
from power on to its end, and 50 command blocks that wait for their Execute.
"""

from __future__ import annotations

import struct
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from rcx_harness import Cell
from rcx_harness.cell.sources import default_lib
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.trace import Record, Scan
from rcx_tools.bench.figure import OUT_OF_REACH, Figure, Options, at_most, missing, shown
from structured_text.engines.load import MISSING, Matiec, find_c_compiler, find_matiec
from structured_text.engines.matiec.source import join_sources
from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.projects.needed import needed

__all__ = ["HIGHEST_RATIO", "PROGRAMS", "Cost", "costs", "measure"]

#: Target of the first program: scan time over that of the peer. The other is only shown.
HIGHEST_RATIO = 3.5
PROGRAMS = ("demo", "50 idle commands")

_HERE = Path(__file__).parent
_EXAMPLE = default_lib().parent / "examples/01_power_up"
_SCANS, _REPETITIONS, _ROUNDS = 300, 100, 7
_FLAGS = ("-std=gnu11", "-O2", "-w", "-fwrapv", "-fno-strict-aliasing", "-ffp-contract=off")

_OURS = """
#include <string.h>
#include "iec_std_lib.h"
#include "accessor.h"
#include "POUS.h"
void config_init__(void);
void config_run__(unsigned long tick);
TIME __CURRENT_TIME;
BOOL __DEBUG;
extern %s RES0__MAIN;
static unsigned long rcx_tick;
static void side_begin(long long now) { rcx_tick = 0; config_init__(); }
static void side_scan(unsigned char connected, unsigned char start, const unsigned char *in,
                      unsigned char *out, long long now) {
  __CURRENT_TIME.tv_sec = (long)(now / 1000000);
  __CURRENT_TIME.tv_nsec = (long)(now %% 1000000) * 1000;
  RES0__MAIN.CONNECTED.value = connected;
  RES0__MAIN.START.value = start;
  RES0__MAIN.CELLSAFE.value = 1;
  memcpy(RES0__MAIN.INPUTAREA.value.table, in, 48);
  config_run__(rcx_tick++);
  memcpy(out, RES0__MAIN.OUTPUTAREA.value.table, 48);
}
"""
_PEER = """
#define side_begin begin
#define side_scan %s
"""


@dataclass(frozen=True)
class Cost:
    """One program: nanoseconds per scan of the library and of the peer, as medians."""

    program: str
    library_ns: float
    peer_ns: float

    @property
    def ratio(self) -> float:
        """How many times as long as the peer's."""
        return self.library_ns / self.peer_ns


def costs(matiec: Matiec, compiler: str) -> list[Cost]:
    """Measure both programs.

    Raises:
        InputError: a C compiler that fails, or outputs that are not those recorded.
        TranslationError: iec2c refuses the program.
    """
    with tempfile.TemporaryDirectory(prefix="rcx-") as name:
        folder = Path(name)
        idle = folder / "Idle.st"
        idle.write_text(_idle(), encoding="utf-8")
        config = _EXAMPLE / "Config.st"
        demo = sorted(_EXAMPLE.glob("*.st"))
        idle_config = folder / "Config.st"
        idle_config.write_text(config.read_text().replace("PowerUp", "Idle"), encoding="utf-8")
        return [
            _cost(folder / "demo", demo, "POWERUP", "demo_scan", "demo", matiec, compiler),
            _cost(
                folder / "idle", [idle, idle_config], "IDLE", "idle_scan", PROGRAMS[1], matiec,
                compiler,
            ),
        ]  # fmt: skip


def _cost(
    folder: Path,
    program: list[Path],
    kind: str,
    peer_scan: str,
    name: str,
    matiec: Matiec,
    compiler: str,
) -> Cost:
    recorded = _recorded(program, with_stimulus=name == "demo")
    target = folder / "c"
    target.mkdir(parents=True)
    library = sorted(default_lib().rglob("*.st"))
    source = folder / "program.st"
    joined = join_sources(load([*program, *needed(program, library)])).text
    source.write_text(joined, encoding="utf-8")
    matiec.translate(source, target)
    drive = (_HERE / "drive.c").read_text(encoding="utf-8")
    parts = sorted(path.name for path in target.glob("*.c") if path.name != "POUS.c")
    ours = [_OURS % kind, *(f'#include "{part}"' for part in parts), drive]
    peer = [(_HERE / "peer.c").read_text(encoding="utf-8"), _PEER % peer_scan, drive]
    sides = []
    for side, lines in (("ours", ours), ("peer", peer)):
        unit, binary = target / f"rcx_{side}.c", folder / side
        unit.write_text("\n".join(lines) + "\n", encoding="utf-8")
        command = [compiler, *_FLAGS, "-I", str(matiec.headers), str(unit), "-o", str(binary)]
        done = subprocess.run([*command, "-lm"], capture_output=True, text=True, check=False)
        if done.returncode:
            raise InputError(f"{compiler} refuses {unit.name}: {done.stderr.strip()[:200]}")
        sides.append((binary, list[float]()))
    for _ in range(_ROUNDS):
        for binary, times in sides:
            times += _replayed(binary, recorded)
    return Cost(name, *(median(times) for _, times in sides))


def _replayed(binary: Path, recorded: bytes) -> list[float]:
    command = [str(binary), str(_REPETITIONS)]
    done = subprocess.run(command, input=recorded, capture_output=True, check=False)
    if done.returncode:
        raise InputError(f"{binary.name}: {done.stderr.decode().strip() or 'it failed'}")
    return [float(line) for line in done.stdout.split()]


def _recorded(program: list[Path], *, with_stimulus: bool) -> bytes:
    """What drive.c reads: inputs and outputs of each scan, from a run in a virtual cell."""
    rows: list[bytes] = []
    robot = _EXAMPLE / "robot.toml"
    with Cell.build(program, scan="10ms", engine="builtin", robot=robot) as cell:

        def keep(record: Record) -> None:
            if isinstance(record, Scan):
                pins = bytes([cell["Main.Connected"], cell["Main.Start"]])
                rows.append(pins + record.so + record.si)

        cell.trace.listen(keep)
        cell["Main.CellSafe"] = True  # from the first scan on, as drive.c and the peer have it
        if with_stimulus:
            Stimulus.load(_EXAMPLE / "stimulus.toml").schedule(cell)
        cell.run(_SCANS * 10_000)
    return struct.pack("i", len(rows)) + b"".join(rows)


def _idle() -> str:
    """A program with 50 command blocks that are called and have nothing to do."""
    names = [f"Move{number:02d}" for number in range(1, 51)]
    declared = "".join(f"    {name} : FB_MovePtp;\n" for name in names)
    pins = "Robot := Robot, Execute := Start, Point := 19"
    called = "".join(f"  {name}({pins});\n" for name in names)
    return (
        "PROGRAM Idle\n  VAR\n    InputArea, OutputArea : RCX_IMAGE;\n"
        "    Connected, CellSafe, Start : BOOL;\n    Robot : RCX_REF;\n"
        f"    ReadArea : FB_ReadArea;\n    WriteArea : FB_WriteArea;\n{declared}  END_VAR\n"
        "  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);\n"
        f"{called}"
        "  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := CellSafe,\n"
        "            StopOk := CellSafe);\nEND_PROGRAM\n"
    )


def measure(options: Options) -> dict[str, Figure]:
    """The ratio of each program.

    Args:
        options: Nothing of it matters here.
    """
    del options
    matiec, compiler = find_matiec(), find_c_compiler()
    unit = "times the peer"
    if matiec is None or compiler is None:
        why = MISSING if matiec is None else "no C compiler found"
        return {f"scan cost, {name}": missing(unit, "beside C", why) for name in PROGRAMS}
    found = {}
    for cost in costs(matiec, compiler):
        name = f"scan cost, {cost.program}"
        beside = f"C by hand: {cost.peer_ns:.0f} ns per scan, the library {cost.library_ns:.0f} ns"
        found[name] = shown(cost.ratio, unit, beside)
        if cost.program == PROGRAMS[0]:
            found[name] = at_most(cost.ratio, unit, HIGHEST_RATIO, beside + OUT_OF_REACH)
    return found
