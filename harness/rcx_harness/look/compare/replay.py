"""The replay of a recording: the virtual controller with the recorded input of the PLC."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

from rcx_harness.look.compare.channels import (
    RESPONSE,
    STATUS,
    Channel,
    Difference,
    Timeline,
    channels,
    differences,
)
from rcx_harness.look.compare.delays import Drawn, Guide, asked
from rcx_harness.look.compare.recording import Recording
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.robot.alarms import EMERGENCY_STOP
from rcx_harness.spec.wire import CYCLE_US, DEDICATED_AT, RESERVED_AT, SIZE

__all__ = ["Happening", "Replay", "Replayed", "watched"]

#: Alarm that turns SO(03) ON if a recording begins with SO(03) ON and without a number.
_UNKNOWN_ALARM = "99.999"
#: If a recording does not begin at power-on, the controller first runs this number of cycles with
#: the first image, so that its state settles before the comparison.
_SETTLE_CYCLES = 200
_READ = "read by the controller"
_KEYS = frozenset(entry.name for entry in fields(RobotConfig))


@dataclass(frozen=True)
class Happening:
    """An event that the recording does not contain, with its time [us] and arguments."""

    t_us: int
    event: str
    args: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Replayed:
    """The result of a replay.

    Attributes:
        outputs: Changes of the area from the virtual controller, with their times.
        differences: Differences from the recording, without the expected differences.
        until_us: Time of the first difference, or of the end.
        read: Keys of the configuration that were read, if this was observed.
        alarms: Numbers of all alarms that were raised.
    """

    outputs: Sequence[tuple[int, bytes]]
    differences: Sequence[Difference]
    drawn: Sequence[Drawn]
    until_us: int
    read: frozenset[str]
    alarms: frozenset[str]

    @property
    def first_us(self) -> int | None:
        """Return the time of the first difference; None if there is none."""
        return self.differences[0].begin_us if self.differences else None


class _Watched(RobotConfig):
    """A configuration that records the names of the keys that are read."""

    def __getattribute__(self, name: str) -> Any:
        if name in _KEYS:
            vars(self).setdefault(_READ, set()).add(name)
        return super().__getattribute__(name)


def watched(config: RobotConfig) -> RobotConfig:
    """Return a copy of the configuration that records its reads for `Replayed.read`."""
    return _Watched(**{name: getattr(config, name) for name in _KEYS})


class Replay:
    """A recording that can be replayed with different configurations.

    Args:
        happenings: Events that the recording does not contain.
    """

    def __init__(self, recording: Recording, happenings: Sequence[Happening] = ()) -> None:
        self.recording = recording
        self.channels = channels(recording.size)
        self.recorded = {one.name: Timeline.of(one, recording.outputs) for one in self.channels}
        self._asked = asked(recording.inputs)
        self._happenings = sorted(happenings, key=lambda one: one.t_us)
        self._cycles = recording.cycles()
        self.span = (self._cycles[0], recording.end_us)

    def run(
        self,
        config: RobotConfig,
        *,
        free: frozenset[str] = frozenset(),
        expected: Collection[Difference] = (),
        to_first: bool = False,
    ) -> Replayed:
        """Replay with a configuration.

        The delays in `free` follow the recording instead of the configuration. A difference is
        ignored if `expected` contains a difference with the same channel and beginning. With
        `to_first`, a replay of a recording with exact times ends at the first difference.
        """
        vars(config).pop(_READ, None)
        controller = Controller(config)
        if not self.recording.from_power_on:
            self._begin(controller)
        known = {(one.channel, one.begin_us) for one in expected}
        watch = _Watch(self, known) if to_first and not self.recording.tolerance_us else None
        guide = Guide(controller, self.recorded, self._asked, free)
        outputs: list[tuple[int, bytes]] = []
        last = b""
        until_us = self.span[1]
        inputs, at_input = self.recording.inputs, 0
        happenings, at_happening = self._happenings, 0
        si: bytes | None = None
        for now_us in self._cycles:
            while at_input < len(inputs) and inputs[at_input][0] <= now_us:
                si = inputs[at_input][1]
                at_input += 1
            while at_happening < len(happenings) and happenings[at_happening].t_us <= now_us:
                one = happenings[at_happening]
                controller.inject(one.event, **one.args)
                at_happening += 1
            so = controller.cycle(now_us, si)
            if so != last:
                outputs.append((now_us, so))
                last = so
            if watch is not None and watch.differs(now_us, so):
                until_us = now_us + 1
                break
        read = frozenset(vars(config).get(_READ, ()))
        return Replayed(
            outputs=outputs,
            differences=self._differences(outputs, until_us, known),
            drawn=guide.drawn,
            until_us=until_us,
            read=read,
            alarms=frozenset(one.number for one in controller.alarms.history),
        )

    def _differences(
        self, outputs: Sequence[tuple[int, bytes]], until_us: int, known: set[tuple[str, int]]
    ) -> list[Difference]:
        found: list[Difference] = []
        span = (self.span[0], until_us)
        for channel in self.channels:
            virtual = Timeline.of(channel, outputs)
            recorded = self.recorded[channel.name]
            if recorded.times == virtual.times and recorded.values == virtual.values:
                continue
            tolerance_us = self.recording.tolerance_us
            found += differences(channel, recorded, virtual, span, tolerance_us)
        every = (one for one in found if (one.channel, one.begin_us) not in known)
        order = [channel.name for channel in self.channels]
        return sorted(every, key=lambda one: (one.begin_us, order.index(one.channel)))

    def _begin(self, controller: Controller) -> None:
        """Bring the controller to the state that the recording shows at its beginning."""
        begin_us = self.span[0]
        si = next((one for t_us, one in reversed(self.recording.inputs) if t_us <= begin_us), None)
        so = bytearray(self.recording.size)
        for t_us, area in self.recording.outputs:
            if t_us <= begin_us:
                so[:] = area
        shown = {one.name: one.of(bytes(so)) for one in self.channels}
        machine = controller.machine
        for number in range(_SETTLE_CYCLES, 0, -1):
            controller.cycle(begin_us - number * CYCLE_US, si)
        on = {name for name, value in shown.items() if value}
        machine.hard_wired_stop = "SO00" in on and machine.si00
        machine.emergency = "SO00" in on
        machine.main_power = "SO04" in on or "SO00" in on
        machine.alarms.warning = "SO15" in on
        if ("SO10" in on) != machine.auto_mode:
            machine.auto_input = machine.auto_mode = "SO10" in on
            machine.manual_lock = "SO10" not in on
        if ("SO11" in on) != machine.origin_complete:
            machine.origins.complete[:] = [("SO11" in on)] * len(machine.origins.complete)
        machine.alarms.active.clear()
        if "SO03" in on:
            alarm = EMERGENCY_STOP if "SO00" in on else _UNKNOWN_ALARM
            machine.alarms.activate(alarm, machine.now_us, serious=True)
        if "SO02" in on:
            machine.servos.switch_all_on()
        else:
            machine.servos.switch_all_off()
        if "SO13" in on and not machine.program.running:
            machine.program.order_start(None)
            machine.program.start(begin_us)
        machine.program.is_reset = "SO14" in on
        machine.sequence_running = "SO12" in on
        machine.ports.outputs[DEDICATED_AT + 2 : RESERVED_AT] = so[DEDICATED_AT + 2 : RESERVED_AT]
        machine.ports.outputs[SIZE:] = so[SIZE:]
        if not shown[STATUS] and shown[RESPONSE]:
            machine.ports.outputs[4:DEDICATED_AT] = so[4:DEDICATED_AT]
        machine.pending.clear()
        controller.origins  # noqa: B018 - reading them makes the next cycle a full cycle


class _Watch:
    """The search for the first cycle that differs from an exact recording."""

    def __init__(self, replay: Replay, known: set[tuple[str, int]]) -> None:
        self._outputs = replay.recording.outputs
        self._channels: tuple[Channel, ...] = replay.channels
        self._known, self._open = known, set[str]()
        self._at, self._recorded = 0, b""
        self._same: tuple[bytes, bytes] = (b"", b"")

    def differs(self, now_us: int, so: bytes) -> bool:
        """Return whether the output of a cycle has a difference that is not expected."""
        outputs = self._outputs
        while self._at < len(outputs) and outputs[self._at][0] <= now_us:
            self._recorded = outputs[self._at][1]
            self._at += 1
        if so == self._recorded:
            self._open.clear()
            return False
        if (so, self._recorded) == self._same:
            return False
        self._same = (so, self._recorded)
        for channel in self._channels:
            name = channel.name
            if channel.of(so) == channel.of(self._recorded):
                self._open.discard(name)
            elif name not in self._open:
                if (name, now_us) not in self._known:
                    return True
                self._open.add(name)
        return False
