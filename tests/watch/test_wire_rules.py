"""Traces that break a rule of the wire are reported with this rule; similar legal traces are not.

The traces are scans as a PLC reads and writes them. Expected results follow from the manual:
chapter 5, 1 to 3 (dedicated inputs), guide chapter 1, 1.1 and 1.2 (remote commands).
"""

from __future__ import annotations

from typing import NamedTuple

import pytest

from rcx_harness.watch.wire import WireMonitor

#: Bits of the word at n+32, as chapter 5, 1 lists them.
SI00, SI01, SI06 = 1 << 0, 1 << 1, 1 << 6
SI10, SI12, SI14, SI15, SI16, SI17 = (1 << bit for bit in (8, 10, 12, 13, 14, 15))
READY, RUN, END, FAILED = 0x0000, 0x0100, 0x0200, 0x4000
MS = 1000


class Scan(NamedTuple):
    """The data that a scan reads and writes. All other bytes of the areas are zero.

    Attributes:
        ms: Time of the scan [ms].
        bits: The dedicated inputs, bytes n+32 and n+33 as a word.
        code: The command code, word n.
        data: Other bytes of the written area, by their offset.
        status: The status, word m, as the PLC has read it.
        cpu_ok: SO(01), as the PLC has read it.
        connected: The status of the PLC's scanner.
    """

    ms: float
    bits: int = 0
    code: int = 0
    data: dict[int, int] | None = None
    status: int = 0
    cpu_ok: bool = True
    connected: bool = True


def judge(*scans: Scan, size: int = 48) -> list[str]:
    """Return the monitor's reports as `ms rule: text`.

    The PLC has been connected for a while.
    """
    monitor = WireMonitor(size)
    return play(monitor, *scans, size=size)


def play(monitor: WireMonitor, *scans: Scan, size: int = 48) -> list[str]:
    found = []
    for number, scan in enumerate(scans):
        si, so = bytearray(size), bytearray(size)
        si[0:2] = scan.code.to_bytes(2, "little")
        si[32:34] = scan.bits.to_bytes(2, "little")
        for offset, value in (scan.data or {}).items():
            si[offset] = value
        so[0:2] = scan.status.to_bytes(2, "little")
        so[32] = 0x02 if scan.cpu_ok else 0
        t_us = round(scan.ms * MS)
        for one in monitor.scan(t_us, number, bytes(so), bytes(si), scan.connected):
            begin = f"plc, scan {number}: {one.rule}: "
            assert one.text.startswith(begin)
            assert one.t_us == t_us
            found.append(f"{scan.ms:g} {one.rule}: {one.text.removeprefix(begin)}")
    return found


def bits(*changes: tuple[float, int]) -> tuple[Scan, ...]:
    return tuple(Scan(ms, value) for ms, value in changes)


# --- interval ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "finding"),
    [
        (
            ((10, SI00), (109.999, SI00 | SI06)),
            "SI(06) ON only 99.999 ms after SI(00) ON; at least 100 ms",
        ),
        (((10, SI15), (60, 0)), "SI(15) OFF only 50 ms after SI(15) ON; at least 100 ms"),
        (((10, SI15), (120, 0), (170, SI16)), "SI(16) ON only 50 ms after SI(15) OFF; at least*"),
        (((10, SI00), (120, 0), (180, SI00)), "SI(00) ON only 60 ms after SI(00) OFF; at least*"),
        (((10, SI06), (120, 0), (180, SI06)), "SI(06) ON only 60 ms after SI(06) OFF; at least*"),
        (((10, SI15), (40, SI15 | SI00)), "SI(00) ON only 30 ms after SI(15) ON; at least*"),
        (((10, SI15 | SI16),), "SI(15) ON and SI(16) ON in one scan; one change at a time, *"),
        (((10, SI00 | SI06),), "SI(00) ON and SI(06) ON in one scan; one change*"),
        (((10, SI15), (110, SI16)), "SI(15) OFF and SI(16) ON in one scan; one change*"),
        (((10, SI00), (110, SI15)), "SI(00) OFF and SI(15) ON in one scan; one change*"),
        (
            ((10, SI06), (110, SI06 | SI15), (210, 0)),
            "SI(06) OFF and SI(15) OFF in one scan; one change*",
        ),
    ],
)
def test_two_changes_within_100_ms_break_only_the_interval_rule(
    changes: tuple[tuple[float, int], ...], finding: str
) -> None:
    """Source: manual chapter 5, 3, caution: 100 ms or more, for the same or different inputs."""
    found = judge(*bits((0, 0), *changes))
    assert len(found) == 1
    assert found[0].startswith(f"{changes[-1][0]:g} interval: {finding.rstrip('*')}")
    assert finding.endswith("*") or found[0].endswith(finding)


