"""An Opener opens a connection again after each loss, and reports refusals with a remedy."""

from __future__ import annotations

import threading

import pytest

from fake_scanner import FakeScanner
from rcx_harness.enip.errors import CipError, EnipError
from rcx_harness.enip.originator.opening import Opener, multiplier_of, refusal_hint
from structured_text.errors import InputError

SCAN = ("--write", "--listen-only", "--heartbeat", "--input-instance", "--config-data")
BRIDGE = ("--size", "--rpi")


class Bench:
    """A simulated scanner and its Opener. The bench counts how often a connection is opened."""

    def __init__(self, first_s: float | None = None) -> None:
        self.scanner = FakeScanner()
        self.openings = 0
        self.refused = False
        self.opener = Opener(self.opened, first_s)

    def opened(self) -> FakeScanner:
        """Count an opening, and return the scanner or fail."""
        self.openings += 1
        if self.refused:
            raise EnipError("nobody there")
        return self.scanner


def test_a_new_connection_is_opened_once() -> None:
    bench = Bench()
    assert bench.opener.keep()
    assert bench.opener.keep()
    assert bench.openings == 1
    assert bench.opener.scanner is bench.scanner


def test_an_unwanted_connection_is_not_opened() -> None:
    bench = Bench()
    bench.opener.wanted = False
    assert bench.opener.keep()
    assert bench.openings == 0


def test_a_failed_attempt_has_a_reason_until_the_next_success() -> None:
    bench = Bench()
    bench.refused = True
    assert not bench.opener.keep()
    assert bench.opener.reason == "nobody there"
    bench.refused = False
    assert bench.opener.keep()
    assert bench.opener.reason == ""


@pytest.mark.parametrize(("first_s", "openings"), [(None, 1), (1e9, 1), (0.0, 3)])
def test_the_opener_waits_for_the_first_packet_for_the_given_time(
    first_s: float | None, openings: int
) -> None:
    """If no packet arrives within the given time, the Opener opens the connection again.

    The default time is the time-out that the scanner reports.
    """
    bench = Bench(first_s)
    for _ in range(3):
        bench.opener.keep()
    assert bench.openings == openings


def test_a_connection_with_packets_is_not_opened_again() -> None:
    bench = Bench(0.0)
    bench.scanner.connected = True
    for _ in range(3):
        bench.opener.keep()
    assert bench.openings == 1


def test_a_connection_that_was_unwanted_is_opened_again() -> None:
    """If a connection was unwanted for a while, it is opened again without a wait for packets.

    In the meantime the adapter was off, so the first packet would never arrive.
    """
    bench = Bench(1e9)
    for wanted in (True, False, True):
        bench.opener.wanted = wanted
        bench.opener.keep()
    assert bench.openings == 2


def test_a_thread_keeps_the_connection_open_until_its_end_is_called() -> None:
    bench = Bench()
    opened, died = threading.Event(), threading.Event()
    bench.opener = Opener(lambda: opened.set() or bench.opened())  # type: ignore[func-returns-value]
    bench.opener.start(0.0, on_died=died.set)
    assert opened.wait(60)
    bench.opener.end()
    bench.opener.end()
    assert not died.is_set()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_thread_that_ends_by_itself_is_reported() -> None:
    died = threading.Event()

    def failing() -> FakeScanner:
        raise SystemExit

    opener = Opener(failing)
    opener.start(0.0, on_died=died.set)
    assert died.wait(60)
    opener.end()


@pytest.mark.parametrize(
    ("extended", "options", "hint"),
    [
        ((0x106,), BRIDGE, "another master owns the robot: disconnect that master first"),
        (
            (0x106,),
            SCAN,
            "another master owns the robot: disconnect that master first, or leave --write out",
        ),
        ((0x107,), BRIDGE, "the adapter has already closed the connection"),
        ((0x109,), BRIDGE, "its areas have another size: try --size 256"),
        ((0x127,), SCAN, "its areas have another size: try --size 256"),
        ((0x128,), SCAN, "its areas have another size: try --size 256"),
        ((0x111,), BRIDGE, "try --rpi 10ms"),
        ((0x112,), SCAN, "try --rpi 10ms"),
        (
            (0x112, 0x0200, 5_000, 0, 20_000, 0),
            BRIDGE,
            "the shortest interval that the device accepts is 20 ms; try --rpi 20ms",
        ),
        ((0x119,), SCAN, "no other connection is open; leave --listen-only out"),
        ((0x12A,), SCAN, "it has a different heartbeat connection point; name it with --heartbeat"),
    ],
)
def test_a_refusal_with_a_remedy_has_the_same_hint_everywhere(
    extended: tuple[int, ...], options: tuple[str, ...], hint: str
) -> None:
    """For each refusal code with a remedy, the hint names the options of the command.

    The codes are from CIP volume 1, chapter 3, 5.6. A refusal with 0x112 contains the accepted
    interval of each direction.
    """
    assert refusal_hint(CipError("x", 1, extended), 48, options) == hint


@pytest.mark.parametrize("extended", [(), (0x315,), (0x126,), (0x129,), (0x12A,), (0x12B,)])
def test_no_hint_names_an_option_that_the_command_does_not_have(extended: tuple[int, ...]) -> None:
    assert refusal_hint(CipError("x", 1, extended), 48, BRIDGE) == ""


def test_for_other_devices_the_hint_names_the_eds_file() -> None:
    hint = "its EDS file has the sizes; give them with --input-size and --output-size"
    assert refusal_hint(CipError("x", 1, (0x128,)), 64, SCAN) == hint


@pytest.mark.parametrize(
    ("timeout_us", "coded"), [(1, 0), (40_000, 0), (40_001, 1), (320_000, 3), (5_120_000, 7)]
)
def test_the_multiplier_gives_at_least_the_time_out(timeout_us: int, coded: int) -> None:
    """The chosen multiplier is the smallest of 4, 8, ... 512 that gives at least the time-out."""
    assert multiplier_of(timeout_us, 10_000) == coded


def test_a_time_out_beyond_512_intervals_is_bad_input() -> None:
    with pytest.raises(InputError, match=r"6000 ms cannot be requested; .* 5120 ms"):
        multiplier_of(6_000_000, 10_000)
