"""matiec's own charts and our translation agree in each scan, with random inputs.

The charts avoid the known differences (docs/reference/language.md, Sequential Function Chart).
"""

from __future__ import annotations

import random
import re
import subprocess
from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.matiec.build import Matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.language.load import load
from structured_text.projects.diagrams.sfc.text import with_charts

pytestmark = pytest.mark.exhaustive

_CONFIGURATION = """
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T1(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM I WITH T1 : Main;
  END_RESOURCE
END_CONFIGURATION
"""
_INPUTS = "ABC"

_ALL = """
  VAR_OUTPUT
    n1, s1, p1, p0, p, l, d : INT; vn, vl, vd, x2, x3, late : BOOL;
  END_VAR
  INITIAL_STEP I: vn (N); AS1 (R); END_STEP
  TRANSITION FROM I TO Two := A; END_TRANSITION
  STEP Two: AN (N); AS1 (S); AP1 (P1); AP0 (P0); AP (P); AL (L, T#50ms); AD (D, T#40ms);
    vl (L, T#30ms); vd (D, T#30ms); END_STEP
  TRANSITION (PRIORITY := 2) FROM Two TO I := C; END_TRANSITION
  TRANSITION (PRIORITY := 1) FROM Two TO (Three, Four) := B; END_TRANSITION
  STEP Three: END_STEP
  STEP Four: AN4 (N); END_STEP
  TRANSITION FROM (Three, Four) TO I := A AND Three.T >= T#30ms; END_TRANSITION
  ACTION AN: n1 := n1 + 1; x2 := Two.X; END_ACTION
  ACTION AN4: x3 := Three.X; END_ACTION
  ACTION AS1: s1 := s1 + 1; END_ACTION
  ACTION AP1: p1 := p1 + 1; END_ACTION
  ACTION AP0: p0 := p0 + 1; END_ACTION
  ACTION AP: p := p + 1; END_ACTION
  ACTION AL: l := l + 1; late := Two.T > T#20ms; END_ACTION
  ACTION AD: d := d + 1; END_ACTION
"""
_STORED = """
  VAR_OUTPUT n : INT; v : BOOL; END_VAR
  INITIAL_STEP I: END_STEP
  TRANSITION FROM I TO J := A; END_TRANSITION
  STEP J: Work ({qualifier}, T#60ms); v (S); END_STEP
  TRANSITION FROM J TO K := B; END_TRANSITION
  STEP K: END_STEP
  TRANSITION FROM K TO L := K.T > T#150ms; END_TRANSITION
  STEP L: Work (R); v (R); END_STEP
  TRANSITION FROM L TO I := NOT A; END_TRANSITION
  ACTION Work: n := n + 1; END_ACTION
"""
_DELAYED = """
  VAR_OUTPUT n : INT; END_VAR
  INITIAL_STEP I: Work (R); END_STEP
  TRANSITION FROM I TO J := A; END_TRANSITION
  STEP J: Work (DS, T#45ms); END_STEP
  TRANSITION FROM J TO K := B AND (J.T < T#20ms OR J.T > T#80ms); END_TRANSITION
  STEP K: END_STEP
  TRANSITION FROM K TO I := NOT A; END_TRANSITION
  ACTION Work: n := n + 1; END_ACTION
"""


@pytest.mark.parametrize(
    "chart",
    [_ALL, _STORED.format(qualifier="SD"), _STORED.format(qualifier="SL"), _DELAYED],
    ids=["all", "SD", "SL", "DS"],
)
def test_a_chart_agrees_with_matiec_in_10000_random_scans(
    chart: str, tmp_path: Path, matiec: Matiec
) -> None:
    """Source: docs/reference/language.md, Sequential Function Chart."""
    draw = random.Random(44)
    text = f"PROGRAM Main\n  VAR_INPUT A, B, C : BOOL; END_VAR\n{chart}END_PROGRAM\n"
    section = "".join(re.findall(r"VAR_OUTPUT(.*?)END_VAR", chart, re.DOTALL))
    shown = re.findall(r"\w+(?=\s*[,:])", section)
    rows, given = [], [0, 0, 0]
    for scan in range(10_000):
        given = [1 - value if draw.random() < 0.2 else value for value in given]
        rows.append([*given, draw.choice([10_000, 20_000, 7_000]) if scan else 0])
    theirs = _theirs(text, shown, rows, tmp_path, matiec)

    file = tmp_path / "chart.st"
    file.write_text(text)
    program = BuiltinProgram.build(load([with_charts(file, final_scan=False)]))
    now_us = 0
    for scan, (*values, pause) in enumerate(rows):
        for name, value in zip(_INPUTS, values, strict=True):
            program.write(f"Main.{name}", bool(value))
        now_us += pause
        program.scan(now_us)
        ours = [int(program.read(f"Main.{name}")) for name in shown]
        assert dict(zip(shown, ours, strict=True)) == dict(zip(shown, theirs[scan], strict=True)), (
            scan
        )


def _theirs(
    text: str, shown: list[str], rows: list[list[int]], folder: Path, matiec: Matiec
) -> list[list[int]]:
    """Return the variables behind each scan of a program that matiec compiles with its chart."""
    source = folder / "matiec.st"
    source.write_text(text + _CONFIGURATION)
    call: list[str | Path] = [matiec.iec2c, "-I", matiec.library, "-T", folder, source]
    subprocess.run(call, check=True, capture_output=True)
    reads = "".join(
        f'if (scanf("%d", &v) != 1) return 0; m.{name}.value = v;\n' for name in _INPUTS
    )
    prints = "".join(f'printf("%d ", (int)m.{name.upper()}.value);\n' for name in shown)
    (folder / "main.c").write_text(
        '#include <stdio.h>\n#include "iec_std_lib.h"\nTIME __CURRENT_TIME; BOOL __DEBUG = 0;\n'
        '#include "POUS.h"\n#include "POUS.c"\n'
        "int main(void) { static MAIN m; int v; long t = 0; MAIN_init__(&m, 0);\n"
        f'for (;;) {{ {reads} if (scanf("%d", &v) != 1) return 0; t += v;\n'
        "__CURRENT_TIME.tv_sec = t / 1000000; __CURRENT_TIME.tv_nsec = t % 1000000 * 1000;\n"
        f'MAIN_body__(&m);\n{prints} printf("\\n"); }} }}\n'
    )
    compiler = find_c_compiler()
    assert compiler is not None
    headers = matiec.headers
    built: list[str | Path] = [
        compiler,
        "-w",
        "-I",
        headers,
        "-I",
        folder,
        "-o",
        folder / "run",
        folder / "main.c",
    ]
    subprocess.run(built, check=True, capture_output=True)
    given = "\n".join(" ".join(map(str, row)) for row in rows)
    run = subprocess.run([folder / "run"], input=given, capture_output=True, text=True, check=True)
    return [[int(word) for word in line.split()] for line in run.stdout.splitlines()]
