"""A comparison and a fit in words and as JSON, as `rcx compare` prints them."""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from rcx_harness.look.compare.channels import RESPONSE, STATUS, Difference
from rcx_harness.look.compare.fit import Fit
from rcx_harness.look.compare.recording import Recording
from rcx_harness.look.compare.replay import Replay, Replayed
from rcx_harness.robot.area import input_words
from rcx_harness.spec import command_name, commands, signals
from rcx_harness.spec.plain import request_text, response_text
from rcx_harness.spec.rules import Rule, rules
from rcx_harness.spec.wire import STATUS_NAMES
from rcx_harness.trace import Scan
from rcx_harness.trace.chart import MOST_INSTANTS, Timeline
from rcx_harness.watch.wire import word
from structured_text.output.units import format_us, format_word

__all__ = ["as_json", "chart", "fit_lines", "lines", "rules_of"]

_MOST = 20
#: Names of the rules about each signal. For status and response, the rules of the command's section
#: apply in addition.
_OF_SIGNAL = {
    "SO00": ("emergency-stop", "emergency-release", "emergency-terminal", "link-lost", "answers"),
    "SO01": ("cpu-ok", "boot"),
    "SO02": ("servo-on", "servo-output", "servo-needs-reset", "alarm-stops", "answers"),
    "SO03": ("serious-alarm", "alarm-reset", "minor-alarms", "command-alarms", "answers"),
    "SO04": ("mp-ready", "mp-ready-power"),
    "SO10": ("auto-switches", "power-on-state"),
    "SO11": ("origin", "origin-types", "origin-model", "origin-kept"),
    "SO12": ("sequence", "sequence-program", "answers"),
    "SO13": ("program-start", "program-stop", "program-restart", "program-mode", "tasks"),
    "SO14": ("program-reset", "program-start", "program-reset-running", "power-on-state"),
    "SO15": ("warning", "warning-reset"),
    STATUS: ("ready-first", "hold-command", "run-status", "status-reset", "command-times"),
    RESPONSE: ("response-with-status", "abnormal-end", "shared-words"),
    "reserved": ("reserved",),
}
_PORTS = ("ports", "outputs-kept")
_WORDS = ("real-time-output", "real-time-items", "real-time-update")
_TITLES = {one.short: f"{one.signal} {one.title}" for one in signals().output}


def rules_of(channel: str, code: int) -> tuple[Rule, ...]:
    """Return the rules that concern a difference: those of its signal and of the current command.

    `code` is the code of the current command; 0: no command.
    """
    usual = _WORDS if channel.startswith("SOW") else _PORTS
    names = set(_OF_SIGNAL.get(channel, usual))
    command = commands().get(code & 0x0FFF) if channel in (STATUS, RESPONSE) else None
    section = f"guide, {command.section}" if command and code else None
    return tuple(one for one in rules() if one.id in names or one.section == section)


def lines(replay: Replay, result: Replayed) -> Iterator[str]:
    """Yield the first differences, then the number of differences for each signal and rule."""
    recording = replay.recording
    begin_us, end_us = replay.span
    yield (
        f"compared: {begin_us / 1e6:.3f} s to {end_us / 1e6:.3f} s, {recording.size} bytes, "
        + (
            "cycle by cycle"
            if not recording.tolerance_us
            else f"times within {format_us(recording.tolerance_us)}"
        )
    )
    if recording.missing:
        packets = "1 packet is" if recording.missing == 1 else f"{recording.missing} packets are"
        yield f"{packets} missing: lost on the way, or not captured as a whole"
    found = result.differences
    if not found:
        yield "the virtual controller answers the same"
        return
    yield ""
    for one in found[:_MOST]:
        yield from _side_by_side(one, recording, result)
    if len(found) > _MOST:
        yield f"... and {len(found) - _MOST} further differences"
    yield ""
    yield f"{'by signal':<34} differences       first"
    firsts = {one.channel: one.begin_us for one in reversed(found)}
    for channel, count in Counter(one.channel for one in found).most_common():
        yield f"{_title(channel):<34.34} {count:>11}  {firsts[channel] / 1e6:8.3f} s"
    yield ""
    yield f"{'by rule that bears on it':<34} differences       first"
    by_rule: dict[str, list[int]] = {}
    for one in found:
        for rule in rules_of(one.channel, _asked(recording, one.begin_us)[0]):
            by_rule.setdefault(rule.id, []).append(one.begin_us)
    for name, times in sorted(by_rule.items(), key=lambda pair: (pair[1][0], pair[0])):
        yield f"{name:<34.34} {len(times):>11}  {times[0] / 1e6:8.3f} s"
    yield ""
    yield f"{len(found)} difference{'s' * (len(found) > 1)}"


def fit_lines(fit: Fit, replay: Replay) -> Iterator[str]:
    """Yield the lines about decided keys, and the lines about keys that stay undecided."""
    found = [one for one in fit.knobs if one.found]
    yield f"{'key':<34} value that the recording shows"
    for one in found:
        others = f"; as well {', '.join(map(_value, one.others[:4]))}" if one.others else ""
        yield f"{one.key:<34} {_value(one.value)}   ({one.why}{others})"
        for key, value in one.instead:
            yield f"{'':<34} has the same effect as {key} = {_value(value)}"
    if fit.config.skip_run_status == "always":
        yield ""
        yield "commands do not show that they run: command_accept_delay is from refused commands;"
        yield "if both delays of commands vary, they may cause remaining differences"
    yield ""
    yield "cannot be decided by this recording"
    for one in fit.knobs:
        if not one.found:
            yield f"{one.key:<34} {one.why}"
    yield ""
    if not fit.left:
        yield f"no difference is left, after {fit.runs} replays"
        return
    yield "no key expresses"
    for difference in fit.left[:_MOST]:
        yield from _side_by_side(difference, replay.recording, None)
    yield f"{len(fit.left)} difference{'s' * (len(fit.left) > 1)} left, after {fit.runs} replays"


