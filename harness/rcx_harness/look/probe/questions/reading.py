"""Questions that only read: they send references, with all dedicated inputs OFF."""

from __future__ import annotations

from rcx_harness.look.probe.asker import Answer, Asker, telegram
from rcx_harness.look.probe.question import reading
from rcx_harness.spec import command
from rcx_harness.spec.wire import ENDS, NORMAL_END, READY, RUN

_AXIS_6, _ACCEL = 32, 257
_REPEATS = 5
_LAST_CONTROLLER, _LAST_ROBOT = 4, 4
_UNUSED_WORD = 4
_NAME_END = next(
    part.words[-1] for part in command("ReadProgramInfo").response if part.name == "program_name"
)


def _alarm_of(ask: Asker, knob: str, answer: Answer, what: str) -> None:
    """Report the alarm of a refused request. If there is no alarm, raise SkipError."""
    ask.needs(bool(answer.alarm), f"{what} did not end in an alarm")
    ask.knob(knob, answer.alarm, text=f"{what} ended in alarm {answer.alarm}")


@reading({"versions": ("host_version", "host_revision", "fpga_version", "driver_version")})
def versions(ask: Asker) -> None:
    """Which versions does the controller have?"""
    fields = ask.command("ReadVersion").fields
    ask.needs(bool(fields), "the version reference did not end normally")
    for name in ("host_version", "host_revision", "fpga_version"):
        ask.knob(name, fields[name], text=f"ReadVersion: {name} {fields[name]}")
    driver = fields["driver_versions"][0]
    ask.knob("driver_version", driver, text=f"ReadVersion: the first driver's is {driver}")


@reading({"option-slots": ("option_slots", "ivy2_unit", "absent_controller_alarm")})
def option_slots(ask: Asker) -> None:
    """Which units are in the option slots, and how are commands to an absent unit answered?"""
    fields = ask.command("ReadOptionSlots", controller=1).fields
    ask.needs(bool(fields), "the option slot reference did not end normally")
    ask.knob("option_slots", fields["slots"], text=f"slots {fields['slots']}")
    ask.knob("ivy2_unit", fields["ivy2"], text=f"iVY2 unit {fields['ivy2']}")
    answer = ask.command("ReadOptionSlots", controller=_LAST_CONTROLLER)
    _alarm_of(ask, "absent_controller_alarm", answer, "a reference to controller 4")


@reading({"first-settings": ("manual_speed", "inching_amount")})
def settings(ask: Asker) -> None:
    """Which manual speed and inching amount are set?"""
    speed = ask.command("ReadSpeeds", 1).fields
    ask.needs(bool(speed), "the speed reference did not end normally")
    ask.knob("manual_speed", speed["manual_speed"], text=f"{speed['manual_speed']} %")
    amount = ask.command("ReadInchingAmount", 1).fields
    ask.needs(bool(amount), "the inching amount reference did not end normally")
    ask.knob("inching_amount", amount["amount"], text=f"inching amount {amount['amount']}")


@reading({"format": ("format_alarm", "strict_unused_words")})
def wrong_format(ask: Asker) -> None:
    """Does the controller check ranges and unused words, and which alarm does it raise?"""
    refused = ask.command("ReadMessage", message=0)
    words = list(telegram("ReadVersion"))
    words[_UNUSED_WORD] = 5
    answer = ask.telegram(tuple(words))
    strict = bool(answer.alarm)
    text = f"ReadVersion with n+8 = 5 ended {'in alarm ' + answer.alarm if strict else 'normally'}"
    ask.knob("strict_unused_words", strict, text=text)
    _alarm_of(ask, "format_alarm", refused, "a reference to message 0")


