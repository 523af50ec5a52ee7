"""Random calls of standard functions give the same results on the built-in engine and matiec.

The test leaves out known differences (docs/reference/language.md): FIND of more than one character
and REPLACE (errors of matiec), shifts by the width and more, reals that do not fit an integer,
divisions by 0, invalid BCD digits, and texts converted to dates.
"""

from __future__ import annotations

import random
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.language.load import load

_WIDTHS = {"SINT": 8, "INT": 16, "DINT": 32, "LINT": 64}
_UNSIGNED = {"USINT": 8, "UINT": 16, "UDINT": 32, "ULINT": 64}
_BITS = {"BYTE": 8, "WORD": 16, "DWORD": 32, "LWORD": 64}
_TIMES = (("TIME", "T1 + T2"), ("TIME", "T1 - T2"), ("TIME", "ADD_TIME(T1, T2)"),
          ("TOD", "ADD_TOD_TIME(C1, T0)"), ("DT", "ADD_DT_TIME(M1, T1)"),
          ("TIME", "SUB_DATE_DATE(D1, D2)"), ("TIME", "SUB_TOD_TOD(C1, C2)"),
          ("DT", "SUB_DT_TIME(M1, T1)"), ("TIME", "SUB_DT_DT(M1, M2)"),
          ("DT", "CONCAT_DATE_TOD(D1, C1)"), ("DATE", "DT_TO_DATE(M1)"), ("TOD", "DT_TO_TOD(M1)"),
          ("BOOL", "M1 > M2"), ("BOOL", "LE(D1, D2)"), ("DINT", "DT_TO_DINT(M1)"),
          ("UDINT", "DATE_TO_UDINT(D1)"), ("DINT", "TIME_TO_DINT(T0)"), ("DT", "MAX(M1, M2)"),
          ("TIME", "MULTIME(T0, N)"))  # fmt: skip
_TEXTS = (("STRING", "CONCAT(S1, S2)"), ("STRING", "LEFT(S1, N)"), ("STRING", "RIGHT(S1, N)"),
          ("STRING", "DELETE(S1, N, 1)"), ("STRING", "INSERT(S1, S2, 1)"), ("INT", "FIND(S1, S3)"),
          ("INT", "LEN(S2)"), ("BOOL", "S1 > S2"), ("BOOL", "S1 = S2"))  # fmt: skip


def _rows() -> list[tuple[str, str]]:
    found = [*_TIMES, *_TEXTS]
    for kind in (*_WIDTHS, *_UNSIGNED):
        a, b = f"A{kind}", f"B{kind}"
        found += [
            (kind, code.format(a=a, b=b))
            for code in ("{a} + {b}", "{a} - {b}", "{a} * {b}", "MAX({a}, {b})", "MIN({a}, {b})")
        ]
        found += [("BOOL", f"{a} < {b}"), (kind, f"SEL(X, {a}, {b})"), (kind, f"{a} / 7")]
        found += [
            (kind, f"{a} MOD 7"),
            (kind, f"LIMIT({b}, {a}, {b})"),
            ("REAL", f"{kind}_TO_REAL({a})"),
        ]
        found += [
            (other, f"{kind}_TO_{other}({a})") for other in (*_WIDTHS, *_UNSIGNED) if other != kind
        ]
        found += [(bits, f"{kind}_TO_{bits}({a})") for bits in _BITS]
    for kind, digits in (("BYTE", "USINT"), ("WORD", "UINT"), ("DWORD", "UDINT")):
        a = f"A{kind}"
        found += [(kind, f"{op}({a}, N)") for op in ("SHL", "SHR", "ROL", "ROR")]
        found += [(kind, f"{a} {op} B{kind}") for op in ("AND", "OR", "XOR")]
        found += [(kind, f"NOT {a}"), (digits, f"{kind}_BCD_TO_{digits}(K{kind})")]
        found += [
            (kind, f"{digits}_TO_BCD_{kind}(K{digits})"),
            (digits, f"BCD_TO_{digits}(K{kind})"),
        ]
    for kind in ("REAL", "LREAL"):
        a, b = f"A{kind}", f"B{kind}"
        found += [(kind, f"{a} {op} {b}") for op in ("+", "-", "*")]
        found += [(kind, f"{name}({a})") for name in ("SIN", "COS", "ATAN", "ABS")]
        found += [
            ("DINT", f"{kind}_TO_DINT({a})"),
            ("DINT", f"TRUNC({a})"),
            (kind, f"SQRT(ABS({a}))"),
        ]
        found += [("BOOL", f"{a} > {b}"), (kind, f"EXPT(ABS({a}), 2)")]
    return found


