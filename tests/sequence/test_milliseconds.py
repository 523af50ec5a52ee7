"""FC_RcxMilliseconds and FC_RcxWaited convert time limits to numbers that are equal on all PLCs."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from plc_bench import compiled
from structured_text.engines.base import Program

_LITERALS = (1, 2, 3, 4, 7, 8, 16, 63, 99, 128, 150, 255, 999, 1000, 1001, 5000, 60_000, 3_600_000)
_PROGRAM = """
PROGRAM Limits
  VAR
    Given   : TIME;
    Count   : DINT;
    Literal : DINT;
    Index   : INT;
    Waits   : BOOL;
    Before  : DINT := -1;
    Elapsed : UINT;
  END_VAR
  CASE Index OF
{literals}
  END_CASE;
  Count := FC_RcxMilliseconds(Value := Given);
  Before := FC_RcxWaited(Waits := Waits, Before := Before, Elapsed := Elapsed);
END_PROGRAM
CONFIGURATION Config0
  RESOURCE Res0 ON PLC
    TASK Cyclic(INTERVAL := T#1ms, PRIORITY := 0);
    PROGRAM Main WITH Cyclic : Limits;
  END_RESOURCE
END_CONFIGURATION
"""


@pytest.fixture(params=ENGINES)
def program(request: pytest.FixtureRequest) -> Program:
    rows = [
        f"    {k}: Literal := FC_RcxMilliseconds(Value := T#{ms}ms);"
        for k, ms in enumerate(_LITERALS)
    ]
    return compiled(_PROGRAM.format(literals="\n".join(rows)), request.param)


def test_a_time_literal_gives_its_exact_milliseconds(program: Program) -> None:
    """A TIME literal gives its exact milliseconds.

    On matiec about half of the literals are one nanosecond short.
    """
    for index, ms in enumerate(_LITERALS):
        program.write("Main.Index", index)
        program.scan(index)
        assert program.read("Main.Literal") == ms


@pytest.mark.parametrize(
    ("time", "ms"), [("T#0.4ms", 0), ("T#0.5ms", 1), ("T#1.4ms", 1), ("T#1.5ms", 2)]
)
def test_a_part_of_a_millisecond_is_rounded(program: Program, time: str, ms: int) -> None:
    """Source: head of FC_RcxMilliseconds."""
    program.write("Main.Given", time)
    program.scan(0)
    assert program.read("Main.Count") == ms


@pytest.mark.parametrize(
    ("time", "ms"),
    [
        ("T#0s", 0),
        ("T#1500ms", 1500),
        ("T#59s", 59_000),
        ("T#3h25m45s", 12_345_000),
        ("T#479h59m59s", 1_727_999_000),
        ("T#480h", 1_728_000_000),
        ("T#480h1ms", 1_728_000_000),
        ("T#480h59m59s", 1_728_000_000),
        ("T#481h", 1_728_000_000),
        ("T#1000h", 1_728_000_000),
    ],
)
def test_every_digit_counts_up_to_20_days(program: Program, time: str, ms: int) -> None:
    program.write("Main.Given", time)
    program.scan(0)
    assert program.read("Main.Count") == ms


def test_a_wait_counts_from_its_first_scan_on_and_stops_at_its_end(program: Program) -> None:
    program.write("Main.Elapsed", 10)
    shown = []
    for now, waits in enumerate((False, True, True, True, False, True, True)):
        program.write("Main.Waits", waits)
        program.scan(now)
        shown.append(program.read("Main.Before"))
    assert shown == [-1, 0, 10, 20, -1, 0, 10]


def test_a_wait_never_overflows(program: Program) -> None:
    program.write("Main.Waits", True)
    program.write("Main.Elapsed", 65_535)
    program.write("Main.Before", 1_999_999_999)
    for now in range(3):
        program.scan(now)
        assert program.read("Main.Before") == 2_000_065_534
    program.write("Main.Before", 2_000_000_000)
    program.scan(3)
    assert program.read("Main.Before") == 2_000_000_000, "the count stops at 23 days"
