"""Recordings of a PLC and a controller are judged: rules, response times and a summary."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from captures import Story, area, pcap
from rcx_harness.look.judge.judge import Judgement, JudgeOptions, judge
from rcx_harness.look.judge.text import as_json, summary
from rcx_harness.trace.chart import text_chart
from structured_text.errors import InputError

#: Bytes 32 and 33 to the PLC: CPU_OK, MP RDY, AUTO mode; also with servos on, and in emergency
#: stop.
IDLE, SERVO = 0x0112, 0x0116
MS = 1_000


class Recording:
    """A recording of a PLC and a controller, built change by change.

    Between two changes, both areas are repeated every 10 ms.
    """

    def __init__(self) -> None:
        self.story = Story()
        self.story.open(0)
        self._si, self._so = area(), area(dedicated=IDLE)
        self._now_us = 0
        self.skipped: tuple[str, ...] = ()
        self.until(10 * MS)

    def until(self, end_us: int) -> None:
        """Add packets with the current areas until this time [us]."""
        while self._now_us < end_us:
            self._now_us += 10 * MS
            self.story.both(self._now_us, self._si, self._so)

    def plc(self, at_us: int, dedicated: int, words: dict[int, int] | None = None) -> None:
        """Change the area that the PLC sends, from this time on."""
        self.until(at_us - 10 * MS)
        self._si = area(words, dedicated)
        self.until(at_us)

    def robot(self, at_us: int, dedicated: int, words: dict[int, int] | None = None) -> None:
        """Change the area that the controller sends, from this time on.

        A packet of the controller follows a packet of the PLC by 0.5 ms.
        """
        self.until(at_us - 10 * MS)
        self._so = area(words, dedicated)
        self.until(at_us)


class Verdict:
    """The result of `rcx judge` for a recording."""

    def __init__(self, folder: Path, made: Recording | Story, **options: object) -> None:
        story = made.story if isinstance(made, Recording) else made
        file = pcap(folder / "told.pcap", story.frames())
        self.lines: list[str] = []
        chosen = JudgeOptions(file, **options)  # type: ignore[arg-type]
        self.result: Judgement = judge(chosen, self.lines.append)

    @property
    def rules(self) -> list[str]:
        """Return the names of the broken rules, in the order of the findings."""
        return [one.rule for one in self.result.findings]

    @property
    def text(self) -> str:
        """Return the texts of all findings."""
        return "\n".join(one.text for one in self.result.findings)

    def times(self, what: str) -> tuple[int, int, int]:
        """Return count, median and maximum of the response times with this label."""
        found = self.result.followers[1].times[what]
        return found.count, found.percentile_us(0.5), found.longest_us


def _powered() -> Recording:
    """Return a recording with SI(00) ON at 200 ms, SI(06) at 400 ms and SI(01) at 600 ms.

    The servos are on at 650 ms.
    """
    made = Recording()
    made.plc(200 * MS, 0x01)
    made.plc(400 * MS, 0x41)
    made.plc(600 * MS, 0x43)
    made.robot(650 * MS, SERVO)
    made.plc(800 * MS, 0x41)
    return made


def _moved(made: Recording, at_us: int = 1_000 * MS) -> None:
    """Add a PTP movement to point 19: data, code, run after 20 ms, end 300 ms later, reset."""
    data = {8: 19}
    made.plc(at_us - 20 * MS, 0x41, data)
    made.plc(at_us, 0x41, {0: 1, **data})
    made.robot(at_us + 20 * MS, SERVO, {0: 0x0100})
    made.robot(at_us + 320 * MS, SERVO, {0: 0x0200})
    made.plc(at_us + 340 * MS, 0x41, data)
    made.robot(at_us + 350 * MS, SERVO)
    made.until(at_us + 400 * MS)


def test_a_good_start_and_a_good_movement_break_no_rule(tmp_path: Path) -> None:
    """Source: manual chapter 5, 3.1; guide 2, the example of a movement to point 19."""
    made = _powered()
    _moved(made)
    verdict = Verdict(tmp_path, made)
    assert verdict.rules == []
    told = [line[16:] for line in verdict.lines[2:]]
    assert told == ["SO(01) ON   CPU_OK status output", "SO(04) ON   MP RDY status output",
                    "SO(10) ON   AUTO mode status output", "SI(00) ON   Emergency stop input",
                    "SI(06) ON   Stop input", "SI(01) ON   Servo ON input",
                    "SO(02) ON   Servo ON status output", "SI(01) OFF  Servo ON input",
                    "MovePtp (16#R001): MOVE, PTP, point designation; point 19",
                    "  running, 20.5 ms after the code", "  normal end, 300 ms later",
                    "  ready, 10.5 ms after the reset"]  # fmt: skip


def test_response_times_are_those_of_the_packets(tmp_path: Path) -> None:
    """Response times are measured between packets, here 20.5, 300 and 10.5 ms for each movement.

    They are the times to status 16#0100, to the end, and of the reset. The controller sends half a
    millisecond after the PLC.
    """
    made = _powered()
    _moved(made)
    _moved(made, 2_000 * MS)
    verdict = Verdict(tmp_path, made)
    assert verdict.times("SI(01) ON: SO(02) ON") == (1, 50_500, 50_500)
    assert verdict.times("all commands: accepted") == (2, 20_500, 20_500)
    assert verdict.times("MovePtp: accepted") == (2, 20_500, 20_500)
    assert verdict.times("MovePtp: ran") == (2, 300_000, 300_000)
    assert verdict.times("MovePtp: from code to end") == (2, 320_500, 320_500)
    assert verdict.times("MovePtp: reset") == (2, 10_500, 10_500)
    assert set(verdict.result.followers[1].times) == {
        "SI(01) ON: SO(02) ON",
        *(f"{who}: {what}" for who in ("all commands", "MovePtp")
          for what in ("accepted", "ran", "from code to end", "reset")),
    }  # fmt: skip


def test_each_dedicated_answer_is_timed_and_missing_answers_are_counted(tmp_path: Path) -> None:
    """Each answer to a dedicated input has a response time; a missing answer is counted.

    The emergency stop switches SO(00), SO(03) and SO(02). A reset follows, and a start without an
    answer.

    Source: manual chapter 5, 3.1 and 3.2.
    """
    made = _powered()
    made.plc(1_000 * MS, 0x40)
    made.robot(1_010 * MS, 0x011B)
    made.plc(1_200 * MS, 0x41)
    made.robot(1_230 * MS, 0x011A)
    made.plc(1_400 * MS, 0x4041)
    made.robot(1_440 * MS, 0x0112)
    made.plc(1_600 * MS, 0x0041)
    made.plc(1_800 * MS, 0x0441)
    made.until(2_000 * MS)
    verdict = Verdict(tmp_path, made)
    assert verdict.times("SI(00) OFF: SO(00) ON") == (1, 10_500, 10_500)
    assert verdict.times("SI(00) OFF: SO(02) OFF") == (1, 10_500, 10_500)
    assert verdict.times("SI(00) ON: SO(00) OFF") == (1, 30_500, 30_500)
    assert verdict.times("SI(16) ON: SO(03) OFF") == (1, 40_500, 40_500)
    assert verdict.result.followers[1].times["SI(12) ON: SO(13) ON"].open == 1
    assert verdict.rules == []


#: Changes of PLC or controller: time [ms], dedicated bits, and words by their byte position.
Change = tuple[str, int, int, dict[int, int]]
_RUN, _END, _ABNORMAL = {0: 0x0100}, {0: 0x0200}, {0: 0x4000, 2: 12, 4: 600}
_OUT = ("plc", 1_000, 0x41, {0: 1})
_ENDED = ("robot", 1_020, SERVO, _END)

#: Maps a name to events from 1 s on, the rule that they break, and text of the finding.
_BROKEN: dict[str, tuple[list[Change], str, str]] = {
    "an edge after 90 ms": ([("plc", 1_000, 0x8041, {}), ("plc", 1_090, 0x41, {})], "interval",
                            "plc, packet 219: interval: SI(17) OFF only 90 ms after SI(17) ON"),
    "two edges at once": ([("plc", 1_000, 0xA041, {})], "interval",
                          "SI(15) ON and SI(17) ON in one scan"),
    "a reserved bit": ([("plc", 1_000, 0x45, {})], "reserved", "reserved bit (n+32) 2 was set"),
    "a reserved byte": ([("plc", 1_000, 0x41, {46: 1})], "reserved",
                        "the reserved bytes n+46, n+47 became 01 00"),
    "a start against the stop": ([("plc", 1_000, 0x01, {}), ("plc", 1_200, 0x0401, {})],
                                 "start against stop", "SI(12) ON while SI(06) is OFF"),
    "a code taken back": ([_OUT, ("robot", 1_020, SERVO, _RUN), ("plc", 1_100, 0x41, {})],
                          "command held", "the code changed from 16#0001 to 16#0000"),
    "data changed": ([_OUT, ("plc", 1_020, 0x41, {0: 1, 8: 5})], "command held",
                     "n+8 changed with the code 16#0001 out"),
    "a code before the ready status": ([_OUT, _ENDED, ("plc", 1_040, 0x41, {}),
                                        ("plc", 1_060, 0x41, {0: 2})], "ready before code",
                                       "the code 16#0002 went out while the status read was"),
    "an unknown status": ([_OUT, ("robot", 1_020, SERVO, {0: 0x0300})], "status",
                          "robot, packet 206: status: the status went from 16#0000 to"),
    "a status without a command": ([("robot", 1_020, SERVO, _RUN)], "status",
                                   "to 16#0100 without a remote command"),
    "an end without a reset": ([_OUT, _ENDED, ("robot", 1_040, SERVO, {})], "status",
                               "although the code 16#0001 is still set"),
    "two ends": ([_OUT, _ENDED, ("robot", 1_040, SERVO, _ABNORMAL)], "status",
                 "after an end only 16#0000 may follow"),
    "a run without an end": ([_OUT, ("robot", 1_020, SERVO, _RUN), ("robot", 1_040, SERVO, {})],
                             "status", "without an end, and no code was changed"),
    "a late response": ([_OUT, _ENDED, ("robot", 1_040, SERVO, {0: 0x0200, 4: 7})], "response",
                        "words changed after the status 16#0200"),
    "a reserved output": ([("robot", 1_000, SERVO | 0x20, {})], "reserved",
                          "reserved bits of m+32 are set: 2#00100000"),
    "a reserved output byte": ([("robot", 1_000, SERVO, {46: 0x0100})], "reserved",
                               "the reserved bytes m+46, m+47 are 00 01"),
}  # fmt: skip


def _recorded(name: str, until_us: int = 0) -> Recording:
    """Return a recording with the events of this name. The servos are on from the start."""
    made = _powered()
    for side, at_ms, dedicated, words in _BROKEN[name][0]:
        (made.plc if side == "plc" else made.robot)(at_ms * MS, dedicated, words)
    made.until(until_us)
    return made


@pytest.mark.parametrize("name", _BROKEN)
def test_each_rule_of_both_sides_is_judged(tmp_path: Path, name: str) -> None:
    """Every broken rule of PLC and controller is found, at the packet that breaks it.

    At the time 10 k ms, packet 2 k + 1 is of the PLC and packet 2 k + 2 of the controller.

    Source: manual chapter 5, 1, 2 and 3 (caution); guide 1.1, 1.2, 2 and 4.1.
    """
    verdict = Verdict(tmp_path, _recorded(name, 2_200 * MS))
    assert verdict.rules == [_BROKEN[name][1]]
    assert _BROKEN[name][2] in verdict.text
    assert any(f"** {verdict.text}" in line for line in verdict.lines)


@pytest.mark.parametrize(
    ("gap_us", "tolerance_us", "found"),
    [
        (99_500, 1_000, []),
        (98_900, 1_000, ["interval"]),
        (99_500, 0, ["interval"]),
        (100_000, 0, []),
    ],
)
def test_the_interval_is_judged_with_a_tolerance(
    tmp_path: Path, gap_us: int, tolerance_us: int, found: list[str]
) -> None:
    """An interval below 100 ms is reported only if the difference exceeds the tolerance.

    The clock of a capture differs from the clock of the PLC. Source: manual chapter 5, 3, caution.
    """
    made = _powered()
    made.plc(1_000 * MS, 0x8041)
    made.until(1_090 * MS)
    made.story.to_robot(1_000 * MS + gap_us, area(dedicated=0x41))
    assert Verdict(tmp_path, made, tolerance_us=tolerance_us).rules == found


@pytest.mark.parametrize(
    "name", ["an edge after 90 ms", "a code taken back", "an end without a reset"]
)
def test_no_rule_is_judged_across_missing_packets(tmp_path: Path, name: str) -> None:
    """If packets are missing, no rule is checked between the packets before and after the gap."""
    made = _recorded(name, 2_200 * MS)
    made.story.packets = [
        (t_us, data)
        for k, (t_us, data) in enumerate(made.story.packets)
        if not (t_us > 900 * MS and k // 2 % 2)
    ]
    verdict = Verdict(tmp_path, made)
    assert verdict.rules == []
    assert verdict.result.followers[1].gaps >= 2
    assert any("no rule was checked there" in line for line in summary(verdict.result))


def test_a_missing_packet_without_a_change_hides_no_fault(tmp_path: Path) -> None:
    """A fault is found although packets without a change are missing.

    SI(17) is ON for 90 ms. Every second packet of that time is missing.
    """
    made = _recorded("an edge after 90 ms")
    changed = (1_000 * MS, 1_010 * MS, 1_080 * MS, 1_090 * MS)
    made.story.packets = [
        (t_us, data)
        for t_us, data in made.story.packets
        if t_us < 900 * MS or t_us // MS in [one // MS for one in changed] or t_us // (10 * MS) % 2
    ]
    verdict = Verdict(tmp_path, made)
    assert verdict.result.followers[1].gaps == 0
    assert verdict.rules == ["interval"]


def test_data_that_come_with_their_code_are_noted(tmp_path: Path) -> None:
    """If data and code change in the same packet, the output notes that their order is unknown.

    Data must come one scan before the code (guide 1.1), but the interval of packets may be
    longer.
    """
    made = _powered()
    made.plc(1_000 * MS, 0x41, {0: 1, 8: 19})
    made.until(1_100 * MS)
    verdict = Verdict(tmp_path, made)
    assert verdict.rules == []
    assert verdict.result.followers[1].together == 1
    assert "  1 times new data arrived with the code, so their order is unknown" in list(
        summary(verdict.result)
    )


def test_an_abnormal_end_is_shown_with_its_alarm(tmp_path: Path) -> None:
    """An abnormal end is shown with its alarm: group in m+2, category in m+4.

    12.600 is the emergency stop (guide 1.2).
    """
    made = _powered()
    made.plc(1_000 * MS, 0x41, {0: 0x1001})
    made.robot(1_020 * MS, SERVO, {0: 0x4000, 2: 12, 4: 600})
    verdict = Verdict(tmp_path, made)
    told = verdict.lines[-1][16:]
    assert told == "  abnormal end, alarm 12.600 Emergency stop on, 20.5 ms after the code"


def test_an_end_is_timed_once_and_a_reserved_bit_reported_once(tmp_path: Path) -> None:
    """A reserved bit that stays ON is reported once, although other bits of its byte change."""
    made = _recorded("two ends")
    made.robot(1_200 * MS, SERVO | 0x20, {0: 0x4000, 2: 12, 4: 600})
    made.robot(1_300 * MS, IDLE | 0x20, {0: 0x4000, 2: 12, 4: 600})
    verdict = Verdict(tmp_path, made)
    assert verdict.rules == ["status", "reserved"]
    assert verdict.times("MovePtp: from code to end") == (1, 20_500, 20_500)


def test_a_command_sent_before_the_recording_breaks_no_rule(tmp_path: Path) -> None:
    """A command that was sent before the recording began breaks no rule.

    Its status goes from 16#0100 to 16#0000, because its code was changed before (guide 1.1).
    """
    story = Story()
    story.open(0)
    for k in range(1, 20):
        so = area({0: 0x0100 if k < 10 else 0}, SERVO)
        story.both(10_000 * k, area({0: 1}, 0x41), so)
    assert Verdict(tmp_path, story).rules == []


def test_events_and_chart_can_be_those_of_a_part(tmp_path: Path) -> None:
    made = _powered()
    _moved(made)
    verdict = Verdict(tmp_path, made, from_us=500 * MS, until_us=700 * MS)
    assert [line[16:] for line in verdict.lines] == [
        "SI(01) ON   Servo ON input",
        "SO(02) ON   Servo ON status output",
    ]
    chart = text_chart(verdict.result.timeline, ascii_only=True)
    assert "650" in chart
    assert "1000" not in chart
    assert verdict.times("MovePtp: ran")[0] == 1


def test_the_chart_of_a_long_recording_has_at_most_400_moments(tmp_path: Path) -> None:
    """The chart of a long recording ends after 400 moments. A line says where the rest begins."""
    made = Recording()
    for k in range(500):
        made.robot((k + 2) * 10 * MS, IDLE | (k % 2) << 13)
    verdict = Verdict(tmp_path, made)
    assert verdict.result.chart_end_us is not None
    assert len(verdict.result.timeline.instants()) <= 400


def test_the_summary_says_what_was_there(tmp_path: Path) -> None:
    made = _powered()
    _moved(made)
    made.story.close(1_500 * MS)
    lines = list(summary(Verdict(tmp_path, made).result))
    assert lines[0].startswith(
        "told.pcap: 284 packets, 280 of class 1, 1.500 s from 2023-11-14 22:13:20"
    )
    assert lines[3].endswith("48 bytes, from 0.001 s, closed by a Forward Close at 1.500 s")
    assert lines[4:6] == [
        "    to the controller every 10 ms, 140 packets, none lost; longest silence 10 ms",
        "    from it every 10 ms, 140 packets, none lost; longest silence 10 ms",
    ]
    assert lines[-1] == "no violations"


def test_the_json_has_the_same_in_numbers(tmp_path: Path) -> None:
    made = _recorded("a reserved bit", 1_200 * MS)
    found = json.loads(json.dumps(as_json(Verdict(tmp_path, made).result)))
    assert (found["packets"], found["cyclic_packets"], found["violation_count"]) == (242, 240, 1)
    (one,) = found["controllers"]
    assert (one["address"], one["size"], one["commands"]) == ("192.168.0.10", 48, 0)
    assert one["times"]["SI(01) ON: SO(02) ON"] == {"count": 1, "unanswered": 0, "exact": True,
                                                    "median_us": 50_500, "p99_us": 50_500,
                                                    "longest_us": 50_500}  # fmt: skip
    assert one["connections"][0]["to_controller"]["lost"] == 0
    assert found["violations"][0]["rule"] == "reserved"
    assert found["violations"][0]["t_us"] == 1_000_000


def test_a_capture_of_the_wrong_traffic_says_what_is_in_it(tmp_path: Path) -> None:
    story = Story()
    story.refuse(0, "2801")
    with pytest.raises(InputError, match=r"2 packets, 0 of class 1; capture TCP port 44818"):
        Verdict(tmp_path, story)


def _cycles(file: Path, *cycles: tuple[dict[int, int], int]) -> Judgement:
    """Return the judgement of a trace of `rcx serve`.

    Each cycle has words of the PLC and a status.
    """
    lines = [{"format": "rcx-trace/1", "by": "rcx serve", "size": 48, "cycle_us": 5_000}]
    for number, (words, status) in enumerate(cycles):
        si, so = area(words, 0x41), area({0: status}, SERVO)
        areas = {"rcx_si": si.hex(), "rcx_so": so.hex()}
        lines.append({"t_us": 5_000 * number, "cycle": number, **areas})
    file.write_text("".join(f"{json.dumps(line)}\n" for line in lines), encoding="utf-8")
    return judge(JudgeOptions(file), lambda text: None)


def test_in_a_trace_the_plc_reads_the_status_one_cycle_late(tmp_path: Path) -> None:
    """In a trace, status 0x0100 in the cycle of the code breaks no rule.

    The controller accepts a code and shows 0x0100 in the same cycle, and the PLC reads it one cycle
    later.

    Source: guide 1.2, a command can be run in the ready status only.
    """
    data, code = {8: 19}, {0: 1, 8: 19}
    good = [({}, 0), (data, 0), (code, 0x0100), (code, 0x0200), (data, 0), (code, 0x0100)]
    judged = _cycles(tmp_path / "good.jsonl", *good)
    assert judged.findings == []
    assert judged.followers[1].commands == 2
    early = [({}, 0), (data, 0), (code, 0x0100), (code, 0x0200), (data, 0x0200), (code, 0)]
    (found,) = _cycles(tmp_path / "early.jsonl", *early).findings
    assert found.text == (
        "plc, cycle 5: ready before code: the code 16#0001 went out while the status read was "
        "16#0200; expected 16#0000"
    )
    changed = [({}, 0), (data, 0), (code, 0x0100), (data, 0x0200)]
    (found,) = _cycles(tmp_path / "changed.jsonl", *changed).findings
    assert found.rule == "command held"


def test_a_code_with_its_data_waits_for_the_ready_status(tmp_path: Path) -> None:
    """Source: guide 1.2, a command can be run in the ready status only."""
    made = _powered()
    made.plc(1_000 * MS, 0x41, {0: 1, 8: 19})
    made.robot(1_020 * MS, SERVO, {0: 0x0200})
    made.plc(1_040 * MS, 0x41)
    made.plc(1_060 * MS, 0x41, {0: 1, 8: 20})
    made.until(1_100 * MS)
    verdict = Verdict(tmp_path, made)
    assert verdict.rules == ["ready before code"]
    assert verdict.result.followers[1].together == 2