def _inputs(draw: random.Random) -> dict[str, tuple[str, Any]]:
    """Return type and value of each variable by its name."""
    values: dict[str, tuple[str, Any]] = {"X": ("BOOL", draw.random() < 0.5)}
    for letter in "AB":
        for kind, width in _WIDTHS.items():
            edge = draw.choice([-(1 << width - 1), -1, 0, 1, (1 << width - 1) - 1])
            some = draw.randrange(-(1 << width - 1), 1 << width - 1)
            values[letter + kind] = (kind, draw.choice([edge, some, draw.randint(-99, 99)]))
        for kind, width in (_UNSIGNED | _BITS).items():
            edge = draw.choice([0, 1, (1 << width) - 1, 1 << width - 1])
            values[letter + kind] = (kind, draw.choice([edge, draw.randrange(1 << width)]))
        for kind in ("REAL", "LREAL"):
            values[letter + kind] = (kind, draw.choice([0.0, draw.uniform(-1e4, 1e4) // 0.125 / 8]))
    for kind, width in (("BYTE", 8), ("WORD", 16), ("DWORD", 32)):
        number = draw.randrange(10 ** (width // 4))
        values[f"K{kind}"] = (kind, int(str(number), 16))
        values[{8: "KUSINT", 16: "KUINT", 32: "KUDINT"}[width]] = (
            {8: "USINT", 16: "UINT", 32: "UDINT"}[width],
            number,
        )
    values["N"] = ("INT", draw.randrange(8))
    for name in ("T1", "T2"):
        values[name] = ("TIME", timedelta(seconds=draw.randrange(-(10**5), 10**5)))
    values["T0"] = ("TIME", timedelta(seconds=draw.randrange(3600)))
    for name in ("C1", "C2"):
        values[name] = ("TOD", time(draw.randrange(22), draw.randrange(60), draw.randrange(60)))
    for name in ("D1", "D2"):
        values[name] = ("DATE", date(1970, 1, 1) + timedelta(days=draw.randrange(20_000)))
    for name in ("M1", "M2"):
        moment = datetime(1980, 1, 1) + timedelta(seconds=draw.randrange(10**9))
        values[name] = ("DT", moment)
    for name, most in (("S1", 20), ("S2", 20), ("S3", 1)):
        count = draw.randint(1, most)
        values[name] = ("STRING", "".join(draw.choice("ab0 ~") for _ in range(count)))
    return values


@pytest.mark.parametrize("seed", range(4))
def test_random_calls_agree_on_both_engines(seed: int, tmp_path: Path, matiec: Matiec) -> None:
    draw = random.Random(seed)
    rows, scans = _rows(), 100
    declared = "".join(f"  {name} : {kind};\n" for name, (kind, _) in _inputs(draw).items())
    declared += "".join(f"  R{k} : {kind};\n" for k, (kind, _) in enumerate(rows))
    body = "".join(f"R{k} := {code};\n" for k, (_, code) in enumerate(rows))
    file = tmp_path / "random.st"
    file.write_text(f"PROGRAM P1\nVAR\n{declared}END_VAR\n{body}END_PROGRAM\n")
    compiler = find_c_compiler()
    assert compiler is not None
    project = load([file])
    engines = (BuiltinProgram.build(project), MatiecProgram.build(project, matiec, compiler))
    wrong: dict[str, str] = {}
    for scan in range(scans):
        given = _inputs(draw)
        results = []
        for engine in engines:
            for name, (_, value) in given.items():
                engine.write(f"Main.{name}", value)
            engine.scan(scan * 10_000)
            results.append([engine.read(f"Main.R{k}") for k in range(len(rows))])
        for (_, code), ours, theirs in zip(rows, *results, strict=True):
            if repr(ours) != repr(theirs):
                wrong[code] = f"{ours!r} here, {theirs!r} on matiec, for {given}"
    assert not wrong, "\n".join(f"{code}: {text}"[:900] for code, text in wrong.items())
