"""Comparison of the built-in engine with matiec for each row of the table of dialects.

A row can be compared if matiec has the same behaviour, and if a program shows the behaviour without
a known fault of matiec. The calls are distributed over the tools of the row. All other rows can run
only on the built-in engine.
"""

from __future__ import annotations

import random
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.language.dialects import Row, rows
from structured_text.language.load import load
from structured_text.language.source import in_dialect

__all__ = ["PROBES", "Probe", "RowCalls", "compared_rows", "probe_of", "program_text"]

#: Limits and other special values of an INT, for comparisons with counters.
_INT_EDGES = (-32768, -1, 0, 1, 2, 3, 32767)


@dataclass(frozen=True)
class Probe:
    """A program that shows a rule of a dialect.

    Attributes:
        rule: Name of the rule.
        values: Values of the rule for which matiec computes the same result.
        inputs: Names of the program's inputs. `_drawn` has a range of values for each.
        variables: Declarations of the program's other variables.
        body: Statements of the program.
        shown: The variables that are compared.
        without: Description of the cases that the program omits, because matiec gives another
            result.
    """

    rule: str
    values: tuple[str | int, ...]
    inputs: tuple[str, ...]
    variables: str
    body: str
    shown: tuple[str, ...]
    without: str = ""


@dataclass(frozen=True)
class RowCalls:
    """The result of the comparison for one row.

    Attributes:
        row: The row.
        calls: Number of compared calls. 0 if the row is not compared.
        difference: The first difference, or an empty text.
        without: Description of the cases that are omitted from the comparison.
    """

    row: Row
    calls: int = 0
    difference: str = ""
    without: str = ""

    @property
    def text(self) -> str:
        """Return the result of the comparison in one line of text."""
        name = f"{self.row.title} ({', '.join(self.row.tools)}): {self.row.meaning}"
        if not self.calls:
            return f"{name}: only the built-in engine computes it"
        without = f" (without {self.without})" if self.without else ""
        return f"{name}: {self.calls} calls{without}, {self.difference or 'no difference'}"


_COUNTER_INPUTS = ("A", "In1", "In2", "Reset", "Load")
_COUNTERS = "Up : CTU; Down : CTD; Both : CTUD; "

PROBES = (
    Probe(
        "time_unit",
        ("s",),
        ("D",),
        "T : TIME; FromTime : DINT; TimeToReal : REAL;",
        "T := DINT_TO_TIME(D); FromTime := TIME_TO_DINT(T); TimeToReal := TIME_TO_REAL(T);",
        ("T", "FromTime", "TimeToReal"),
    ),
    Probe(
        "counters",
        ("preset",),
        _COUNTER_INPUTS,
        f"{_COUNTERS} UpV, DownV, BothV : INT; UpQ, DownQ, BothU, BothD : BOOL;",
        "Up(CU := In1, R := Reset, PV := A); UpV := Up.CV; UpQ := Up.Q;\n"
        "Down(CD := In2, LD := Load, PV := A); DownV := Down.CV; DownQ := Down.Q;\n"
        "Both(CU := In1, CD := In2, R := Reset, LD := Load, PV := A);\n"
        "BothV := Both.CV; BothU := Both.QU; BothD := Both.QD;",
        ("UpV", "UpQ", "DownV", "DownQ", "BothV", "BothU", "BothD"),
    ),
    # This program contains only counters that no fault of matiec affects; see
    # `engines.matiec.counter_blocks`.
    Probe(
        "counters",
        ("type", "unsigned"),
        _COUNTER_INPUTS,
        "Up : CTU; Self : CTU; Gate : CTU; Down : CTD; Wide : CTD_UDINT; "
        "UpQ, DownQ, SelfQ, GateQ : BOOL; SelfV, GateV : INT; WideV : UDINT;",
        "IF Load THEN Up(R := TRUE); END_IF;\n"
        "Up(CU := In1, R := Reset, PV := 3); UpQ := Up.Q;\n"
        "Self(CU := In1, R := Reset OR Self.Q, PV := 4); SelfV := Self.CV; SelfQ := Self.Q;\n"
        "Gate(CU := In2 AND NOT Gate.Q, R := Reset, PV := 2); GateV := Gate.CV; GateQ := Gate.Q;\n"
        "Down(CD := In2, LD := Load, PV := A); DownQ := Down.Q;\n"
        "Wide(CD := In1, LD := Load, PV := 5); WideV := Wide.CV;",
        ("UpQ", "SelfV", "SelfQ", "GateV", "GateQ", "DownQ", "WideV"),
        "CV beyond PV and below 0, a known fault of matiec",
    ),
    Probe(
        "operands",
        ("needed",),
        ("A", "B"),
        "OnRight, OnEither : BOOL;",
        "OnRight := (B <> 0) AND (A / B > 1); OnEither := (B = 0) OR (A / B > 1);",
        ("OnRight", "OnEither"),
    ),
    Probe(
        "integers",
        ("own",),
        ("A", "B"),
        "Product, Sum, Mean : INT;",
        "Product := A * B; Sum := A + B; Mean := Sum / 2;",
        ("Product", "Sum", "Mean"),
    ),
    Probe(
        "text",
        (126,),
        ("Short",),
        "Joined : STRING; Length : INT;",
        "Joined := CONCAT(Short, Short); Length := LEN(Joined);",
        ("Joined", "Length"),
    ),
    Probe(
        "notation",
        ("digits",),
        ("D", "X"),
        "Digits, Bits : STRING;",
        "Digits := REAL_TO_STRING(X); Bits := DWORD_TO_STRING(DINT_TO_DWORD(D));",
        ("Digits", "Bits"),
    ),
    Probe(
        "real_by_zero",
        ("infinite",),
        ("X", "Y"),
        "Quotient : REAL; Above : BOOL;",
        "Quotient := X / Y; Above := Quotient > 1.0E38;",
        ("Quotient", "Above"),
    ),
    Probe(
        "real_by_zero",
        ("stop",),
        ("X", "Y"),
        "Quotient : REAL;",
        "IF Y <> 0.0 THEN Quotient := X / Y; END_IF;",
        ("Quotient",),
        "divisors of 0, with which matiec continues",
    ),
    Probe("root", ("nan",), ("Y",), "Root : REAL;", "Root := SQRT(Y);", ("Root",)),
    Probe(
        "root",
        ("stop",),
        ("Y",),
        "Root : REAL;",
        "IF Y >= 0.0 THEN Root := SQRT(Y); END_IF;",
        ("Root",),
        "negative numbers, with which matiec continues",
    ),
    Probe(
        "start",
        ("declared",),
        ("B",),
        "First : INT; Second : INT; END_VAR VAR_EXTERNAL Level : INT; Other : INT;",
        "Level := Level + B; First := Level; Other := Other - First; Second := Other;",
        ("First", "Second"),
    ),
)

