"""The standard blocks, cycle by cycle."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from typing import Any

import pytest

from rcx_harness.engine.builtin import BuiltinProgram

Build = Callable[[str], BuiltinProgram]


def _trace(
    build: Build, kind: str, inputs: list[dict[str, Any]], outputs: str, step_ms: int = 10
) -> list[tuple[Any, ...]]:
    """Outputs of a block after each scan, TIME in ms; an input stays until it is set again."""
    program = build(f"PROGRAM P1\nVAR B1 : {kind}; END_VAR\nB1();\nEND_PROGRAM")
    rows = []
    for k, values in enumerate(inputs):
        for pin, value in values.items():
            program.write(f"Main.B1.{pin}", value)
        program.scan(k * step_ms * 1000)
        read = [program.read(f"Main.B1.{pin}") for pin in outputs.split()]
        rows.append(
            tuple(v // timedelta(milliseconds=1) if isinstance(v, timedelta) else v for v in read)
        )
    return rows


def _levels(pin: str, text: str) -> list[dict[str, Any]]:
    """One scan per character: 1 is TRUE, 0 is FALSE."""
    return [{pin: character == "1"} for character in text]


def test_ton_switches_on_when_its_time_is_over(build: Build) -> None:
    inputs = _levels("IN", "01111100110")
    inputs[0]["PT"] = "T#30ms"

    assert _trace(build, "TON", inputs, "Q ET") == [
        (False, 0),
        (False, 0),
        (False, 10),
        (False, 20),
        (True, 30),
        (True, 30),
        (False, 0),
        (False, 0),
        (False, 0),
        (False, 10),
        (False, 0),
    ]


def test_tof_switches_off_when_its_time_is_over(build: Build) -> None:
    inputs = _levels("IN", "0100010000000")
    inputs[0]["PT"] = "T#30ms"

    assert _trace(build, "TOF", inputs, "Q ET") == [
        (False, 0),
        (True, 0),
        (True, 0),
        (True, 10),
        (True, 20),
        (True, 0),
        (True, 0),
        (True, 10),
        (True, 20),
        (False, 30),
        (False, 30),
        (False, 30),
        (False, 30),
    ]


def test_tp_gives_one_pulse_of_its_length_however_long_the_input(build: Build) -> None:
    inputs = _levels("IN", "01000000111111")
    inputs[0]["PT"] = "T#30ms"

    assert _trace(build, "TP", inputs, "Q ET") == [
        (False, 0),
        (True, 0),
        (True, 10),
        (True, 20),
        (False, 0),
        (False, 0),
        (False, 0),
        (False, 0),
        (True, 0),
        (True, 10),
        (True, 20),
        (False, 30),
        (False, 30),
        (False, 30),
    ]


def test_a_timer_without_time_expires_one_call_after_its_start(build: Build) -> None:
    assert _trace(build, "TON", _levels("IN", "0111"), "Q") == [
        (False,),
        (False,),
        (True,),
        (True,),
    ]


def test_ton_called_twice_in_a_scan_restarts_at_once(build: Build) -> None:
    program = build(
        "PROGRAM P1\nVAR Restart : BOOL; Delay : TON; END_VAR\n"
        "IF Restart THEN Delay(IN := FALSE); END_IF;\nDelay(IN := TRUE, PT := T#30ms);\nEND_PROGRAM"
    )
    rows = []
    for k in range(7):
        program.write("Main.Restart", k == 3)
        program.scan(k * 10_000)
        rows.append((program.read("Main.Delay.Q"), program.read("Main.Delay.ET").microseconds))

    assert rows == [
        (False, 0),
        (False, 10_000),
        (False, 20_000),
        (False, 0),
        (False, 10_000),
        (False, 20_000),
        (True, 30_000),
    ]


def test_a_timer_sees_the_time_of_the_scan_not_the_number_of_scans(build: Build) -> None:
    inputs = _levels("IN", "0111")
    inputs[0]["PT"] = "T#30ms"

    assert _trace(build, "TON", inputs, "Q ET", step_ms=40) == [
        (False, 0),
        (False, 0),
        (True, 30),
        (True, 30),
    ]


@pytest.mark.parametrize(
    ("kind", "levels", "edges"),
    [("R_TRIG", "1101101", "1001001"), ("F_TRIG", "1101001", "0010100")],
)
def test_an_edge_is_seen_for_one_call(build: Build, kind: str, levels: str, edges: str) -> None:
    rows = _trace(build, kind, _levels("CLK", levels), "Q")

    assert "".join("1" if q else "0" for (q,) in rows) == edges


def test_f_trig_takes_a_first_low_level_for_an_edge_as_the_standard_does(build: Build) -> None:
    assert _trace(build, "F_TRIG", _levels("CLK", "00"), "Q") == [(True,), (False,)]


@pytest.mark.parametrize(
    ("kind", "set_pin", "reset_pin", "both"), [("SR", "S1", "R", True), ("RS", "S", "R1", False)]
)
def test_the_bistables_differ_in_which_input_wins(
    build: Build, kind: str, set_pin: str, reset_pin: str, both: bool
) -> None:
    steps = [(False, False), (True, False), (False, False), (False, True), (True, True)]
    inputs = [{set_pin: on, reset_pin: off} for on, off in steps]

    rows = _trace(build, kind, inputs, "Q1")
    assert rows == [(False,), (True,), (True,), (False,), (both,)]


def test_ctu_counts_edges_up_to_its_preset(build: Build) -> None:
    inputs: list[dict[str, Any]] = _levels("CU", "0101010101")
    inputs[0]["PV"] = 3
    inputs[8]["R"] = True

    assert _trace(build, "CTU", inputs, "Q CV") == [
        (False, 0),
        (False, 1),
        (False, 1),
        (False, 2),
        (False, 2),
        (True, 3),
        (True, 3),
        (True, 3),
        (False, 0),
        (False, 0),
    ]


def test_ctd_loads_its_preset_and_counts_down_to_zero(build: Build) -> None:
    inputs: list[dict[str, Any]] = _levels("CD", "001010101")
    inputs[0] |= {"PV": 2, "LD": True}
    inputs[1]["LD"] = False

    assert _trace(build, "CTD_DINT", inputs, "Q CV") == [
        (False, 2),
        (False, 2),
        (False, 1),
        (False, 1),
        (True, 0),
        (True, 0),
        (True, 0),
        (True, 0),
        (True, 0),
    ]


def test_ctud_counts_both_ways_and_ignores_edges_at_the_same_time(build: Build) -> None:
    steps = [(0, 0), (1, 0), (0, 0), (1, 1), (0, 0), (1, 0), (0, 1), (0, 0), (0, 1), (0, 0)]
    inputs: list[dict[str, Any]] = [{"CU": bool(up), "CD": bool(down)} for up, down in steps]
    inputs[0]["PV"] = 2
    inputs[9]["LD"] = True

    assert _trace(build, "CTUD", inputs, "QU QD CV") == [
        (False, True, 0),
        (False, False, 1),
        (False, False, 1),
        (False, False, 1),
        (False, False, 1),
        (True, False, 2),
        (False, False, 1),
        (False, False, 1),
        (False, True, 0),
        (True, False, 2),
    ]