@reading({"other-alarms": ("absent_robot_alarm", "no_axis_alarm")})
def absent(ask: Asker) -> None:
    """How does the controller answer if a robot or an axis does not exist?"""
    answer = ask.command("ReadParameter", 1, parameter=_ACCEL, axes=_AXIS_6)
    if answer.alarm:
        _alarm_of(ask, "no_axis_alarm", answer, "a parameter of axis 6 of robot 1")
    answer = ask.command("ReadPositionPulses", _LAST_ROBOT)
    _alarm_of(ask, "absent_robot_alarm", answer, "the position of robot 4")


@reading({"other-alarms": ("undefined_point_alarm",)})
def undefined_point(ask: Asker) -> None:
    """How does the controller answer for points that were never written?"""
    answer = ask.command("ReadPoint", point=29_998)
    _alarm_of(ask, "undefined_point_alarm", answer, "a reference to point 29998")


@reading({"undefined-data": ("undefined_data_alarm",), "comment-end": ("comment_filler",)})
def undefined_data(ask: Asker) -> None:
    """How does the controller answer for comments, shifts and hands that were never defined?"""
    answer = ask.command("ReadPointComment", point=29_998)
    if answer.status == NORMAL_END:
        ask.needs(answer.fields["comment"].strip("\0 ") == "", "point 29998 has a comment")
        last = answer.words[3:11][-1] >> 8
        filler = {0: "zeros", 0x20: "spaces"}.get(last)
        ask.needs(filler is not None, f"an empty comment ends with 16#{last:02X}")
        ask.knob("comment_filler", filler, text=f"an empty comment ends with 16#{last:02X}")
    text = f"a reference to the comment of point 29998: alarm {answer.alarm or 'none'}"
    ask.knob("undefined_data_alarm", answer.alarm, text=text)


@reading({"undefined-pallet": ("undefined_pallet_alarm",)})
def undefined_pallet(ask: Asker) -> None:
    """How does the controller answer for a pallet that was never defined?"""
    answer = ask.command("ReadPallet", pallet=38)
    _alarm_of(ask, "undefined_pallet_alarm", answer, "a reference to pallet 38")


@reading({"task-table": ("undefined_program_alarm", "undefined_task_alarm")})
def undefined_program(ask: Asker) -> None:
    """How does the controller answer for programs and tasks that do not exist?"""
    answer = ask.command("ReadProgramInfo", method=2, task=16)
    if answer.alarm:
        _alarm_of(ask, "undefined_task_alarm", answer, "a reference to task 16")
    answer = ask.command("ReadProgramInfo", method=1, program=100)
    _alarm_of(ask, "undefined_program_alarm", answer, "a reference to program 100")


@reading({"name-filler": ("name_filler",)})
def name_filler(ask: Asker) -> None:
    """Which character fills up a program name?"""
    answer = ask.command("ReadProgramInfo", method=1, program=1)
    ask.needs(answer.status == NORMAL_END, "program 1 does not exist, or cannot be read")
    last = answer.words[_NAME_END] >> 8 if len(answer.fields["program_name"]) < 16 else -1
    filler = {0: "zeros", 0x20: "spaces"}.get(last)
    ask.needs(filler is not None, "the name of program 1 has no room for a filler")
    ask.knob("name_filler", filler, text=f"the name of program 1 ends with 16#{last:02X}")


@reading({"flag-bit-0": ("position_flag_bit0",), "position-hand": ("position_hand",)})
def position_flags(ask: Asker) -> None:
    """Which flags does a position in millimetres have?"""
    fields = ask.command("ReadPositionMm", 1).fields
    ask.needs(bool(fields), "the position reference did not end normally")
    flag = bool(fields["flag_bit0"])
    ask.knob("position_flag_bit0", flag, text=f"bit 0 of m+6 is {fields['flag_bit0']}")
    arm = ask.command("ReadArmStatus", 1).fields.get("arm_state")
    shown = bool(fields["hand"])
    ask.needs(shown or arm in (0, 1), "the arm has no state to show")
    ask.knob("position_hand", shown, text=f"hand system {fields['hand']}, arm status {arm}")


