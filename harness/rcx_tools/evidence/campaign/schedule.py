"""The events of a storm.

The seed determines the events in advance, as a list that can be shortened.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from random import Random
from typing import Any

from rcx_harness.cell.clock import Timing
from rcx_harness.cell.stimulus import Entry
from rcx_harness.robot import RobotConfig, RobotProgram
from rcx_harness.verify.storm.storms import Storm
from rcx_tools.evidence.campaign.commands import real
from rcx_tools.evidence.campaign.judge import SEQUENCES
from rcx_tools.evidence.campaign.station import Conditions

__all__ = ["draw_run"]


def _draw_conditions(seed: int) -> Conditions:
    """Draw random conditions for a run: times, areas and properties of the controller."""
    random = Random(f"campaign {seed}")
    scan_ms = random.choice((2, 5, 10, 10, 10, 20, 20, 50))
    intervals = tuple(random.randint(2, 30) * 1000 for _ in range(3))
    jitter_ms = random.randint(0, 10)
    latest_ms = jitter_ms + random.randint(0, 60)
    timing = Timing.make(
        scan=scan_ms * 1000,
        rpi=intervals[0],
        jitter=jitter_ms * 1000,
        timeout=max(4 * max(intervals), 100_000),
        phases="random",
        seed=seed,
    )

    def delay(longest: float) -> tuple[float, float]:
        return 0.0, random.uniform(0.0, longest)

    robot = RobotConfig(
        boot_time=delay(800.0),
        servo_on_delay=delay(300.0),
        alarm_reset_delay=delay(200.0),
        program_reset_delay=delay(300.0),
        program_start_delay=delay(300.0),
        program_stop_delay=delay(50.0),
        sequence_delay=delay(50.0),
        emergency_stop_delay=delay(20.0),
        emergency_release_delay=delay(40.0),
        origin_time=random.uniform(50.0, 500.0),
        command_accept_delay=delay(60.0),
        command_delay=delay(300.0),
        status_reset_delay=delay(60.0),
        skip_run_status=random.choice(("never", "short", "always")),
        programs=(
            RobotProgram(duration=random.uniform(400.0, 3000.0), loop=random.random() < 0.5),
        ),
        mp_ready_in_emergency_stop=random.random() < 0.5,
    )
    timeouts = {
        name: random.choice((100, 300, 1000, 3000))
        for name in (*SEQUENCES, "Jog", "Position", *_STARTS)
    }
    start = {f"Main.{name}.Timeout": f"T#{time_ms}ms" for name, time_ms in timeouts.items()}
    start["Main.WriteArea.Margin"] = f"T#{-(-_margin_us(timing, latest_ms * 1000) // 1000)}ms"
    return Conditions(timing, intervals, latest_ms * 1000, robot, start, m=8, n=16)


def _margin_us(timing: Timing, latest_us: int) -> int:
    """Return the FB_WriteArea.Margin that covers every late or lost packet before a time-out.

    A packet arrives at most `latest_us` late. The next packet arrives before the time-out of the
    connection. The controller reads its inputs every 5 ms (docs/explanation/scan-model.md).
    """
    return timing.timeout_us + latest_us + 10_000


# --- pins of the requests ----------------------------------------------------------------------

Pins = dict[str, Any]
_Start = Callable[[int, Random], Pins]


def _pulses(n: int) -> list[int]:
    """Return six numbers that no other request contains."""
    return [n % 30_000, -(n % 29_989), n // 7 % 20_000, n % 9_973, 0, 0]


def _recent(n: int, random: Random) -> int:
    """Return the number of a point that was written recently."""
    return max(0, n - random.randint(1, 40)) % 20_000


def _write_point(n: int, random: Random) -> Pins:
    return {"Point": n % 20_000, "Pulses": _pulses(n)}


def _read_point(n: int, random: Random) -> Pins:
    return {"Point": _recent(n, random)}


def _write_comment(n: int, random: Random) -> Pins:
    return {"Point": n % 20_000, "Comment": f"P{n} X"}


def _write_shift(n: int, random: Random) -> Pins:
    return {"ShiftNumber": n % 40, "ShiftMm": [real(n % 8000 / 1000), 1.5, -2.25, 0.0]}


def _assign_value(n: int, random: Random) -> Pins:
    operation = random.choice(("ARITHMETIC_ADD", "ARITHMETIC_ASSIGN"))
    return {"Operation": operation, "Variable1": n % 32, "ValueInteger": n}


def _read_variable(n: int, random: Random) -> Pins:
    return {"Variable": n % 32}


def _move_ptp(n: int, random: Random) -> Pins:
    return {
        "Point": _recent(n, random),
        "SpeedMode": "SPEED_DIRECT",
        "Speed": real((4000 + n % 6000) / 100),
    }


def _move_pulses(n: int, random: Random) -> Pins:
    return {"TargetPulses": _pulses(n)}


def _raw(n: int, random: Random) -> Pins:
    halves = [half for value in _pulses(n) for half in (value & 0xFFFF, value >> 16 & 0xFFFF)]
    return {"Code": 0x0100, "Data": [0, 20_000 + n % 9_999, 0, *halves]}


_STARTS: dict[str, _Start] = {
    "WritePoint": _write_point,
    "ReadPoint": _read_point,
    "WriteComment": _write_comment,
    "ReadComment": _read_point,
    "WriteShift": _write_shift,
    "AssignValue": _assign_value,
    "ReadVariable": _read_variable,
    "MovePtp": _move_ptp,
    "MovePulses": _move_pulses,
    "Raw": _raw,
    "Again": _raw,
}
_CALLS = ("CallMovePtp", "CallWritePoint", "CallJog", "CallPosition", "CallServoOn")

#: Maps an event at the controller to the event that ends it.
_EVENTS = (
    ("emergency_stop", "emergency_stop_release"),
    ("pendant_on", "pendant_off"),
    ("manual_mode", "auto_mode"),
    ("main_power_off", "main_power_on"),
    ("safety_on", "safety_off"),
    ("power_off", "power_on"),
    ("link_down", "link_up"),
    ("link_down", "link_up"),
)


class _Storm:
    """The generator of the events of one storm. `number` counts the requests of a run."""

    def __init__(self, conditions: Conditions, random: Random, number: int, length_us: int) -> None:
        self._conditions, self._random = conditions, random
        self._number, self._length_us = number, length_us

    def acts(self, pause_ms: int, roughness: float) -> Iterator[Entry]:
        random = self._random
        t_us = 0
        while t_us < self._length_us:
            t_us += random.randint(1, 2 * pause_ms) * 1000
            if random.random() < roughness:
                yield from self._trouble(t_us)
            elif random.random() < 0.2:
                yield from self._use(t_us)
            else:
                yield from self._start(t_us, random.choice(list(_STARTS)))

    def _start(self, t_us: int, block: str) -> Iterator[Entry]:
        """Yield a rising edge of Execute, and a falling edge one scan to 1.5 s later."""
        self._number += 1
        pins = _STARTS[block](self._number, self._random) if block in _STARTS else {}
        sets = {f"Main.{block}.{pin}": value for pin, value in pins.items()}
        yield _set(t_us, {**sets, f"Main.{block}.Execute": True})
        scan_us = self._conditions.timing.scan_us
        held_us = self._random.choice((scan_us, scan_us, 100_000, 400_000, 1_500_000))
        yield _set(t_us + held_us, {f"Main.{block}.Execute": False})

    def _use(self, t_us: int) -> Iterator[Entry]:
        """Yield events for sequence blocks, blocks with Enable, and general-purpose outputs."""
        random = self._random
        kind = random.randrange(8)
        if kind < 4:
            yield from self._start(t_us, random.choice(list(SEQUENCES)))
        elif kind == 4:
            word, bit = random.randrange(65536), random.random() < 0.5
            yield _set(t_us, {"Main.GeneralWord": word, "Main.GeneralBit": bit})
        elif kind == 5:
            sets: Pins = {
                "Main.Jog.Frame": random.choice(("JOG_PULSES", "JOG_CARTESIAN", "JOG_TOOL")),
                "Main.Jog.Axis": random.randint(1, 4),
                "Main.Jog.Direction": random.choice(("DIRECTION_PLUS", "DIRECTION_MINUS")),
            }
            yield from self._enable(t_us, "Jog", sets)
        elif kind == 6:
            unit = random.choice(("UNIT_PULSES", "UNIT_MM"))
            yield from self._enable(t_us, "Position", {"Main.Position.Unit": unit})
        else:
            yield from self._enable(t_us, random.choice(("SequenceControl", "AutoMode", "Watch")))

    def _enable(self, t_us: int, block: str, sets: Pins | None = None) -> Iterator[Entry]:
        yield _set(t_us, {**(sets or {}), f"Main.{block}.Enable": True})
        until_us = t_us + self._random.randint(1, 1500) * 1000
        yield _set(until_us, {f"Main.{block}.Enable": False})

    def _trouble(self, t_us: int) -> Iterator[Entry]:
        random = self._random
        lasts_us = random.choice((10, 60, 150, 400, 900)) * random.randint(500, 1000)
        kind = random.randrange(12)
        if kind < 4:
            yield self._packets(t_us, lasts_us)
        elif kind == 4:
            scan_us = self._conditions.timing.scan_us
            # If the overrun were longer, the PLC would not notice the loss of a connection.
            by = f"{random.randint(1, 95_000 - scan_us)}us"
            yield _event(t_us, "plc_overrun", by=by)
        elif kind == 5:
            pin = random.choice(("Main.EmergencyStopOk", "Main.StopOk"))
            yield _set(t_us, {pin: False})
            yield _set(t_us + lasts_us, {pin: True})
        elif kind == 6:
            call = f"Main.{random.choice(_CALLS)}"
            yield _set(t_us, {call: False})
            yield _set(t_us + lasts_us, {call: True})
        elif kind == 7:
            yield _event(t_us, "alarm", group=2, category=334)
        elif kind == 8 and random.random() < 0.5:
            off_us = random.randint(10, 600) * 1000
            yield replace(_event(t_us, "plc_power_off", start="cold"), held_us=off_us)
        elif kind == 9 and random.random() < 0.5:
            interval_us = random.choice(self._conditions.intervals_us)
            yield _event(t_us, "packet_interval", rpi=f"{interval_us}us")
        else:
            begin, end = random.choice(_EVENTS)
            yield _event(t_us, begin)
            yield _event(t_us + lasts_us, end)

    def _packets(self, t_us: int, lasts_us: int) -> Entry:
        random = self._random
        kind = random.choice(("lost", "late", "doubled"))
        to = random.choice(("both", "robot", "plc"))
        args: Pins = {"share": random.choice((0.1, 0.3, 0.6, 1.0)), "to": to}
        if kind != "lost":
            args["by"] = f"{self._conditions.late_us}us"
        return replace(_event(t_us, f"packets_{kind}", **args), held_us=lasts_us)


def _set(t_us: int, values: Pins) -> Entry:
    return Entry(t_us, values=values)


def _event(t_us: int, name: str, **args: Any) -> Entry:
    return Entry(t_us, events=((name, args),))


def _draw_storm(conditions: Conditions, seed: int, number: int) -> Storm:
    """Draw storm `number` of a run, with its events in chronological order."""
    random = Random(f"storm {seed} {number}")
    length_us = random.randint(3_000, 15_000) * 1000
    pause_ms = random.choice((15, 40, 100, 250))
    roughness = random.choice((0.01, 0.03, 0.1, 0.3))
    drawn = _Storm(conditions, random, 100_000 * (number % 200) + 1000, length_us)
    acts = sorted(drawn.acts(pause_ms, roughness), key=lambda act: act.t_us)
    return Storm([act for act in acts if act.t_us < length_us], length_us)


def draw_run(seed: int, storms: int) -> tuple[Conditions, list[Storm]]:
    """Draw the conditions and storms of a run."""
    conditions = _draw_conditions(seed)
    return conditions, [_draw_storm(conditions, seed, k) for k in range(storms)]