@pytest.mark.parametrize(
    "changes",
    [
        ((10, SI00), (110, SI00 | SI06), (210, SI00 | SI06 | SI01), (310, SI00 | SI06)),
        ((10, SI15), (110, 0), (210, SI16), (310, 0)),
        ((10, SI00), (20, SI00), (110, SI00 | SI06)),
    ],
)
def test_changes_100_ms_apart_break_nothing(changes: tuple[tuple[float, int], ...]) -> None:
    assert judge(*bits((0, 0), *changes)) == []


@pytest.mark.parametrize("safety", [SI00, SI06])
def test_switching_a_safety_input_off_is_exempt_but_restarts_the_interval(safety: int) -> None:
    """Switching a safety input OFF is exempt from the interval but restarts it.

    SI(15) changes 60 ms after the switch-off, which is too early, although its own last change was
    110 ms ago.

    Source: manual chapter 5, 3, caution: also between different dedicated inputs.
    """
    name = "SI(00)" if safety == SI00 else "SI(06)"
    before = ((0, 0), (10, safety), (110, safety | SI15), (160, SI15))
    assert judge(*bits(*before, (260, 0))) == []
    assert judge(*bits(*before, (220, 0))) == [
        f"220 interval: SI(15) OFF only 60 ms after {name} OFF; at least 100 ms"
    ]


def test_both_safety_inputs_may_go_off_at_once() -> None:
    on = ((0, 0), (10, SI00), (110, SI00 | SI06), (210, SI00 | SI06 | SI15))
    assert judge(*bits(*on, (220, SI15))) == []
    assert judge(*bits(*on, (220, SI15), (300, 0))) == [
        "300 interval: SI(15) OFF only 80 ms after SI(00) OFF and SI(06) OFF; at least 100 ms"
    ]
    assert judge(*bits(*on, (220, SI06 | SI15), (230, SI15), (330, 0))) == []


def test_no_interval_runs_through_a_lost_link() -> None:
    lost = Scan(20, SI00, connected=False)
    again = (Scan(30, SI00), Scan(40, SI00 | SI06))
    assert judge(Scan(0), Scan(10, SI00), lost, *again) == []
    assert len(judge(Scan(0), Scan(10, SI00), *again)) == 1


# --- start against stop ------------------------------------------------------------------------

STARTS = {"SI(12)": SI12, "SI(14)": SI14, "SI(17)": SI17}
WAIT = "wait until no stop is requested"


@pytest.mark.parametrize(("name", "bit"), STARTS.items())
def test_a_start_while_a_stop_input_is_off_breaks_its_own_rule(name: str, bit: int) -> None:
    """A start while a stop input is OFF breaks its own rule.

    The stop was requested long before, or in the scan of the start.

    Source: manual chapter 5, 3.2: not executed if emergency stop or stop input are OFF.
    """
    both = SI00 | SI06
    on = ((0, 0), (100, SI00), (200, both))
    rule = f"start against stop: {name} ON while"
    assert judge(*bits(*on, (300, both | bit))) == []
    assert judge(*bits((0, 0), (100, SI00), (200, SI00 | bit))) == [
        f"200 {rule} SI(06) is OFF; {WAIT}"
    ]
    assert judge(*bits((0, 0), (100, SI06), (200, SI06 | bit))) == [
        f"200 {rule} SI(00) is OFF; {WAIT}"
    ]
    assert judge(*bits((0, 0), (200, bit))) == [f"200 {rule} SI(00) and SI(06) are OFF; {WAIT}"]
    assert judge(*bits(*on, (300, SI00), (400, SI00 | bit))) == [
        f"400 {rule} SI(06) is OFF; {WAIT}"
    ]
    assert [text.split(":")[0] for text in judge(*bits(*on, (300, SI00 | bit)))] == [
        "300 start against stop",
        "300 interval",
    ]


def test_servo_on_needs_the_emergency_stop_input_only() -> None:
    """Source: manual chapter 5, 2, SI(01)."""
    assert judge(*bits((0, 0), (100, SI00), (200, SI00 | SI01))) == []
    assert judge(*bits((0, 0), (100, SI06), (200, SI06 | SI01))) == [
        f"200 start against stop: SI(01) ON while SI(00) is OFF; {WAIT}"
    ]


@pytest.mark.parametrize("bit", [SI10, SI15, SI16])
def test_inputs_that_start_no_movement_may_come_in_a_stop(bit: int) -> None:
    assert judge(*bits((0, 0), (100, bit), (200, 0))) == []


def test_a_stop_after_a_start_and_a_start_that_stays_are_no_starts_against_it() -> None:
    both = SI00 | SI06
    on = ((0, 0), (100, SI00), (200, both), (300, both | SI12))
    assert judge(*bits(*on, (310, SI00 | SI12), (410, SI12), (510, 0))) == []