@reading(
    {
        "command-times": (
            "command_accept_delay",
            "command_delay",
            "status_reset_delay",
            "skip_run_status",
        )
    },
)
def command_times(ask: Asker) -> None:
    """How long do answers to remote commands take?"""
    answers = [ask.command("ReadVersion") for _ in range(_REPEATS)]
    ran = [one for one in answers if one.ran]
    text = f"0x0100 was seen in {len(ran)} of {_REPEATS} references"
    longest = max(one.reset_us for one in answers)
    ask.delay("status_reset_delay", longest, f"ready {longest / 1000:g} ms after the reset")
    if ran:
        accepted = max(one.accepted_us for one in ran)
        ask.delay("command_accept_delay", accepted, f"0x0100 after {accepted / 1000:g} ms")
        ended = max(one.ended_us for one in ran)
        ask.delay("command_delay", ended, f"the end {ended / 1000:g} ms later")
        ask.knob("skip_run_status", "short", "never", text=text)
    elif max(one.accepted_us for one in answers) >= ask.line.tolerance_us:
        ask.knob("skip_run_status", "always", text=text)


@reading({"continuous-details": ()})
def continuous(ask: Asker) -> None:
    """Does a continuous position end without an end status?"""
    ask.send(telegram("ReadPositionPulses", 1, continuous=1))
    began = ask.until(lambda: ask.status == RUN)
    ask.wait(100_000)
    ended = ask.status in ENDS
    ask.send((0,) * 16)
    ask.until(lambda: ask.status != RUN)
    ask.needs(began is not None, "status 0x0100 was not seen")
    holds = not ended and ask.status == READY
    ask.rule("continuous-details", holds, "the status went from 0x0100 to 0x0000")


@reading({"robot-type": ()})
def robot_type(ask: Asker) -> None:
    """Does a robot have the type of its first axis?"""
    fields = ask.command("ReadSystemConfiguration", 1).fields
    ask.needs(bool(fields), "the system configuration reference did not end normally")
    text = f"robot {fields['robot_type']}, axes {fields['axis_types']}"
    ask.rule("robot-type", fields["robot_type"] == fields["axis_types"][0], text)


@reading({"alarm-places": ()})
def alarm_places(ask: Asker) -> None:
    """Does the alarm of a command with a robot come from that robot?"""
    refused = ask.command("ReadParameter", 1, parameter=_ACCEL, axes=_AXIS_6)
    ask.needs(bool(refused.alarm), "the reference to axis 6 ended without an alarm")
    fields = ask.command("ReadLatestAlarm").fields
    ask.needs(bool(fields), "the latest alarm reference did not end normally")
    text = f"place {fields['place']}, number {fields['place_number']}"
    ask.rule("alarm-places", (fields["place"], fields["place_number"]) == (0, 1), text)


@reading(
    {"first-image-command": ("first_image_commands",)},
    does="The connection is cut and opened again.",
)
def first_image_command(ask: Asker) -> None:
    """Is a command in the first image of a connection executed?"""
    ask.drop(2_000_000)
    ask.open(code=telegram("ReadVersion")[0])
    ended = ask.until(lambda: ask.status in ENDS, 500_000) is not None
    ask.send((0,) * 16)
    text = f"ReadVersion in the first packet {'ended' if ended else 'got no status'}"
    ask.knob("first_image_commands", ended, text=text)


@reading({"mp-ready": ("mp_ready_in_emergency_stop",)})
def mp_ready(ask: Asker) -> None:
    """Is SO(04) ON in an emergency stop?"""
    ask.needs(ask.on("SO00"), "SO(00) is OFF although SI(00) is OFF")
    ready = ask.on("SO04")
    text = f"SO(04) is {'ON' if ready else 'OFF'} while SO(00) is ON"
    ask.knob("mp_ready_in_emergency_stop", ready, text=text)
