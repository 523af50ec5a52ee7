"""`rcx probe` is run on a virtual controller, with several values of every key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from probed_robot import StationLine, question, rehearsed
from rcx_harness.look.probe.catalogue import questions
from rcx_harness.look.probe.question import Risk
from rcx_harness.look.probe.report import Subject, as_markdown, as_toml, unasked, verdicts
from rcx_harness.look.probe.run import Person, probe
from rcx_harness.robot import RobotConfig
from rcx_harness.spec.rules import rules
from rcx_harness.spec.wire import SIZE
from rcx_harness.trace import read_trace
from structured_text.output.toml_files import parse_toml
from tiers import sampled

#: Maps each question to its keys, with the assumed value and other values of each key.
KEYS: dict[str, dict[str, tuple[Any, ...]]] = {
    "versions": {"host_version": (0x0108, 0x0112), "host_revision": (0x0030, 0x0031),
                 "fpga_version": (0x1001, 0x1002), "driver_version": (0x0101, 0x0201)},
    "option-slots": {"option_slots": ((0x0401, 0x0100, 0, 0), (0, 0x0401, 0, 0)),
                     "ivy2_unit": (0, 3), "absent_controller_alarm": ("4.2", "4.213")},
    "settings": {"manual_speed": (20, 30), "inching_amount": (100, 50)},
    "wrong-format": {"format_alarm": ("4.2", "4.202"), "strict_unused_words": (True, False)},
    "absent": {"absent_robot_alarm": ("4.2", "4.204"), "no_axis_alarm": ("4.2", "4.205")},
    "undefined-point": {"undefined_point_alarm": ("4.2", "6.204")},
    "undefined-data": {"undefined_data_alarm": ("", "6.205"),
                       "comment_filler": ("zeros", "spaces")},
    "undefined-pallet": {"undefined_pallet_alarm": ("4.2", "6.236")},
    "undefined-program": {"undefined_program_alarm": ("4.2", "3.203"),
                          "undefined_task_alarm": ("4.2", "6.262")},
    "name-filler": {"name_filler": ("spaces", "zeros")},
    "position-flags": {"position_flag_bit0": (True, False), "position_hand": (False, True)},
    "command-times": {"command_accept_delay": (0.0, 50.0), "command_delay": (10.0, 60.0),
                      "status_reset_delay": (0.0, 40.0), "skip_run_status": ("always",)},
    "first-image-command": {"first_image_commands": (True, False)},
    "mp-ready": {"mp_ready_in_emergency_stop": (True, False)},
    "emergency-stop": {"emergency_stop_delay": (0.0, 40.0), "emergency_release_delay": (5.0, 45.0),
                       "alarm_reset_delay": (20.0, 80.0), "reset_in_emergency_stop": (False, True)},
    "interval": {"min_interval": (100.0, 50.0, 0.0)},
    "late-level": {"late_levels": (True, False)},
    "first-image": {"recovery_edges": (False, True)},
    "link-loss": {"link_loss_alarm": ("12.552", "12.551")},
    "idle-header": {"idle_header": ("loss", "hold")},
    "minor-alarms": {"minor_alarms": (("12.400",), ())},
    "command-alarms": {"command_alarm_is_serious": (False, True)},
    "message-order": {"newest_message_first": (True, False)},
    "program-reset": {"reset_clears_outputs": (False, True), "program_reset_delay": (20.0, 90.0)},
    "warning": {"reset_clears_warning": (False, True)},
    "undefined-code": {"undefined_code_alarm": ("4.2", "12.75")},
    "changed-command": {"changed_command_status": ("run", "ready"),
                        "early_command_waits": (False, True)},
    "changed-data": {"data_belong_to_command": (True, False)},
    "servo-off": {"servo_off_alarm": ("4.2", "6.301")},
    "arithmetic": {"overflow_alarm": ("4.2", "6.252"), "division_alarm": ("4.2", "6.203"),
                   "real_to_integer": ("round", "truncate")},
    "points": {"point_unit_alarm": ("4.2", "6.205"), "several_elements": (True, False)},
    "pallet": {"work_position_alarm": ("4.2", "6.283")},
    "impossible-date": {"impossible_date_alarm": ("4.2", "4.203")},
    "arm": {"not_scara_alarm": ("4.2", "6.319")},
    "pendant": {"pendant_alarm": ("4.2", "12.76"), "pendant_blocks_inputs": (True, False)},
    "manual-mode": {"manual_mode_alarm": ("4.2", "0.20"), "start_needs_auto": (True, False)},
    "safety-setting": {"safety_keeps_stops": (True, False)},
    "main-power": {"main_power_alarm": ("", "12.601")},
    "power-cycle": {"power_on_emergency_alarm": (False, True),
                    "link_error_alarm": ("12.551", "12.550"), "link_error_latches": (False, True),
                    "power_clears_internal_outputs": (True, False),
                    "power_loses_settings": (False, True), "power_loses_origin": (True, False),
                    "auto_mode": (True, False), "origin_complete": (True, False),
                    "program_is_reset": (False, True)},
    "servo-on": {"servo_on_delay": (50.0, 120.0), "servo_on_with_alarm": (False, True)},
    "motor-power": {"servo_needs_motor_power": (True, False),
                    "motor_power_alarm": ("4.2", "6.300")},
    "unasked-positions": {"unasked_positions_zero": (True, False)},
    "program": {"program_needs_servo": (False, True), "reset_while_running": (False, True),
                "program_info_while_running": (True, False),
                "motor_power_stops_program": (True, False), "busy_alarm": ("4.2", "6.280"),
                "program_start_delay": (20.0, 100.0), "program_stop_delay": (5.0, 80.0)},
    "program-in-manual-mode": {"manual_mode_stops_program": (True, False)},
    "sequence": {"sequence_program": (True, False), "emergency_stops_sequence": (False, True),
                 "sequence_delay": (5.0, 60.0)},
}  # fmt: skip
#: Properties or events that a controller needs so that a question gives a result.
PREPARED: dict[str, dict[str, Any]] = {"arm": {"scara_robots": (2,)}}
NO_HOST = Subject("192.168.0.10", "RCX340", "A. B.", "2030-12-31")
CASES = [
    (name, key, value)
    for name, keys in KEYS.items()
    for key, several in keys.items()
    for value in several
]


def _prepare(line: StationLine) -> None:
    line.happen("", "warning")


def _agreed(line: StationLine) -> Person:
    """Return a simulated user, who confirms every step and does all manual work at the cell."""
    return Person(lambda one: True, line.happen, lambda text: None)


@pytest.mark.parametrize(("name", "key", "value"), sampled(CASES, 6))
def test_the_report_is_correct_for_each_value_of_each_key(name: str, key: str, value: Any) -> None:
    """The report confirms a correct assumption, and refutes a wrong one with the real value."""
    config = {**PREPARED.get(name, {}), key: value}
    outcome = rehearsed(name, prepare=_prepare, **config)
    assert not outcome.ended
    found = outcome.findings[name]
    mine = [one for one in found if one.knob == key]
    assert mine, outcome.skipped
    true = RobotConfig(**config)
    for one in found:
        real = getattr(true, one.knob) if one.knob else True
        if one.between:
            assert one.values[0] < real <= one.values[1], one
        else:
            assert real in one.values, one
    assumed = value == getattr(RobotConfig(), key)
    assert {one.verdict for one in mine} == {"confirmed" if assumed else "refuted"}
    for verdict in verdicts(outcome):
        if key in verdict.rule.knobs and verdict.findings and not assumed:
            assert verdict.verdict == "refuted"


def test_every_key_that_a_question_decides_is_rehearsed() -> None:
    decided = {
        one.id: {key for keys in one.decides.values() for key in keys} for one in questions()
    }
    assert {name: keys for name, keys in decided.items() if keys} == {
        name: set(keys) for name, keys in KEYS.items()
    }


def test_a_question_stays_open_if_two_values_look_alike() -> None:
    """A question stays open if two values of a key cannot be distinguished.

    Example: a controller may always show 0x0100, or skip it only for short commands.
    """
    outcome = rehearsed("command-times", skip_run_status="never")
    mine = [one for one in outcome.findings["command-times"] if one.knob == "skip_run_status"]
    assert [(one.values, one.verdict) for one in mine] == [(("short", "never"), "open")]


def test_each_assumed_rule_has_a_question_or_the_reason_why_none_can_exist() -> None:
    known = {rule.id: rule for rule in rules()}
    assumed = {name for name, rule in known.items() if rule.basis == "assumed"}
    asked = {rule for one in questions() for rule in one.decides}
    assert asked | set(unasked()) <= set(known)
    assert asked & set(unasked()) == set()
    assert assumed - asked - set(unasked()) == set()
    for one in questions():
        for rule, keys in one.decides.items():
            assert set(keys) <= set(known[rule].knobs), (one.id, rule)
    assert all(reason.endswith(".") for reason in unasked().values())


def test_a_whole_probe_confirms_what_is_as_assumed_and_leaves_the_robot_as_it_was() -> None:
    line = StationLine(RobotConfig(scara_robots=(2,)))
    _prepare(line)
    before = list(line.controller.positions)
    outcome = probe(line, questions(), _agreed(line))
    assert line.closed
    assert outcome.skipped == {"position-flags": "the arm has no state to show"}
    kinds = {one.rule.id: one.verdict for one in verdicts(outcome)}
    assert "refuted" not in kinds.values()
    assert not any(line.sent_last)
    assert line.controller.positions[1:] == before[1:]
    assert kinds["interval-strict"] == "confirmed"
    assert kinds["command-times"] == "confirmed in part"
    assert kinds["free-axes"] == "not asked"


def test_a_rule_without_a_key_is_refuted_by_a_controller_that_breaks_it() -> None:
    """A controller that breaks a rule without a key refutes this rule.

    Here an emergency stop takes 200 ms, and the type of the robot is not the type of its first
    axis.
    """
    outcome = rehearsed("stop-at-once", emergency_stop_delay=200.0)
    assert [one.verdict for one in outcome.findings["stop-at-once"]] == ["refuted"]
    outcome = rehearsed("robot-type", prepare=lambda line: line.controller.force("SOW(2)", 7))
    assert [one.verdict for one in outcome.findings["robot-type"]] == ["refuted"]


def test_nothing_moves_without_confirmation_of_the_step() -> None:
    """A step of risk 3 needs a confirmation. Without it, the servos never turn ON."""
    line = StationLine(RobotConfig())
    servos: list[bool] = []
    step = line.wait

    def watched(us: int) -> None:
        step(us)
        servos.append(line.controller.machine.servo_on)

    line.wait = watched  # type: ignore[method-assign]
    person = Person(lambda one: one.risk < Risk.MOTION, line.happen, lambda text: None)
    outcome = probe(line, questions(), person)
    assert len(servos) > 1_000
    assert not any(servos)
    motion = [one.id for one in questions() if one.risk is Risk.MOTION]
    assert all(outcome.skipped[name] == "not confirmed" for name in motion)


def test_reading_leaves_all_dedicated_inputs_off() -> None:
    line = StationLine(RobotConfig())
    sent: list[bytes] = []
    write = line.write

    def watched(area: bytes, *, run: bool = True) -> None:
        sent.append(area)
        write(area, run=run)

    line.write = watched  # type: ignore[method-assign]
    asked = [one for one in questions() if one.risk is Risk.READING]
    probe(line, asked, _agreed(line))
    assert len(sent) > 50
    assert not any(any(area[32:]) for area in sent)


def test_a_controller_that_resets_its_status_late_is_not_misread() -> None:
    """If the controller resets its status late, the question stays open.

    An old status could be mistaken for an answer.

    Source: guide 1.2, a command can be run in the ready status only.
    """
    names = ("undefined-data", "wrong-format", "command-times", "versions")
    outcome = rehearsed(*names, status_reset_delay=60_000.0)
    assert not outcome.ended
    assert outcome.findings == {}
    assert set(outcome.skipped) == set(names)
    assert all("3 s long" in reason for reason in outcome.skipped.values())


@pytest.mark.exhaustive
def test_a_controller_that_never_ends_a_command_leaves_questions_open() -> None:
    """Source: guide 1.1, note."""
    names = ("undefined-data", "wrong-format", "command-times")
    outcome = rehearsed(*names, command_delay=60_000.0)
    assert outcome.findings == {}
    assert outcome.skipped["undefined-data"] == "no end within 3 s, the status was 16#0100"
    for name in names[1:]:
        assert outcome.skipped[name] == "the status is 16#0100 without a command, 3 s long"


def test_a_connection_that_was_never_open_is_not_reported_as_lost() -> None:
    """If no connection was ever open, no lost connection is reported.

    A busy controller is not reported as a lost connection either.
    """
    asked = [question("versions")]
    person = Person(lambda one: True, lambda text, event: False, lambda text: None)
    line = StationLine(RobotConfig())
    line.happen("", "power_off")
    ended = probe(line, asked, person).ended
    assert ended == "no connection: it does not answer; look at the cable"
    line = StationLine(RobotConfig())
    line.read = lambda: b"\x00\x01" + bytes(46)  # type: ignore[method-assign]
    assert (
        probe(line, asked, person).ended == "it shows the remote status 16#0100 without a command"
    )


def test_a_lost_connection_ends_it_with_what_was_found_so_far(tmp_path: Path) -> None:
    line = StationLine(RobotConfig())
    line.lost_after_us = 6_000_000
    trace = tmp_path / "probe.jsonl"
    outcome = probe(line, questions(), _agreed(line), trace)
    assert line.closed
    assert outcome.ended == "the connection is lost: no packets arrive any more"
    assert outcome.findings["versions"]
    assert outcome.skipped["sequence"] == outcome.ended
    header, records = read_trace(trace)
    assert header["by"] == "rcx probe"
    assert sum(1 for _ in records) > 50
    assert "ended before its last question" in as_markdown(outcome, NO_HOST)


def test_ctrl_c_turns_all_inputs_off_and_closes_the_connection() -> None:
    line = StationLine(RobotConfig())

    def confirms(one: Any) -> bool:
        if one.risk is Risk.STILL:
            raise KeyboardInterrupt
        return True

    outcome = probe(line, questions(), Person(confirms, line.happen, lambda text: None))
    assert line.closed
    assert not any(line.sent_last)
    assert outcome.ended == "stopped by Ctrl-C"
    assert outcome.findings["versions"]


def test_ctrl_c_in_a_step_with_inputs_on_turns_them_off_first() -> None:
    """Ctrl-C during a step turns the inputs OFF before the program ends.

    The keys are pressed in the middle of an emergency stop test.
    """
    line = StationLine(RobotConfig())
    read, looks = line.read, [0]

    def reading() -> bytes:
        looks[0] += 1
        if looks[0] == 130:
            raise KeyboardInterrupt
        return read()

    line.read = reading  # type: ignore[method-assign]
    asked = [question("emergency-stop")]
    probe(line, asked, _agreed(line))
    assert any(line.sent_last)
    assert line.closed
    assert line.read_inputs() == bytes(SIZE)


def test_with_servos_on_no_question_turns_them_off() -> None:
    line = StationLine(RobotConfig())
    line.controller.hold("SO02")
    line.controller.force("SO02", 1)
    outcome = probe(line, [question("emergency-stop")], _agreed(line))
    assert outcome.skipped == {"emergency-stop": "the servos are ON although SI(00) is OFF"}


def test_a_refused_action_leaves_its_question_open() -> None:
    line = StationLine(RobotConfig())
    person = Person(lambda one: True, lambda text, event: False, lambda text: None)
    outcome = probe(line, [question("pendant")], person)
    told = "not done: Take the control authority at the programming box."
    assert outcome.skipped == {"pendant": told}
    mine = next(one for one in verdicts(outcome) if one.rule.id == "pendant-inputs")
    assert (mine.verdict, mine.reason) == ("not asked", told)


def test_the_report_says_rule_by_rule_what_was_found_and_of_whom() -> None:
    outcome = rehearsed("versions", "wrong-format", format_alarm="4.202")
    table = parse_toml(as_toml(outcome, NO_HOST), Path("report.toml"))
    assert table["format"] == "rcx-probe/1"
    assert (table["host"], table["robot"]) == ("192.168.0.10", "RCX340")
    assert (table["by"], table["date"]) == ("A. B.", "2030-12-31")
    assert table["firmware"].startswith("Host 0x0108 revision 0x0030")
    assert table["identity"] == ["a virtual controller"]
    by_rule = {one["id"]: one for one in table["rule"]}
    assert by_rule["format"]["verdict"] == "refuted"
    wrong = by_rule["format"]["finding"][1]
    assert (wrong["knob"], wrong["values"], wrong["assumed"]) == ("format_alarm", ["4.202"], "4.2")
    assert wrong["evidence"] == "a reference to message 0 ended in alarm 4.202"
    assert by_rule["versions"]["verdict"] == "confirmed"
    assert (
        by_rule["free-axes"]["reason"] == "The test would set an axis free, and the axis may fall."
    )
    assert by_rule["idle-header"]["reason"] == "question idle-header not chosen"
    page = as_markdown(outcome, NO_HOST)
    assert page.startswith("# Probe of RCX340 at 192.168.0.10\n\nBy A. B., 2030-12-31. Host 0x0108")
    assert "| `format` | `format_alarm` | 4.2 | 4.202 | a reference to message 0 ended" in page
    assert page.index("## Refuted") < page.index("## Confirmed") < page.index("## Not asked")
