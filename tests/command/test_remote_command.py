"""FB_RemoteCommand sends any code with 15 words, and shows 15 words of the answer or an error."""

from __future__ import annotations

from datetime import timedelta

import pytest

from plc_bench import PlcBench


def _plc() -> PlcBench:
    plc = PlcBench()
    plc.power_up()
    plc["First.Code"] = 0x1505
    return plc


def test_inputs_are_sampled_on_the_rising_edge() -> None:
    """Inputs that change while the block waits for the other command have no effect."""
    plc = _plc()
    plc["Second.Code"], plc["Second.Data[2]"] = 0x0101, 100
    plc.change("First.Execute", "Second.Execute", to=True)
    plc["Second.Code"], plc["Second.Data[2]"] = 0x0100, 200
    plc.scan_until(lambda: plc.words[0] == 0x1505)
    plc.complete()
    plc.scan_until(lambda: plc.words[0] != 0)
    assert plc.words[:3] == [0x0101, 0, 100]


def test_stored_inputs_change_only_at_a_rising_edge() -> None:
    """Stored inputs change only at a rising edge while the block is not Busy.

    Source: design of the library, 3.
    """
    plc = _plc()
    names = ("HeldCode", "HeldData", "Refused", "Job.Holder", "Job.Longest", "Job.Trouble")

    def held() -> dict[str, object]:
        return {name: plc[f"First.{name}"] for name in names}

    plc.change("First.Execute", to=True, scans=2)
    before = held()
    plc.change("First.Execute", to=False)
    plc["First.Code"], plc["First.Data[3]"], plc["First.Timeout"] = 0x0101, 7, timedelta(seconds=9)
    plc.change("First.Execute", to=True)
    assert held() == before, "an edge while Busy has no effect"
    plc.answer(0x0200, scans=1)
    for code in (0x0102, 0):
        plc.change("First.Code", to=code)
        assert plc["First.Done"]
        assert held() == before, "after Done"


def test_all_fifteen_words_are_sent_and_received() -> None:
    """The block sends n+2 to n+30 and shows m+2 to m+30. Source: guide chapter 1, 1.1."""
    plc = _plc()
    data = [0x0100 + k for k in range(1, 16)]
    response = [0xFF00 - k for k in range(1, 16)]
    plc["First.Data"] = data
    plc.change("First.Execute", to=True, scans=2)
    assert plc.words == [0x1505, *data]
    plc.answer(0x0200, response, scans=1)
    plc.answer(0, scans=5)
    assert plc["First.Response"] == response, "the response stays after the status reset"


@pytest.mark.parametrize("code", [0x0001, 0x1032, 0x250F, 0x3516, 0x4038, 0x4FFF, 0x0401, 0xF000])
def test_the_code_is_sent_without_a_change(code: int) -> None:
    """Any code is sent unchanged, also with illegal robot numbers in bits 15 to 12.

    Source: guide chapter 1, 1.1: command code in bits 11 to 0, robot number in bits 15 to 12.
    """
    plc = _plc()
    plc["First.Code"], plc["First.Execute"] = code, True
    plc.scan_until(lambda: plc.words[0] != 0, most=3)
    assert f"16#{plc.words[0]:04X}" == f"16#{code:04X}"
    # the code stays until a status arrives, even if other blocks request a command
    for _ in range(5):
        plc.scan()
        assert plc.words == [code, *[0] * 15]
    plc.answer(0x0200, scans=1)
    assert plc["First.Done"]


def test_an_abnormal_end_shows_alarm_group_and_category() -> None:
    """After an abnormal end, the block shows the alarm until Execute falls (here 2.334).

    Source: guide chapter 1, 1.1: 0x0002 in m + 2, 0x014E in m + 4.
    """
    plc = _plc()
    plc.change("First.Execute", to=True, scans=2)
    plc.answer(0x4000, [0x0002, 0x014E], scans=1)
    assert plc["First.ErrorID"] == 0x8020
    assert (plc["First.AlarmGroup"], plc["First.AlarmCategory"]) == (2, 334)
    plc.answer(0, scans=5)
    assert (plc["First.AlarmGroup"], plc["First.AlarmCategory"]) == (2, 334)
    plc.change("First.Execute", to=False)
    assert (plc["First.AlarmGroup"], plc["First.AlarmCategory"]) == (0, 0)
    assert plc["First.ErrorID"] == 0


def test_the_status_reset_is_no_command() -> None:
    """Code 0 is refused with 16#8021, and other commands are not blocked. Source: guide 4.1."""
    plc = _plc()
    plc["First.Code"] = 0
    plc.change("First.Execute", to=True, scans=2)
    assert plc["First.ErrorID"] == 0x8021
    assert plc.words == [0] * 16
    plc["Second.Code"] = 0x0501
    plc.change("Second.Execute", to=True, scans=2)
    assert plc.words[0] == 0x0501, "the channel is free"


def test_without_an_answer_the_response_is_zero() -> None:
    plc = _plc()
    plc.change("First.Execute", to=True, scans=2)
    plc.complete(0x0200, [7] * 15)
    plc.change("First.Execute", to=False)
    plc["First.Timeout"] = "T#50ms"
    plc.change("First.Execute", to=True, scans=7)
    assert plc["First.ErrorID"] == 0x8011
    assert plc["First.Response"] == [0] * 15


def test_if_the_controller_never_becomes_ready_nothing_is_sent() -> None:
    """If the controller never becomes ready, the block ends with 16#8015.

    Source: guide 1.2, 0x0000.
    """
    plc = _plc()
    plc.answer(0x0100)
    plc["First.Timeout"] = "T#500ms"
    plc.change("First.Execute", to=True, scans=51)
    assert plc["First.ErrorID"] == 0x8015
    assert plc.words == [0] * 16


def test_without_cpu_ok_a_command_is_refused() -> None:
    plc = _plc()
    plc.outputs(SO01=False)
    plc.change("First.Execute", to=True, scans=2)
    assert plc["First.ErrorID"] == 0x8002
    assert plc.words == [0] * 16


def test_an_abnormal_end_shows_the_words_of_its_response() -> None:
    """After an abnormal end, Response has all 15 words, for example a position.

    Source: guide 4.2.6.
    """
    plc = _plc()
    plc.change("First.Execute", to=True, scans=2)
    response = [12, 400, *range(1, 14)]
    plc.answer(0x4000, response, scans=1)
    assert plc["First.Response"] == response


def test_after_a_timeout_the_response_is_zero() -> None:
    """At a time-out, Response is 0, because words without an end status are not valid.

    Source: guide chapter 1, 1.1.
    """
    plc = _plc()
    plc["First.Timeout"], plc["First.Execute"] = "T#50ms", True
    plc.scan(2)
    plc.answer(0x0100, [7] * 15)
    plc.scan_until(lambda: bool(plc["First.Error"]), most=8)
    assert plc["First.ErrorID"] == 0x8011
    assert plc["First.Response"] == [0] * 15
