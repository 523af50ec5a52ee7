"""A command block waits until another block's command ends, and does not use the other answer."""

from __future__ import annotations

import random
from collections.abc import Mapping
from datetime import timedelta
from math import inf

import pytest

from block_pins import Reading
from command_bench import BLOCKS, bench_of
from for_each import for_each
from structured_text.engines.base import Value
from structured_text.output.units import parse_us


@for_each("name", BLOCKS)
def test_a_waiting_block_sends_the_values_of_its_rising_edge(name: str) -> None:
    """After the wait, the block sends the values of the rising edge.

    Source: design of the library, 3.
    """
    plc, chance = bench_of(name, "builtin"), random.Random(name)
    reading = Reading(BLOCKS[name])
    first = reading.draw(chance)
    plc.scan()
    assert plc.pin("Timeout") == timedelta(microseconds=parse_us(BLOCKS[name].timeout))
    expected = plc.exchange(first)
    plc.give("Rival", 0x0501)
    plc.set({**first, "Timeout": "T#100ms", "Execute": True})
    plc.scan()
    for _ in range(3):
        plc.set({**reading.draw(chance), "Timeout": "T#10s"})
        plc.scan()
    plc.set({"Execute": False})
    plc.scan(2)
    plc.set({**reading.draw(chance), "Timeout": "T#20s", "Execute": True})
    plc.scan()
    plc.set({"Execute": False})
    plc.scan()
    assert plc.shown == ["Busy"]
    plc["Rival.Execute"] = False
    plc.end()
    plc.answer(0)
    plc.scan_until(lambda: plc.words[0] != 0, most=4)
    assert plc.words == expected
    plc.scan_until(lambda: bool(plc.pin("Error")), most=12)
    assert plc.pin("ErrorID") == 0x8011


def test_an_edge_while_the_block_waits_is_ignored() -> None:
    """An edge of Execute while the block waits is ignored. Source: PLCopen, edge while Busy."""
    plc = bench_of("FB_ReadDate", "builtin")
    first = plc.send({})[0]
    for code, execute in ((0x0501, True), (0x0501, False), (0x0502, True), (0x0502, False)):
        plc["Rival.Code"], plc["Rival.Execute"] = code, execute
        plc.scan()
    assert (plc["Rival.Busy"], plc["Rival.Active"]) == (True, False)
    plc.set({"Execute": False})
    plc.end()
    plc.answer(0)
    plc.scan_until(lambda: plc.words[0] not in (0, first), most=4)
    assert plc.words[0] == 0x0501


@pytest.mark.parametrize("name", ["FB_ReadDate", "FB_ReadServoStatus", "FB_PalletMovePtp"])
def test_done_is_shown_for_one_scan_if_execute_has_fallen(name: str) -> None:
    """If Execute falls before the end, Done is TRUE for one scan.

    Source: design of the library, 3.
    """
    plc = bench_of(name, "builtin")
    plc.send({})
    plc.set({"Execute": False})
    plc.answer(0x0100, scans=2)
    plc.end()
    assert plc.shown == ["Done"]
    plc.scan()
    assert plc.shown == []


@pytest.mark.parametrize(
    ("name", "response", "expected"),
    [
        ("FB_ReadLatestAlarm", [1, 2, 0x8101, 0x8102], {"Place": "ALARM_PLACE_ROBOT"}),
        ("FB_ReadMessage", [1, 2, 0x8101, 0x8102], {"Detail": "ALARM_DETAIL_ALL"}),
        ("FB_ReadVariable", [0, 0xFFFF, 0, 7, 0], {"ValueInteger": 0, "ValueReal": 0.0}),
    ],
)
def test_an_unknown_value_in_the_answer_keeps_the_defaults(
    name: str, response: list[int], expected: Mapping[str, Value]
) -> None:
    """If the answer has a value that the guide does not list, the outputs keep their defaults.

    Source: remote command guide 4.4.1, 4.7.7 and 4.7.17.
    """
    plc = bench_of(name, "builtin")
    plc.exchange({}, response)
    assert plc.pins(expected) == expected


def test_an_abnormal_end_keeps_the_default_servo_states() -> None:
    """After an abnormal end, the servo states keep their defaults.

    The words of the answer are an alarm. Source: remote command guide 1.1, 0x4000.
    """
    plc = bench_of("FB_ReadServoStatus", "builtin")
    plc.send({})
    plc.end(0x4000, [1, 1, 2, 9, 1, 2, 9])
    assert plc.shown == ["Error"]
    assert plc.pin("ServoStates") == ["SERVO_STATE_BRAKE"] * 6


@pytest.mark.parametrize("name", [k for k in BLOCKS if "Push" in k or "DriveDirect" in k])
def test_a_direct_speed_of_less_than_a_hundredth_of_a_percent_is_refused(name: str) -> None:
    """A direct speed of 0.008 % is refused with 16#8042.

    Source: guide 4.2.3, 4.2.23: 0.01 to 100 %.
    """
    plc = bench_of(name, "builtin")
    plc.set({"SpeedMode": "SPEED_DIRECT", "Speed": 0.008, "Execute": True})
    plc.scan(2)
    assert plc.pin("ErrorID") == 0x8042


@pytest.mark.parametrize("name", ["FB_AssignValue"])
def test_a_real_without_an_effect_is_not_checked(name: str) -> None:
    """For an integer variable, ValueReal has no effect.

    Source: guide 4.4.1: SGI0 to SGI31 contain integers.
    """
    plc = bench_of(name, "builtin")
    words = plc.exchange({"Variable1": 3, "ValueInteger": 70000, "ValueReal": inf})
    assert words[2:6] == [3, 0, 0x1170, 1]