def as_json(replay: Replay, result: Replayed, fit: Fit | None) -> dict[str, Any]:
    """Return the result as a JSON object; times in microseconds from the recording's start."""
    begin_us, end_us = replay.span
    found: dict[str, Any] = {
        "begin_us": begin_us,
        "end_us": end_us,
        "tolerance_us": replay.recording.tolerance_us,
        "missing_packets": replay.recording.missing,
        "trouble": str(replay.recording.trouble or ""),
        "differences": [_difference(one, replay.recording) for one in result.differences],
    }
    if fit is not None:
        found["knobs"] = [
            {
                "key": one.key,
                "value": one.value,
                "found": one.found,
                "why": one.why,
                "others": list(one.others),
                "instead": [{"key": key, "value": value} for key, value in one.instead],
            }
            for one in fit.knobs
        ]
        found["left"] = [_difference(one, replay.recording) for one in fit.left]
    return found


def chart(replay: Replay, result: Replayed, around_us: int, at_us: int) -> Timeline:
    """Return the chart around a time; controller 1 is recorded, and controller 2 is virtual."""
    timeline = Timeline()
    recording = replay.recording
    merged = [(t_us, 1, area) for t_us, area in recording.outputs]
    merged += [(t_us, 2, area) for t_us, area in result.outputs]
    merged += [(t_us, 0, area or bytes(recording.size)) for t_us, area in recording.inputs]
    now = {0: bytes(recording.size), 1: bytes(recording.size), 2: bytes(recording.size)}
    last_before: dict[int, bytes] = {}
    taken = 0
    for t_us, which, area in sorted(merged, key=lambda one: one[0]):
        now[which] = area
        if t_us < at_us - around_us:
            last_before = dict(now)
            continue
        if t_us > at_us + around_us or taken > MOST_INSTANTS:
            break
        if last_before:
            _draw(timeline, at_us - around_us, taken, last_before)
            last_before = {}
        taken += 1
        _draw(timeline, t_us, taken, now)
    return timeline


def _draw(timeline: Timeline, t_us: int, number: int, now: dict[int, bytes]) -> None:
    for controller in (1, 2):
        timeline.take(Scan(t_us, number, now[controller], now[0], controller=controller))


def _side_by_side(one: Difference, recording: Recording, result: Replayed | None) -> Iterator[str]:
    code, request = _asked(recording, one.begin_us)
    yield f"{one.begin_us / 1e6:10.3f} s  {_title(one.channel)}, for {format_us(_long(one))}"
    areas = [_at(recording.outputs, one.begin_us)]
    if result is not None:
        areas.append(_at(result.outputs, one.begin_us))
    for who, value, area in zip(
        ("recorded", "virtual "), (one.recorded, one.virtual), (*areas, None), strict=False
    ):
        yield f"              {who}  {_shown(one.channel, value, area, code)}"
    if one.channel in (STATUS, RESPONSE) and code:
        yield f"              asked     {request_text(input_words(request))}"
    names = ", ".join(rule.id for rule in rules_of(one.channel, code)[:6])
    yield f"              rules     {names}"


def _shown(channel: str, value: int, area: bytes | None, code: int) -> str:
    if channel == STATUS:
        return f"{format_word(value)} {STATUS_NAMES.get(value, 'which has no meaning')}"
    if channel == RESPONSE:
        whole = value.to_bytes(30, "little")
        return response_text(code, input_words(area)) if area else whole.hex(" ", 2)
    if channel in _TITLES:
        return "ON" if value else "OFF"
    return f"16#{value:X}"


def _title(channel: str) -> str:
    return _TITLES.get(
        channel, {STATUS: "remote status", RESPONSE: "response"}.get(channel, channel)
    )


def _long(one: Difference) -> int:
    return max(0, one.end_us - one.begin_us)


def _at(outputs: Sequence[tuple[int, bytes]], at_us: int) -> bytes:
    place = bisect_right(outputs, at_us, key=lambda one: one[0])
    return outputs[max(0, place - 1)][1]


def _asked(recording: Recording, at_us: int) -> tuple[int, bytes]:
    """Return code and area of the latest command at the given time."""
    code, found = 0, bytes(recording.size)
    for t_us, area in recording.inputs:
        if t_us > at_us:
            break
        if area is not None and word(area, 0):
            code, found = word(area, 0), area
    return code, found


def _difference(one: Difference, recording: Recording) -> dict[str, Any]:
    code = _asked(recording, one.begin_us)[0]
    return {
        "channel": one.channel,
        "begin_us": one.begin_us,
        "end_us": one.end_us,
        "recorded": one.recorded,
        "virtual": one.virtual,
        "command": command_name(code) if code else "",
        "rules": [rule.id for rule in rules_of(one.channel, code)],
    }


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, tuple):
        return f"[{', '.join(_value(one) for one in value)}]"
    return (
        f'"{value}"'
        if isinstance(value, str)
        else f"{value:g}"
        if isinstance(value, float)
        else str(value)
    )
