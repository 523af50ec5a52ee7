"""The standard blocks have the right outputs in each scan."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram

Build = Callable[[str], BuiltinProgram]
Changes = dict[int, dict[str, Any]]
_MS = timedelta(milliseconds=1)


def _trace(
    build: Build, kind: str, levels: dict[str, str], changes: Changes, outputs: list[str], step: int
) -> dict[str, Any]:
    """Return the outputs of a block per scan: a character for a BOOL, milliseconds for a TIME.

    A string of inputs has one character per scan, where 1 is TRUE. Any other input is constant
    until it is set again.
    """
    program = build(f"PROGRAM P1\nVAR B1 : {kind}; END_VAR\nB1();\nEND_PROGRAM")
    found: dict[str, list[Any]] = {pin: [] for pin in outputs}
    for scan in range(len(next(iter(levels.values())))):
        given = {pin: text[scan] == "1" for pin, text in levels.items()}
        for pin, value in (given | changes.get(scan, {})).items():
            program.write(f"Main.B1.{pin}", value)
        program.scan(scan * step * 1000)
        for pin, values in found.items():
            value = program.read(f"Main.B1.{pin}")
            values.append(value // _MS if isinstance(value, timedelta) else value)
    return {
        pin: "".join("01"[one] for one in values) if isinstance(values[0], bool) else values
        for pin, values in found.items()
    }


def _case(
    name: str,
    kind: str,
    levels: dict[str, str],
    changes: Changes,
    outputs: dict[str, Any],
    step: int = 10,
) -> Any:
    return pytest.param(kind, levels, changes, outputs, step, id=f"{kind} {name}")


def _timer(
    name: str, kind: str, levels: str, times: dict[int, int], q: str, et: list[int], step: int = 10
) -> Any:
    """Return a timer case. `times` has milliseconds, by the number of the scan that sets them."""
    changes = {scan: {"PT": f"T#{ms}ms"} for scan, ms in times.items()}
    return _case(name, kind, {"IN": levels}, changes, {"Q": q} | ({"ET": et} if et else {}), step)


_PT = {0: 30}
_LONGER = {0: 20, 5: 60}  # two scans after the end of the time
_TIMERS = [
    _timer("turns on when its time has passed", "TON", "01111100110", _PT,
           "00001100000", [0, 0, 10, 20, 30, 30, 0, 0, 0, 10, 0]),
    _timer("with a time of 0 turns on one call after its start", "TON", "0111", {}, "0011", []),
    _timer("counts the time and not the number of scans", "TON", "0111", _PT,
           "0011", [0, 0, 30, 30], step=40),
    _timer("restarts after each interruption", "TON", "0111011111", _PT,
           "0000000011", [0, 0, 10, 20, 0, 0, 10, 20, 30, 30]),
    _timer("uses the time of the call", "TON", "0111111", {0: 100, 4: 20},
           "0000111", []),
    _timer("that has expired ignores a longer time", "TON", "0111111", _LONGER,
           "0001111", [0, 0, 10, 20, 20, 20, 20]),
    _timer("turns off when its time has passed", "TOF", "0100010000000", _PT,
           "0111111110000", [0, 0, 0, 10, 20, 0, 0, 10, 20, 30, 30, 30, 30]),
    _timer("is on from the first call and its time starts at each fall", "TOF", "1001000000", _PT,
           "1111111000", [0, 0, 10, 0, 0, 10, 20, 30, 30, 30]),
    _timer("with an input that was never on stays off", "TOF", "000", {0: 10}, "000", [0, 0, 0]),
    _timer("that has expired ignores a longer time", "TOF", "1000000", _LONGER,
           "1110000", [0, 0, 10, 20, 20, 20, 20]),
    _timer("gives a single pulse for an input of any length", "TP", "01000000111111", _PT,
           "01110000111000", [0, 0, 10, 20, 0, 0, 0, 0, 0, 10, 20, 30, 30, 30]),
    _timer("is not started again within its pulse", "TP", "0101100001", _PT,
           "0111000001", [0, 0, 10, 20, 30, 0, 0, 0, 0, 0]),
    _timer("that has expired ignores a longer time", "TP", "0111111", _LONGER,
           "0110000", [0, 0, 10, 20, 20, 20, 20]),
]  # fmt: skip
_EDGES = [
    _case("reports an edge for one call", "R_TRIG", {"CLK": "1101101"}, {}, {"Q": "1001001"}),
    _case("reports an edge for one call", "F_TRIG", {"CLK": "1101001"}, {}, {"Q": "0010100"}),
    _case("reports a first low level as an edge", "F_TRIG", {"CLK": "00"}, {}, {"Q": "10"}),
    _case("reports a first high level as an edge", "R_TRIG", {"CLK": "11"}, {}, {"Q": "10"}),
    _case("reports no edge at a first high level", "F_TRIG", {"CLK": "11"}, {}, {"Q": "00"}),
    _case("is set by both inputs", "SR", {"S1": "01001", "R": "00011"}, {}, {"Q1": "01101"}),
    _case("is reset by both inputs", "RS", {"S": "01001", "R1": "00011"}, {}, {"Q1": "01100"}),
    _case("keeps its state", "SR", {"S1": "100000", "R": "000100"}, {}, {"Q1": "111000"}),
    _case("keeps its state", "RS", {"S": "100000", "R1": "000100"}, {}, {"Q1": "111000"}),
]
_COUNTERS = [
    _case("counts edges beyond its preset", "CTU", {"CU": "0101010101"},
          {0: {"PV": 3}, 8: {"R": True}},
          {"Q": "0000011100", "CV": [0, 1, 1, 2, 2, 3, 3, 4, 0, 0]}),
    *(_case("counts an edge once and not the one during its reset", kind, {"CU": "01100110"},
            {0: {"PV": 5}, 1: {"R": True}, 2: {"R": False}}, {"CV": [0, 0, 0, 0, 0, 1, 1, 1]})
      for kind in ("CTU", "CTU_UDINT")),
    *(_case("stops at the greatest value of its type", kind, {"CU": "0101"},
            {0: {"PV": top, "CV": top - 1}}, {"Q": "0111", "CV": [top - 1, top, top, top]})
      for kind, top in (("CTU", 32767), ("CTU_DINT", 2**31 - 1), ("CTU_ULINT", 2**64 - 1))),
    *(_case("counts down to the least value of its type", kind, {"CD": "0101"},
            {0: {"CV": least + 1}}, {"Q": "1111", "CV": [least + 1, least, least, least]})
      for kind, least in (("CTD", -32768), ("CTD_DINT", -(2**31)), ("CTD_LINT", -(2**63)))),
    _case("counts down to 0", "CTD_UDINT", {"CD": "0101"}, {0: {"CV": 1}},
          {"Q": "0111", "CV": [1, 0, 0, 0]}),
    _case("with a preset of 0 is at its end", "CTU", {"CU": "01"}, {}, {"Q": "11", "CV": [0, 1]}),
    _case("with a preset of 0 is at its end", "CTD", {"CD": "01"}, {}, {"Q": "11", "CV": [0, -1]}),
    _case("with a preset of 0 is at both ends", "CTUD", {"CU": "00"}, {}, {"QU": "11", "QD": "11"}),
    _case("loads its preset and counts down below zero", "CTD_DINT", {"CD": "001010101"},
          {0: {"PV": 2, "LD": True}, 1: {"LD": False}},
          {"Q": "000011111", "CV": [2, 2, 1, 1, 0, 0, -1, -1, -2]}),
    _case("counts beyond its preset and back", "CTUD",
          {"CU": "01010101010000", "CD": "00000000000101"}, {0: {"PV": 3}},
          {"QU": "00000111111111", "CV": [0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 4, 4, 3]}),
    _case("counts below zero and back", "CTUD", {"CU": "0000101", "CD": "0101000"}, {0: {"PV": 1}},
          {"QD": "1111111", "CV": [0, -1, -1, -2, -1, -1, 0]}),
    _case("loads before it counts and ignores the edge in this scan", "CTD", {"CD": "01101"},
          {0: {"PV": 3, "LD": True}, 2: {"LD": False}}, {"CV": [3, 3, 3, 3, 2]}),
    _case("ignores edges up and down at the same time", "CTUD",
          {"CU": "0101010000", "CD": "0001001010"}, {0: {"PV": 2}, 9: {"LD": True}},
          {"QU": "0000010001", "QD": "1000000010", "CV": [0, 1, 1, 1, 1, 2, 1, 1, 0, 2]}),
    _case("counts an edge down once and edges up while that level lasts", "CTUD",
          {"CU": "0001", "CD": "0111"}, {0: {"PV": 5, "LD": True}, 1: {"LD": False}},
          {"CV": [5, 4, 4, 5]}),
    _case("resets before it loads and loads before it counts", "CTUD",
          {"CU": "101100", "CD": "000001"},
          {0: {"PV": 3}, 2: {"LD": True}, 3: {"R": True}, 4: {"LD": False, "R": False}},
          {"QU": "001000", "QD": "000111", "CV": [1, 1, 3, 0, 0, -1]}),
]  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "levels", "changes", "outputs", "step"), [*_TIMERS, *_EDGES, *_COUNTERS]
)
def test_a_standard_block_has_the_outputs_of_the_standard(
    build: Build,
    kind: str,
    levels: dict[str, str],
    changes: Changes,
    outputs: dict[str, Any],
    step: int,
) -> None:
    """The block's outputs in each scan are those of the standard.

    Source: IEC 61131-3 (2003), 2.5.2.3.1 to 2.5.2.3.4; figure 15: an edge starts a timer.
    """
    assert _trace(build, kind, levels, changes, list(outputs), step) == outputs


def test_ton_called_twice_in_a_scan_restarts_at_once(build: Build) -> None:
    program = build(
        "PROGRAM P1\nVAR Restart : BOOL; Delay : TON; END_VAR\n"
        "IF Restart THEN Delay(IN := FALSE); END_IF;\nDelay(IN := TRUE, PT := T#30ms);\nEND_PROGRAM"
    )
    rows = []
    for k in range(7):
        program.write("Main.Restart", k == 3)
        program.scan(k * 10_000)
        rows.append((program.read("Main.Delay.Q"), program.read("Main.Delay.ET") // _MS))
    assert rows == [(ms == 30, ms) for ms in (0, 10, 20, 0, 10, 20, 30)]


_TIMES = {"PT": timedelta(0), "ET": timedelta(0)}


@pytest.mark.parametrize(
    ("kind", "flags", "others"),
    [
        ("TON", "IN Q", _TIMES),
        ("TOF", "IN Q", _TIMES),
        ("TP", "IN Q", _TIMES),
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
    """Before its first call, each pin of a standard block has the initial value of its type.

    Source: IEC 61131-3 (2003), 2.4.3.1, table 13: default initial values.
    """
    program = build(f"PROGRAM P1\nVAR B1 : {kind}; END_VAR\nEND_PROGRAM")
    for pin, value in (dict.fromkeys(flags.split(), False) | others).items():
        found = program.read(f"Main.B1.{pin}")
        assert (type(found), found) == (type(value), value), pin
