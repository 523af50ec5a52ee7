"""A process that sends no sign of life for 2 s is reported. The tests use virtual time."""

from __future__ import annotations

from rcx_harness.enip.cyclic.shared import Word
from rcx_harness.serve.stalls import Stalls
from rcx_harness.serve.watchdog import LIMIT_US, Watchdog
from served import ServedHost

_LOOK_US = 250_000
_SILENT, _BACK = Watchdog.Finding.SILENT, Watchdog.Finding.BACK
_STILL = "has given no sign of life for 2 s; it was stopped, or this computer is too busy"


def test_silence_is_reported_once_and_its_end_once() -> None:
    """The silence of a process is reported once, and its end is reported once.

    The process sends signs of life until 1 s, and again from 5 s on.
    """
    watchdog = Watchdog()
    found = {}
    for now_us in range(0, 6_000_000, _LOOK_US):
        heard_us = min(now_us, 1_000_000) if now_us < 5_000_000 else now_us
        if finding := watchdog.look(heard_us, now_us):
            found[now_us] = finding
    assert found == {3_000_000: _SILENT, 5_000_000: _BACK}
    assert LIMIT_US == 2_000_000


def test_a_process_that_has_not_begun_is_not_silent() -> None:
    watchdog = Watchdog()
    assert {watchdog.look(0, now_us) for now_us in range(0, 10_000_000, _LOOK_US)} == {None}


def test_after_the_computer_slept_no_process_is_reported() -> None:
    """If the computer has slept for an hour, no process is reported: their time limits restart."""
    watchdog = Watchdog()
    watchdog.look(1_000_000, 1_000_000)
    assert watchdog.look(1_000_000, 3_600_000_000) is None
    assert watchdog.look(3_600_100_000, 3_600_250_000) is None


def test_a_process_that_stays_silent_after_that_is_reported() -> None:
    watchdog = Watchdog()
    watchdog.look(1_000_000, 1_000_000)
    begin_us = 3_600_000_000
    found = [watchdog.look(1_000_000, begin_us + k * _LOOK_US) for k in range(9)]
    assert found == [None] * 8 + [_SILENT]


def test_a_stopped_process_is_reported_when_it_stops_and_when_it_goes_on() -> None:
    served = ServedHost()
    stalls = Stalls([served])
    said = {}
    for now_us in range(1_000_000, 8_000_000, _LOOK_US):
        if not 2_000_000 <= now_us < 6_000_000:
            served.run(250)
        for line in stalls.new(now_us):
            said[now_us] = line
        assert served.silent == (3_750_000 <= now_us < 6_000_000)
    assert said == {
        3_750_000: f"controller 127.0.0.1: its process {_STILL}",
        6_000_000: "controller 127.0.0.1: its process continues after 4.2 s",
    }


def test_a_process_of_the_adapter_that_is_stopped_is_named() -> None:
    """A stopped process of the adapter is named in the report.

    The controller reports it ten times a second. The other process continues.
    """
    served = ServedHost()
    stalls = Stalls([served])
    said = []
    for now_us in range(0, 8_000_000, 100_000):
        heard_us = served.now_us + 1
        served.network.heard[Word.ADAPTER_ALIVE] = heard_us
        if not 1_000_000 <= now_us < 6_000_000:
            served.network.heard[Word.CYCLIC_ALIVE] = heard_us
        served.run(100)
        said += stalls.new(now_us)
    assert said == [
        f"controller 127.0.0.1: the process of the cyclic I/O {_STILL}",
        "controller 127.0.0.1: the process of the cyclic I/O continues",
    ]