# --- reserved ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("byte", "bit"), [(32, 2), (32, 3), (32, 4), (32, 5), (32, 7), (33, 1), (33, 3)]
)
def test_each_reserved_bit_is_reported_when_it_turns_on(byte: int, bit: int) -> None:
    """A reserved bit is reported when it turns ON. It does not affect the interval.

    Turning it OFF breaks no rule.

    Source: manual chapter 5, 1, note 1.
    """
    mask = 1 << bit + 8 * (byte - 32)
    text = f"60 reserved: the reserved bit (n+{byte}) {bit} was set; it must stay OFF"
    scans = bits(
        (0, 0), (10, SI00), (60, SI00 | mask), (70, SI00 | mask), (110, SI06 | SI00 | mask)
    )
    assert judge(*scans, Scan(130, SI06 | SI00)) == [text]


@pytest.mark.parametrize("byte", [46, 47])
def test_each_reserved_byte_is_reported_when_it_changes(byte: int) -> None:
    """Source: manual chapter 5, 1, note 1."""
    one, two = Scan(10, data={byte: 1}), Scan(30, data={byte: 0x80})
    shown = {46: ("01 00", "80 00"), 47: ("00 01", "00 80")}[byte]
    assert judge(Scan(0), one, one._replace(ms=20), two, Scan(40)) == [
        f"10 reserved: the reserved bytes n+46, n+47 became {shown[0]}",
        f"30 reserved: the reserved bytes n+46, n+47 became {shown[1]}",
    ]


def test_general_purpose_bytes_may_be_anything_at_any_time() -> None:
    full = dict.fromkeys((*range(34, 46), *range(48, 256)), 255)
    scans = (Scan(0), Scan(10, data=full), Scan(20), Scan(30, data=full))
    assert judge(*scans, size=256) == []


# --- remote commands ---------------------------------------------------------------------------


@pytest.mark.parametrize("byte", range(2, 32))
def test_each_data_byte_must_be_written_a_scan_before_the_code(byte: int) -> None:
    """Source: guide chapter 1, 1.1, note."""
    data = {byte: 1}
    assert judge(Scan(0), Scan(10, data=data), Scan(20, code=1, data=data)) == []
    assert judge(Scan(0), Scan(10, code=1, data=data)) == [
        f"10 data before code: n+{byte & ~1} changed together with the code 16#0001; "
        "data must be there one scan before"
    ]


HELD = "held until 16#0200 or 16#4000 is read"


@pytest.mark.parametrize("status", [READY, RUN])
def test_code_and_data_are_held_until_the_end(status: int) -> None:
    """Source: guide chapter 1, 1.1, note."""
    out = (Scan(0, data={4: 7}), Scan(10, code=0x0101, data={4: 7}))
    under = (*out, Scan(20, code=0x0101, data={4: 7}, status=status))
    gone = Scan(30, code=0, data={4: 7}, status=status)
    shown = f"while the status read was 16#{status:04X}; {HELD}"
    assert judge(*under, gone) == [
        f"30 command held: the code changed from 16#0101 to 16#0000 {shown}"
    ]
    assert judge(*under, gone._replace(code=0x0101, data={4: 8})) == [
        f"30 command held: n+4 changed with the code 16#0101 out {shown}"
    ]
    assert judge(*under, gone._replace(code=0x0101, data={4: 7, 31: 1})) == [
        f"30 command held: n+30 changed with the code 16#0101 out {shown}"
    ]
    assert judge(*under, gone._replace(code=0x0102)) == [
        f"30 command held: the code changed from 16#0101 to 16#0102 {shown}"
    ]


@pytest.mark.parametrize("end", [END, FAILED])
def test_after_its_end_a_command_may_be_withdrawn_in_that_scan_or_later(end: int) -> None:
    """After its end was read, a command may be withdrawn in this scan or later.

    The next status may already differ. Each end applies to one command.
    """
    out = (Scan(0), Scan(10, code=0x0101), Scan(20, code=0x0101, status=RUN))
    assert judge(*out, Scan(30, status=end)) == []
    held = Scan(30, code=0x0101, status=end)
    for status in (end, RUN, READY):
        assert judge(*out, held, held._replace(ms=40), Scan(50, status=status)) == []
    assert judge(*out, held, held._replace(ms=40, data={2: 1})) == []
    monitor = WireMonitor()
    play(monitor, *out, held, held._replace(ms=40), Scan(50, status=end), Scan(60))
    play(monitor, *out[1:], Scan(30, status=END))
    assert monitor.commands == 2


