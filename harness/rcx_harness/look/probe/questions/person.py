"""Questions that need a person at the cell; the servos stay off."""

from __future__ import annotations

from rcx_harness.look.probe.asker import Answer, Asker, telegram
from rcx_harness.look.probe.question import still
from rcx_harness.look.probe.questions.signals import reset
from rcx_harness.spec.wire import NORMAL_END

_LATE_US, _BOOT_US = 500_000, 60_000_000
_POINT = 29_995
_MARK = 0xA5
_MO20 = {"port_type": 2, "port": 0x20}


def _stop_alarm(ask: Asker) -> bool:
    """Return whether SI(12) in the stop status raises 12.400, so it has an effect."""
    before = ask.history()
    ask.pulse("SI12")
    return "12.400" in ask.history().new_since(before)


@still(
    {"other-alarms": ("pendant_alarm",), "pendant-inputs": ("pendant_blocks_inputs",)},
    does="SI(12) goes ON while SI(06) is OFF; the current manual speed is set again.",
    person="take the control authority at the programming box, and give it back",
)
def pendant(ask: Asker) -> None:
    """Which requests of the network work while the programming box has authority?"""
    reset(ask)
    ask.needs(ask.on("SO10") and _stop_alarm(ask), "SI(12) raises no 12.400 without the box")
    speed = ask.command("ReadSpeeds", 1).fields.get("manual_speed", 0)
    ask.person("Take the control authority at the programming box.", "pendant_on")
    try:
        blocked = not _stop_alarm(ask)
        answer = ask.command("SetManualSpeed", 1, speed=speed or 20)
    finally:
        ask.person("Give the control authority back.", "pendant_off")
    text = f"SI(12) raised {'no ' if blocked else ''}12.400 with the authority at the box"
    ask.knob("pendant_blocks_inputs", blocked, text=text)
    ask.needs(bool(answer.alarm), "a setting was accepted although the box had the authority")
    ask.knob("pendant_alarm", answer.alarm, text=f"a setting ended in {answer.alarm}")


@still(
    {"execute-programs": ("manual_mode_alarm",), "program-mode": ("start_needs_auto",)},
    does="SI(12) goes ON while SI(06) is OFF; the programs are reset by command.",
    person="select MANUAL mode, and AUTO mode again",
)
def manual_mode(ask: Asker) -> None:
    """What can be started in MANUAL mode?"""
    reset(ask)
    ask.needs(ask.on("SO10") and _stop_alarm(ask), "SI(12) in AUTO mode raises no 12.400")
    ask.person("Select MANUAL mode.", "manual_mode")
    try:
        ask.needs(not ask.on("SO10"), "SO(10) stays ON")
        started = _stop_alarm(ask)
        answer = ask.command("ResetProgram", method=0)
    finally:
        ask.person("Select AUTO mode again.", "auto_mode")
    text = f"SI(12) raised {'' if started else 'no '}12.400 in MANUAL mode"
    ask.knob("start_needs_auto", not started, text=text)
    ask.needs(bool(answer.alarm), "the programs were reset in MANUAL mode")
    ask.knob("manual_mode_alarm", answer.alarm, text=f"a program reset ended in {answer.alarm}")


@still(
    {"safety-inputs": ("safety_keeps_stops",)},
    does="SI(00) goes ON, and OFF under the safety setting.",
    person="make the safety setting that disables dedicated inputs, and undo it",
)
def safety_setting(ask: Asker) -> None:
    """Do SI(00) and SI(06) work under a safety setting that disables dedicated inputs?"""
    reset(ask)
    ask.person("Make the safety setting that disables dedicated inputs.", "safety_on")
    try:
        ask.turn("SI00", False)
        stops = ask.until(lambda: ask.on("SO00"), _LATE_US) is not None
    finally:
        ask.person("Undo the safety setting.", "safety_off")
    text = f"SO(00) {'turned ON' if stops else 'stayed OFF'} when SI(00) went OFF"
    ask.knob("safety_keeps_stops", stops, text=text)


@still(
    {"main-power": ("main_power_alarm",)},
    does="Only references are sent; the servos are off.",
    person="switch the main power of the motors off (not that of the controller), and on again",
)
def main_power(ask: Asker) -> None:
    """Is there an alarm without main power?"""
    reset(ask)
    before = ask.history()
    ask.person("Switch the main power of the motors off.", "main_power_off")
    try:
        gone = not ask.on("SO04")
        new = ask.history().new_since(before)
    finally:
        ask.person("Switch the main power of the motors on again.", "main_power_on")
    ask.needs(gone, "SO(04) stays ON")
    ask.needs(len(new) <= 1, f"new messages: {', '.join(sorted(new))}")
    alarm = next(iter(new), "")
    ask.knob("main_power_alarm", alarm, text=f"alarm {alarm or 'none'} without main power")


