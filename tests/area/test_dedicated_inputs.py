"""FB_RcxDedicatedInputs makes one change at a time.

The interval between two changes is 100 ms and a margin, here 120 ms, which are 12 scans.
"""

from __future__ import annotations

from random import Random

import pytest

from alone import Alone
from head_rules import OTHERS, SAFETY, InputRules, bits_of
from plc_bench import PlcBench
from shown import differences
from structured_text.engines.base import Value


def _changes(plc: PlcBench, scans: int) -> list[tuple[int, str]]:
    """Return each change in the written area: (time of the scan [ms], input with its new state)."""
    found: list[tuple[int, str]] = []
    before = set(plc.inputs)
    for _ in range(scans):
        at = plc.now_us // 1000
        plc.scan()
        now = set(plc.inputs)
        found += [(at, f"{name} {'ON' if name in now else 'OFF'}") for name in sorted(before ^ now)]
        before = now
    return found


def test_after_a_start_of_the_plc_the_inputs_come_one_at_a_time_after_the_interval() -> None:
    """Source: manual chapter 5, 3.1, caution: an interval of 100 ms or more."""
    plc = PlcBench()
    assert _changes(plc, 60) == [(120, "SI00 ON"), (240, "SI06 ON")]


def test_both_safety_inputs_stay_off_until_their_pins_are_true() -> None:
    """Source: design of the pins EmergencyStopOk and StopOk; chapter 5, 2, SI(00) and SI(06)."""
    plc = PlcBench()
    plc["EmergencyStopOk"] = plc["StopOk"] = False
    assert _changes(plc, 60) == []


def test_different_inputs_keep_the_interval_too() -> None:
    """Source: manual chapter 5, 3.1, caution: same or different dedicated inputs."""
    plc = PlcBench()
    plc.power_up()
    plc["ServoOn.Execute"] = True
    plc.outputs(SO02=True, SO14=True)
    plc["ProgramReset.Execute"] = True
    start = plc.now_us // 1000
    assert _changes(plc, 60) == [
        (start, "SI01 ON"),
        (start + 120, "SI01 OFF"),
        (start + 240, "SI15 ON"),
        (start + 360, "SI15 OFF"),
    ]


@pytest.mark.parametrize("pin", ["EmergencyStopOk", "StopOk"])
def test_a_safety_switch_off_goes_out_at_once_and_restarts_the_interval(pin: str) -> None:
    """Source: manual chapter 5, 2, SI(00) and SI(06): OFF stops; exempt from the interval."""
    name = {"EmergencyStopOk": "SI00", "StopOk": "SI06"}[pin]
    plc = PlcBench()
    plc.power_up()
    plc.change("ServoOn.Execute", to=True)
    assert "SI01" in plc.inputs
    plc.scan(5)
    plc.outputs(SO02=True)
    plc[pin] = False
    start = plc.now_us // 1000
    assert _changes(plc, 30) == [(start, f"{name} OFF"), (start + 120, "SI01 OFF")]
    plc[pin] = True
    start = plc.now_us // 1000
    assert _changes(plc, 1) == [(start, f"{name} ON")]


def test_both_safety_inputs_may_fall_together_but_not_rise_together() -> None:
    """SI(00) and SI(06) may turn OFF in the same scan, but turn ON one interval apart.

    Source: manual chapter 5, 3.1, caution: only switching OFF is exempt from the interval.
    """
    plc = PlcBench()
    plc.power_up()
    plc["EmergencyStopOk"] = plc["StopOk"] = False
    start = plc.now_us // 1000
    assert _changes(plc, 1) == [(start, "SI00 OFF"), (start, "SI06 OFF")]
    plc["EmergencyStopOk"] = plc["StopOk"] = True
    assert _changes(plc, 40) == [(start + 120, "SI00 ON"), (start + 240, "SI06 ON")]


@pytest.mark.parametrize(
    ("interval", "margin", "expected_ms"),
    [
        ("T#100ms", "T#20ms", 120),
        ("T#250ms", "T#20ms", 270),
        ("T#10ms", "T#20ms", 120),  # 100 ms is the minimum of the manual
        ("T#0s", "T#0s", 100),
    ],
)
def test_the_interval_is_a_parameter_but_never_below_100_ms(
    interval: Value, margin: Value, expected_ms: int
) -> None:
    """Source: manual chapter 5, 3.1, caution."""
    plc = PlcBench()
    plc["WriteArea.Interval"], plc["WriteArea.Margin"] = interval, margin
    found = _changes(plc, 60)
    assert [time for time, _ in found] == [expected_ms, 2 * expected_ms]


def test_the_default_margin_covers_an_rpi_of_100_ms_and_45_ms_of_jitter() -> None:
    """The default margin is 150 ms: one RPI of 100 ms, 45 ms of jitter, and a cycle of 5 ms.

    In the worst case, one change has this delay and the next change has none.
    """
    plc = PlcBench(margin=None)
    assert [time for time, _ in _changes(plc, 60)] == [250, 500]


