"""The standard blocks, cycle by cycle."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram

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


def test_ctud_counts_an_edge_down_once_and_takes_edges_up_while_that_level_lasts(
    build: Build,
) -> None:
    steps: list[dict[str, Any]] = [
        {"PV": 5, "LD": True},
        {"LD": False, "CD": True},
        {"CU": False},
        {"CU": True},
    ]

    assert [cv for (cv,) in _trace(build, "CTUD", steps, "CV")] == [5, 4, 4, 5]


def test_ton_begins_anew_after_each_interruption_however_short(build: Build) -> None:
    inputs = _levels("IN", "0111011111")
    inputs[0]["PT"] = "T#30ms"

    rows = _trace(build, "TON", inputs, "Q ET")
    assert [et for _, et in rows] == [0, 0, 10, 20, 0, 0, 10, 20, 30, 30]
    assert [q for q, _ in rows] == [False] * 8 + [True] * 2


def test_ton_takes_a_time_that_is_changed_while_it_runs(build: Build) -> None:
    """The time it compares with is that of the call."""
    inputs = _levels("IN", "0111111")
    inputs[0]["PT"] = "T#100ms"
    inputs[4]["PT"] = "T#20ms"

    assert [q for (q,) in _trace(build, "TON", inputs, "Q")] == [False] * 4 + [True] * 3


def test_tof_is_on_from_the_first_call_and_its_time_starts_at_each_fall(build: Build) -> None:
    inputs = _levels("IN", "1001000000")
    inputs[0]["PT"] = "T#30ms"

    rows = _trace(build, "TOF", inputs, "Q ET")
    assert [q for q, _ in rows] == [True] * 7 + [False] * 3
    assert [et for _, et in rows] == [0, 0, 10, 0, 0, 10, 20, 30, 30, 30]


def test_tof_that_was_never_on_stays_off(build: Build) -> None:
    inputs = _levels("IN", "000")
    inputs[0]["PT"] = "T#10ms"

    assert _trace(build, "TOF", inputs, "Q ET") == [(False, 0)] * 3


def test_tp_is_not_started_again_by_edges_within_its_pulse(build: Build) -> None:
    inputs = _levels("IN", "0101100001")
    inputs[0]["PT"] = "T#30ms"

    rows = _trace(build, "TP", inputs, "Q ET")
    assert [q for q, _ in rows] == [
        False,
        True,
        True,
        True,
        False,
        False,
        False,
        False,
        False,
        True,
    ]
    assert [et for _, et in rows] == [0, 0, 10, 20, 30, 0, 0, 0, 0, 0]


@pytest.mark.parametrize(("kind", "text"), [("CTU", "0110"), ("CTU_UDINT", "0110")])
def test_ctu_counts_an_edge_once_and_not_the_one_during_its_reset(
    build: Build, kind: str, text: str
) -> None:
    inputs: list[dict[str, Any]] = _levels("CU", text + text)
    inputs[0]["PV"] = 5
    inputs[1]["R"] = True
    inputs[2]["R"] = False

    assert [cv for (cv,) in _trace(build, kind, inputs, "CV")] == [0, 0, 0, 0, 0, 1, 1, 1]


@pytest.mark.parametrize(
    ("kind", "top"), [("CTU", 32767), ("CTU_DINT", 2**31 - 1), ("CTU_ULINT", 2**64 - 1)]
)
def test_ctu_stops_at_the_greatest_value_of_its_type(build: Build, kind: str, top: int) -> None:
    inputs: list[dict[str, Any]] = _levels("CU", "0101")
    inputs[0] |= {"PV": top, "CV": top - 1}

    assert _trace(build, kind, inputs, "Q CV") == [
        (False, top - 1),
        (True, top),
        (True, top),
        (True, top),
    ]


def test_a_counter_without_a_preset_is_at_its_end_at_once(build: Build) -> None:
    assert _trace(build, "CTU", _levels("CU", "01"), "Q CV") == [(True, 0), (True, 0)]
    assert _trace(build, "CTD", _levels("CD", "01"), "Q CV") == [(True, 0), (True, 0)]
    assert _trace(build, "CTUD", _levels("CU", "01"), "QU QD") == [(True, True), (True, True)]


def test_loading_wins_over_counting_down_and_the_edge_is_used_up(build: Build) -> None:
    inputs: list[dict[str, Any]] = _levels("CD", "01101")
    inputs[0] |= {"PV": 3, "LD": True}
    inputs[2]["LD"] = False

    assert [cv for (cv,) in _trace(build, "CTD", inputs, "CV")] == [3, 3, 3, 3, 2]


def test_ctud_resets_before_it_loads_and_both_come_before_counting(build: Build) -> None:
    steps: list[dict[str, Any]] = [
        {"PV": 3, "CU": True},
        {"CU": False},
        {"LD": True, "CU": True},
        {"R": True},
        {"LD": False, "R": False, "CU": False},
        {"CD": True},
    ]

    assert _trace(build, "CTUD", steps, "QU QD CV") == [
        (False, False, 1),
        (False, False, 1),
        (True, False, 3),
        (False, True, 0),
        (False, True, 0),
        (False, True, 0),
    ]


@pytest.mark.parametrize(("kind", "first"), [("R_TRIG", True), ("F_TRIG", False)])
def test_a_first_level_of_true_is_a_rising_edge_only(build: Build, kind: str, first: bool) -> None:
    assert _trace(build, kind, _levels("CLK", "11"), "Q") == [(first,), (False,)]


@pytest.mark.parametrize(("kind", "pins"), [("SR", ("S1", "R", "Q1")), ("RS", ("S", "R1", "Q1"))])
def test_a_bistable_keeps_its_state_through_calls_without_inputs(
    build: Build, kind: str, pins: tuple[str, str, str]
) -> None:
    on, off, out = pins
    steps = [{on: True}, {on: False}, {}, {off: True}, {off: False}, {}]

    rows = _trace(build, kind, steps, out)
    assert rows == [(True,), (True,), (True,), (False,), (False,), (False,)]


@pytest.mark.parametrize(
    ("kind", "flags", "others"),
    [
        ("TON", "IN Q", {"PT": timedelta(0), "ET": timedelta(0)}),
        ("TOF", "IN Q", {"PT": timedelta(0), "ET": timedelta(0)}),
        ("TP", "IN Q", {"PT": timedelta(0), "ET": timedelta(0)}),
        ("R_TRIG", "CLK Q", {}),
        ("F_TRIG", "CLK Q", {}),
        ("SR", "S1 R Q1", {}),
        ("RS", "S R1 Q1", {}),
        ("CTU", "CU R Q", {"PV": 0, "CV": 0}),
        ("CTD", "CD LD Q", {"PV": 0, "CV": 0}),
        ("CTUD", "CU CD R LD QU QD", {"PV": 0, "CV": 0}),
    ],
)
def test_before_its_first_call_each_pin_is_false_or_0_of_its_type(
    build: Build, kind: str, flags: str, others: dict[str, Any]
) -> None:
    """Source: IEC 61131-3 (2003), 2.4.3.1, table 13: default initial values."""
    program = build(f"PROGRAM P1\nVAR B1 : {kind}; END_VAR\nEND_PROGRAM")
    for pin in flags.split():
        assert program.read(f"Main.B1.{pin}") is False, pin
    for pin, value in others.items():
        found = program.read(f"Main.B1.{pin}")
        assert (type(found), found) == (type(value), value), pin


@pytest.mark.parametrize(
    ("kind", "inputs", "expired"),
    [
        ("TON", "0111111", (True, 20)),
        ("TP", "0111111", (False, 20)),
        ("TOF", "1000000", (False, 20)),
    ],
)
def test_an_expired_timer_does_not_go_on_when_its_time_is_made_longer(
    build: Build, kind: str, inputs: str, expired: tuple[bool, int]
) -> None:
    """PT = 20 ms becomes 60 ms two scans after it is over.

    Source: IEC 61131-3 (2003), 2.5.2.3.4, figure 15: nothing starts the timer but an edge.
    """
    steps = _levels("IN", inputs)
    steps[0]["PT"] = "T#20ms"
    steps[5]["PT"] = "T#60ms"
    assert _trace(build, kind, steps, "Q ET")[3:] == [expired] * 4