@still(
    {
        "emergency-at-power-on": ("power_on_emergency_alarm",),
        "link-error-at-power-on": ("link_error_alarm", "link_error_latches"),
        "internal-outputs": ("power_clears_internal_outputs",),
        "settings-power": ("power_loses_settings",),
        "stored": (),
        "power-cycle": (),
        "power-on-state": ("auto_mode", "origin_complete", "program_is_reset"),
        "origin-kept": ("power_loses_origin",),
        "emergency-terminal-alarm": (),
    },
    does="Writes MO(20) to MO(27), the manual speed (set back), and the comment of point 29995.",
    person="switch the controller off and on, wait until it has booted; press an emergency stop",
)
def power_cycle(ask: Asker) -> None:
    """Which data survive a power cycle, and which alarms are active after power-on?"""
    reset(ask)
    ask.turn("SI00", False)
    speed = ask.command("ReadSpeeds", 1).fields.get("manual_speed", 20)
    other = 21 if speed != 21 else 22
    ask.command("SetManualSpeed", 1, speed=other)
    ask.telegram(telegram("WriteIoPort", pattern=_MARK, **_MO20))
    ask.command("WritePointComment", point=_POINT, comment="RCX PROBE")
    before, origins = ask.history(), ask.command("ReadOriginStatus", 1, motor_type=1)
    ask.line.drop()
    ask.needs_person("Switch the controller off and on; wait until it has booted.", "power_cycle")
    ask.line.wait(2_000_000)
    ask.open_within(_BOOT_US)
    on = {name: ask.on(name) for name in ("SO03", "SO10", "SO14")}
    history = ask.history()
    new = history.new_since(before) - {"12.552"}
    numbers = ", ".join(sorted(new)) or "none"
    lit = "12.600" in new
    ask.knob("power_on_emergency_alarm", lit, text=f"new messages: {numbers}")
    others = new - {"12.600"}
    if len(others) == 1:
        ask.knob("link_error_alarm", *others, text=f"new messages: {numbers}")
        if not lit:
            latched = on["SO03"]
            text = f"SO(03) is {'ON' if latched else 'OFF'} after the connection"
            ask.knob("link_error_latches", latched, text=text)
    ask.rule("power-cycle", history.count >= before.count, f"{history.count} messages")
    pattern = ask.command("ReadIoPort", **_MO20).fields.get("pattern")
    cleared = pattern != _MARK
    ask.knob("power_clears_internal_outputs", cleared, text=f"MO2() was 16#A5, is {pattern}")
    now = ask.command("ReadSpeeds", 1).fields.get("manual_speed")
    text = f"the manual speed was {other} %, is {now} %"
    ask.knob("power_loses_settings", now != other, text=text)
    ask.command("SetManualSpeed", 1, speed=speed)
    comment = ask.command("ReadPointComment", point=_POINT)
    kept = comment.status == NORMAL_END and comment.fields["comment"].startswith("RCX PROBE")
    ask.rule("stored", kept, f"the comment is {comment.fields.get('comment')!r}")
    ask.knob("auto_mode", on["SO10"], text=f"SO(10) is {'ON' if on['SO10'] else 'OFF'}")
    _origins(ask, origins, ask.command("ReadOriginStatus", 1, motor_type=1))
    ask.knob("program_is_reset", on["SO14"], text=f"SO(14) is {'ON' if on['SO14'] else 'OFF'}")
    if not ask.on("SO03") and ask.on("SO00"):
        ask.person("Press an emergency stop (programming box or SAFETY).", "emergency_stop")
        holds = ask.on("SO03")
        ask.person("Release the emergency stop.", "emergency_stop_release")
        text = f"SO(03) is {'ON' if holds else 'OFF'} although SI(00) was OFF before"
        ask.rule("emergency-terminal-alarm", holds, text)


def _origins(ask: Asker, before: Answer, after: Answer) -> None:
    """Report whether incremental axes have lost their origins."""
    was, now = (one.fields.get("origin_states", ()) for one in (before, after))
    complete = [k for k, state in enumerate(was) if state == 1]
    if complete:
        lost = all(now[k] == 0 for k in complete)
        ask.knob("power_loses_origin", lost, text=f"origins were {was}, are {now}")
        ask.knob("origin_complete", True, text=f"origins {was}")
    elif 0 in was:
        ask.knob("origin_complete", False, text=f"origins {was}")