def test_a_lost_link_turns_the_inputs_off_and_they_return_after_the_interval() -> None:
    """Source: manual chapter 1, 5.2: SI(00) and SI(06) turn off in the connection error state."""
    plc = PlcBench()
    plc.power_up()
    plc["Connected"] = False
    start = plc.now_us // 1000
    assert _changes(plc, 50) == [(start, "SI00 OFF"), (start, "SI06 OFF")]
    plc["Connected"] = True
    start = plc.now_us // 1000
    assert _changes(plc, 50) == [(start + 120, "SI00 ON"), (start + 240, "SI06 ON")]


def test_inputs_that_nobody_requests_any_more_are_withdrawn() -> None:
    plc = PlcBench()
    plc.power_up()
    plc.change("ServoOn.Execute", to=True)
    plc["CallServoOn"] = False
    start = plc.now_us // 1000
    assert _changes(plc, 20) == [(start + 110, "SI01 OFF")]


# --- the block alone, with random inputs ---


@pytest.fixture(scope="module")
def compiled() -> Alone:
    return Alone("FB_RcxDedicatedInputs", {"Robot": "RCX_REF"})


@pytest.fixture
def alone(compiled: Alone) -> Alone:
    compiled.restart()
    compiled["Block.Interval"], compiled["Block.Settling"] = "T#100ms", "T#170ms"
    return compiled


def test_a_request_is_not_sent_if_the_second_read_call_has_no_link(
    alone: Alone,
) -> None:
    """If the link is lost after SI(15) was requested, SI(15) stays OFF.

    The first call in the scan had a link, the second call had none.

    Source: manual chapter 1, 5.2.
    """
    alone["Robot.Connected"] = True
    for now in range(0, 300, 10):
        alone.scan(now)
    alone["Robot.Inner.Request"] = 0x2000
    alone["Robot.Connected"] = False
    alone.scan(300)
    assert alone["Robot.Inner.Applied"] == 0


@pytest.mark.parametrize("further", [0, 7, -7])
def test_after_missed_scans_the_interval_restarts(alone: Alone, further: int) -> None:
    """After missed scans the interval restarts, even if the scan number has wrapped after 65535.

    Source: manual chapter 5, 3, caution; head of the block.
    """
    alone["Robot.Connected"] = True
    alone["Robot.Inner.Scan"] = 100
    for now in range(0, 300, 10):
        alone.scan(now)
    alone["Robot.Inner.Scan"] = 130 + further
    for now in range(300, 420, 10):
        alone["Robot.Inner.Request"] = 0x2000
        alone.scan(now)
        sent = now >= (400 if further else 300)
        assert alone["Robot.Inner.Applied"] == (0x2000 if sent else 0x0000)


@pytest.mark.parametrize("seed", range(4))
def test_every_change_of_the_dedicated_inputs_follows_the_rules(alone: Alone, seed: int) -> None:
    """Source: manual chapter 5, 3, caution; design of the library, 2."""
    chance, rules = Random(seed), InputRules()
    now, connected = 0, True
    wanted = dict.fromkeys((*SAFETY, *OTHERS), False)
    #: Probability of a change of a request, from frequent changes to none for a long time.
    for rate in (0.01, 0.1, 0.003, 0.03):
        for _ in range(250):
            for name in wanted:
                if chance.random() < rate * (0.3 if name in SAFETY else 1):
                    wanted[name] = not wanted[name]
            connected ^= chance.random() < 0.01
            alone["Robot.Connected"] = connected
            alone["Robot.EmergencyStopOk"], alone["Robot.StopOk"] = (wanted[k] for k in SAFETY)
            alone["Robot.Inner.Request"] = bits_of({name: wanted[name] for name in OTHERS})
            alone.scan(now)
            rules.scan(now, wanted, connected, 100, 170)
            told = f"seed {seed}, {now} ms, wanted {[name for name in wanted if wanted[name]]}"
            inputs = alone["Robot.SI"]
            assert isinstance(inputs, dict)
            wrong = differences(
                (*rules.applied, "Applied", "Settled", "Request"),
                [*(inputs[name] for name in rules.applied)]
                + [
                    alone[f"Robot.{name}"] for name in ("Inner.Applied", "Settled", "Inner.Request")
                ],
                [*rules.applied.values(), bits_of(rules.applied), rules.settled, 0],
            )
            assert not wrong, f"FB_RcxDedicatedInputs, {told}: {wrong}"
            now += 10


@pytest.mark.parametrize(
    ("serving", "lowest", "next_ticket"),
    [(5, 5, 5), (5, 5, 6), (5, 6, 6), (5, 7, 8), (5, 8, 8), (65535, 65535, 0), (65534, 1, 3)],
)
def test_if_the_holder_is_not_called_the_channel_passes_to_the_next_block(
    alone: Alone, serving: int, lowest: int, next_ticket: int
) -> None:
    """Source: design of the library, 2: a holder that is no longer called loses the channel."""
    channel = {"Serving": serving, "NextTicket": next_ticket, "Lowest": lowest, "Holder": 0x12}
    alone["Robot.Inner.Sequence"] = channel
    alone.scan(0)
    found = alone["Robot.Inner.Sequence"]
    assert isinstance(found, dict)
    assert found["Serving"] == lowest
    assert found["Holder"] == (0x12 if serving == lowest else 0)
    assert found["NextTicket"] == next_ticket
    assert found["Lowest"] == next_ticket, "no block was called in the next scan"