_TYPES = {"A": "INT", "B": "INT", "D": "DINT", "X": "REAL", "Y": "REAL", "Short": "STRING"}
_FRAME = """PROGRAM P1
VAR {inputs}
{variables}
END_VAR
{body}
END_PROGRAM
CONFIGURATION C1
VAR_GLOBAL Level : INT := 7; Other : INT := -7; END_VAR
RESOURCE R1 ON PLC
TASK T1(INTERVAL := T#10ms, PRIORITY := 1);
PROGRAM Main WITH T1 : P1;
END_RESOURCE
END_CONFIGURATION
"""


def probe_of(row: Row) -> Probe | None:
    """Return the program for a row, or None if matiec does not compute the value of the row."""
    found = (one for one in PROBES if one.rule == row.rule and row.value in one.values)
    return next(found, None)


def program_text(probe: Probe) -> str:
    """Return the Structured Text of a probe."""
    inputs = " ".join(f"{name} : {_TYPES.get(name, 'BOOL')};" for name in probe.inputs)
    return _FRAME.format(inputs=inputs, variables=probe.variables, body=probe.body)


def compared_rows(matiec: Matiec, compiler: str, calls: int, seed: int = 43) -> Iterator[RowCalls]:
    """Yield the result for each row of the table, in its order.

    Args:
        matiec: The engine to compare with.
        compiler: The C compiler for the code that matiec generates.
        calls: Number of calls for each compared row, rounded up to a multiple of the row's tools.
        seed: Seed of the random values.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "row.st"
        for row in rows():
            probe = probe_of(row)
            if probe is None:
                yield RowCalls(row)
                continue
            file.write_text(program_text(probe), encoding="utf-8")
            done, difference = 0, ""
            for tool in row.tools:
                project = load([in_dialect(file, tool)])
                ours = BuiltinProgram.build(project)
                theirs = MatiecProgram.build(project, matiec, compiler)
                made, difference = _calls(
                    probe, ours, theirs, -(-calls // len(row.tools)), random.Random(seed)
                )
                theirs.close()
                done += made
                if difference:
                    difference = f"differs in {tool}: {difference}"
                    break
            yield RowCalls(row, done, difference, probe.without)


def _calls(
    probe: Probe, ours: BuiltinProgram, theirs: MatiecProgram, calls: int, draw: random.Random
) -> tuple[int, str]:
    """Compare calls of one row. Return their number and the first difference."""
    shown = [f"Main.{name}" for name in probe.shown]
    readers = [engine.reader(shown) for engine in (ours, theirs)]
    for scan in range(calls):
        given = {f"Main.{name}": _drawn(name, draw) for name in probe.inputs}
        for engine in (ours, theirs):
            for path, value in given.items():
                engine.write(path, value)
            engine.scan(scan * 10_000)
        mine, other = (reader() for reader in readers)
        if repr(mine) != repr(other):
            return scan + 1, f"{mine} here, {other} on matiec, call {scan} with {given}"
    return calls, ""


def _drawn(name: str, draw: random.Random) -> Any:
    """Return a random value of an input. Counters often get edges and limits, but seldom a load."""
    if name == "A":
        edge = draw.choice(_INT_EDGES)
        return draw.choice((edge, draw.randrange(-32768, 32768), draw.randint(1, 9)))
    if name == "B":
        return draw.choice((0, 1, 2, 7, draw.randrange(-32767, 32768)))
    if name == "D":
        return draw.choice((0, 1, -1, draw.randrange(-(10**6), 10**6)))
    if name in ("X", "Y"):
        return draw.choice((0.0, 1.0, draw.randrange(-(10**6), 10**6) / 8))
    if name == "Short":
        return "x" * draw.randint(0, 126)
    return draw.random() < {"In1": 0.5, "In2": 0.4}.get(name, 0.02)