def test_a_command_withdrawn_before_its_end_is_not_counted() -> None:
    """A command that is withdrawn before its end is not counted, even if its end is read later."""
    monitor = WireMonitor()
    out = (Scan(0), Scan(10, code=0x0101), Scan(20, code=0x0101, status=RUN))
    play(monitor, *out, Scan(30, status=RUN), Scan(40, status=END), Scan(50))
    assert monitor.commands == 0


@pytest.mark.parametrize("status", [READY, RUN])
def test_the_end_of_an_earlier_command_does_not_release_the_next(status: int) -> None:
    """The end of an earlier command does not end the hold of the next command."""
    before = (Scan(0), Scan(10, code=0x0101), Scan(15, code=0x0101, status=status))
    after = (*before, Scan(20, status=END), Scan(30), Scan(40, code=0x0102))
    assert judge(*after, Scan(50)) == [
        f"50 command held: the code changed from 16#0102 to 16#0000 while the status read was "
        f"16#0000; {HELD}"
    ]


def test_a_lost_command_may_be_withdrawn() -> None:
    """A lost command may be withdrawn: CPU_OK turned OFF, or the status 0x0100 became 0x0000.

    Source: guide chapter 1, 1.2.
    """
    out = (Scan(0), Scan(10, code=0x0101), Scan(20, code=0x0101, status=RUN))
    assert judge(*out, Scan(30, status=READY)) == []
    assert judge(*out, Scan(30, status=RUN, cpu_ok=False)) == []
    assert len(judge(*out, Scan(30, status=RUN))) == 1
    assert len(judge(Scan(0), Scan(10, code=0x0101), Scan(30, status=READY))) == 1


@pytest.mark.parametrize("code", [0x0505, 0x0506, 0x1505, 0x4506])
def test_only_a_running_continuous_output_may_be_ended_by_the_status_reset(code: int) -> None:
    """Source: guide 4.7.4."""
    on = {2: 1}
    out = (Scan(0, data=on), Scan(10, code=code, data=on))
    running = Scan(20, code=code, data=on, status=RUN)
    assert judge(*out, running, Scan(30, data=on, status=RUN)) == []
    assert len(judge(*out, Scan(30, data=on, status=READY))) == 1, "not begun"
    once = (Scan(0), Scan(10, code=code), running._replace(data=None))
    assert len(judge(*once, Scan(30, status=RUN))) == 1, "not continuous"
    other = (Scan(0, data=on), Scan(10, code=0x0507, data=on), running._replace(code=0x0507))
    assert len(judge(*other, Scan(30, data=on, status=RUN))) == 1, "another command"


@pytest.mark.parametrize("status", [RUN, END, FAILED])
def test_a_code_may_be_sent_only_at_status_0000(status: int) -> None:
    """Source: guide chapter 1, 1.2, code 0x0000."""
    text = f"the code 16#0001 went out while the status read was 16#{status:04X}; expected 16#0000"
    assert judge(Scan(0), Scan(10, code=1)) == []
    assert judge(Scan(0), Scan(10, code=1, status=status)) == [f"10 ready before code: {text}"]


@pytest.mark.parametrize("data", [None, {4: 1}])
def test_a_code_that_follows_another_without_the_reset_is_not_ready(
    data: dict[int, int] | None,
) -> None:
    """A code that follows another one without a status reset breaks the rule "ready before code".

    Code and data may change after the end, but the code must be 0 first.

    Source: guide chapter 2, steps 5 and 6.
    """
    out = (Scan(0), Scan(10, code=0x0101), Scan(20, code=0x0101, status=END))
    text = "the code 16#0102 went out while the status read was 16#0200; expected 16#0000"
    following = Scan(30, code=0x0102, data=data, status=END)
    assert judge(*out, following) == [f"30 ready before code: {text}"]


def test_a_code_that_was_out_before_the_link_came_is_not_judged() -> None:
    early = Scan(0, code=0x0101, connected=False)
    monitor = WireMonitor()
    there = early._replace(ms=10, connected=True)
    found = play(monitor, early, there, there._replace(ms=20, status=END), Scan(30, status=END))
    assert (found, monitor.commands) == ([], 0)


def test_writes_in_the_scan_of_a_loss_or_recovery_are_not_judged() -> None:
    away = Scan(10, SI15 | SI16 | 4, data={46: 1}, connected=False)
    assert judge(Scan(0), away) == []
    assert judge(Scan(0), Scan(5, connected=False), away._replace(connected=True)) == []
    assert len(judge(Scan(0), away._replace(connected=True))) == 3


def test_a_monitor_goes_back_to_its_snapshot() -> None:
    monitor = WireMonitor()
    play(monitor, Scan(0), Scan(10, SI00))
    before = monitor.snapshot()
    for _ in range(2):
        monitor.restore(before)  # type: ignore[arg-type]
        assert len(play(monitor, Scan(50, SI00 | SI06))) == 1
