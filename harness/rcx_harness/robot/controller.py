"""The virtual controller. Each call of `cycle` runs one controller cycle of 5 ms."""

from __future__ import annotations

import copy
from typing import Any

from rcx_harness.robot.alarms import AlarmList
from rcx_harness.robot.area import Overlay, build_area, input_words
from rcx_harness.robot.commands import perform
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.dedicated import DedicatedInputs
from rcx_harness.robot.events import happen
from rcx_harness.robot.findings import Findings
from rcx_harness.robot.handshake import Handshake
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.ports import port
from rcx_harness.robot.signals import (
    REQUESTS,
    Led,
    dedicated_outputs,
    lose_link,
    module_led,
    network_led,
    regain_link,
)
from rcx_harness.robot.stored import Point, fits_integer
from rcx_harness.robot.tasks import Programs
from structured_text.errors import InputError, Violation

__all__ = ["Controller"]


class _State:
    """The complete changing state of a controller; a deep copy of it is a snapshot."""

    def __init__(self, config: RobotConfig, seed: int) -> None:
        self.machine = Machine(config, seed, perform)
        self.findings = Findings()
        self.overlay = Overlay(config.size)
        self.now_us = 0
        self.forget_master()

    def forget_master(self) -> None:
        """Reset all state that came from the master to its state after power-on."""
        config = self.machine.config
        self.inputs = DedicatedInputs(config, self.findings)
        self.handshake = Handshake(config, self.findings)
        self.was_connected: bool | None = None  # None: no check since power-on
        self.seen: bytes | None = None
        self.area = bytes(config.size)
        # time of the next cycle that has work to do without a new image
        self.wake_us: int | None = 0


class Controller:
    """A robot controller with its EtherNet/IP areas, without the network.

    The same sequence of calls always gives the same bytes.

    Args:
        seed: Seed of the random numbers. It determines each delay that is configured as a range.
    """

    def __init__(self, config: RobotConfig | None = None, seed: int = 0) -> None:
        self.config = config or RobotConfig()
        self._state = _State(self.config, seed)

    def cycle(self, now_us: int, si: bytes | None) -> bytes:
        """Run one controller cycle.

        Args:
            now_us: Time of the cycle, later than the time of the previous cycle [us].
            si: The input area from the master (bytes n to n + size - 1); None without a connection.

        Returns:
            The output area of the controller (bytes m to m + size - 1).
        """
        state = self._state
        state.now_us = now_us
        # Skip idle cycles: the image has not changed, and the controller has nothing due. The
        # result is the same as that of a full cycle. Random delays are drawn only when an answer is
        # scheduled, so skipping does not shift later draws. Every method that changes the state
        # from outside sets `wake_us` to 0, and the next cycle is then executed.
        if si == state.seen and (state.wake_us is None or now_us < state.wake_us):
            return state.area
        if si is not None and len(si) != self.config.size:
            message = f"the area has {self.config.size} bytes, not {len(si)}"
            raise InputError(message, hint="set the same size at master and robot")
        machine = state.machine
        seen = si
        if self.config.ip_address != "set":
            si = None
        machine.now_us = now_us
        was_booted = machine.booted
        if machine.booted:
            self._take_inputs(si)
        if machine.powered:
            machine.advance(now_us)
        if si is not None and machine.booted and was_booted:
            state.handshake.step(machine, input_words(si))
        state.seen = None if seen is None else bytes(seen)
        state.wake_us = now_us if machine.booted != was_booted else self._next_due_us()
        state.area = self._build_area()
        return state.area

    @property
    def positions(self) -> list[int]:
        """Return the current position of every axis [pulses]; the list may be changed."""
        return self._state.machine.positions

    @property
    def workpieces(self) -> dict[int, int]:
        """Return the positions of the workpieces for PUSH [pulses], by axis; may be changed."""
        return self._state.machine.motion.workpieces

    def place_workpiece(self, axis: int, pulses: int | None) -> None:
        """Place a workpiece at a position at which PUSH stops; None removes the workpiece.

        `axis` counts from 1 over all axes of the controller.
        """
        count = len(self.config.axes)
        if not isinstance(axis, int) or isinstance(axis, bool) or not 1 <= axis <= count:
            raise InputError(f"there is no axis {axis}", hint=f"use 1 to {count}")
        if pulses is None:
            self.workpieces.pop(axis - 1, None)
        elif not isinstance(pulses, int) or isinstance(pulses, bool) or not fits_integer(pulses):
            raise InputError("a workpiece stands at -2147483648 to 2147483647 pulses")
        else:
            self.workpieces[axis - 1] = pulses
        self._state.wake_us = 0

    @property
    def points(self) -> dict[int, Point]:
        """Return the stored points by number; the caller may change the mapping."""
        return self._state.machine.points

    @property
    def alarms(self) -> AlarmList:
        """Return the active alarms and the alarm history."""
        return self._state.machine.alarms

    @property
    def program(self) -> Programs:
        """Return the object with all robot programs, their ports and their variables."""
        return self._state.machine.program

    @property
    def origins(self) -> list[bool]:
        """Return for each axis whether its return-to-origin is complete.

        The list may be changed, as from the programming box.
        """
        self._state.wake_us = 0
        return self._state.machine.origins.complete

    @property
    def online(self) -> bool:
        """Return whether the adapter answers: it must have booted and have a unique IP address."""
        return self._state.machine.booted and self.config.ip_address == "set"

    @property
    def module_led(self) -> Led:
        """Return the state of the Module Status LED."""
        return module_led(self._state.machine)

    @property
    def network_led(self) -> Led:
        """Return the state of the Network Status LED."""
        return network_led(self._state.machine)

    def read_port(self, name: str) -> int:
        """Read a port as a robot program does, for example `SI(20)`, `SIW(2)` or `DO(20)`."""
        return self.machine.ports.read(port(name))

    def write_port(self, name: str, value: int) -> None:
        """Write an output as a robot program does: `SO(20)`, `SO2()`, `SOW(2)` or `SOD(2)`.

        If the value is too long, only its lower bits are written. While a response of a remote
        command uses a shared word, the written value is not visible.
        """
        self.machine.ports.write(port(name), value)
        self._state.wake_us = 0

    @property
    def handshake(self) -> Handshake:
        """Return the state of the remote-command handshake."""
        return self._state.handshake

    @property
    def machine(self) -> Machine:
        """Return the complete state from which the areas are made."""
        return self._state.machine

    @property
    def commands_executed(self) -> int:
        """Return the number of remote commands that have ended (normally or not) since power-on."""
        return self._state.handshake.executed

    @property
    def violations(self) -> list[Violation]:
        """Return all violations of the manual by the master."""
        return self._state.findings.every

    def drain_violations(self) -> list[Violation]:
        """Return the violations that are new since the last call."""
        return self._state.findings.drain()

    def inject(self, event: str, **args: Any) -> None:
        """Inject an event, which takes effect before the next cycle.

        EVENTS has the names of all events.
        """
        state = self._state
        state.machine.now_us = state.now_us
        was_powered = state.machine.powered
        happen(state.machine, event, args)
        if event == "power_cycle":
            state.machine.power_on()
        if event == "power_cycle" or was_powered != state.machine.powered:
            state.forget_master()
        state.wake_us = 0

    def hold(self, name: str) -> None:
        """Hold an output (`SO02`, `SOW(2)`, or `Status` with its response) at its current value."""
        self._state.overlay.freeze(name, self._state.area)

    def force(self, name: str, value: int) -> None:
        """Force an output to `value`; `Status` is forced alone, without the response."""
        self._state.overlay.set("SOW(0)" if name == "Status" else name, value)
        self._state.wake_us = 0

    def release(self, name: str) -> None:
        """End the effect of `hold` or `force` on an output."""
        for one in ("Status", "SOW(0)") if name == "Status" else (name,):
            self._state.overlay.remove(one)
        self._state.wake_us = 0

    @property
    def held(self) -> list[str]:
        """Return the names of the held or forced outputs, as given by the caller."""
        return self._state.overlay.names

    def snapshot(self) -> object:
        """Return the complete state as a value for `restore`."""
        return copy.deepcopy(self._state)

    def restore(self, snapshot: object) -> None:
        """Restore the state of a snapshot. The snapshot can be used any number of times.

        Raises:
            InputError: the snapshot was made by a controller with another configuration.
        """
        if not isinstance(snapshot, _State) or snapshot.machine.config != self.config:
            raise InputError("this snapshot is from a controller with another configuration")
        self._state = copy.deepcopy(snapshot)

    def _take_inputs(self, si: bytes | None) -> None:
        """Process the levels and edges of the dedicated inputs; None means no connection."""
        state, machine = self._state, self._state.machine
        if si is None:
            if state.was_connected is not False:
                lose_link(machine, in_operation=bool(state.was_connected))
                state.inputs.disconnect()
                state.handshake.disconnect(machine)
                state.was_connected = False
            return
        if not state.was_connected:
            regain_link(machine)
            state.handshake.connect(input_words(si))
            state.was_connected = True
        machine.ports.inputs = bytes(si)
        edges = state.inputs.take(state.now_us, si)
        disabled = machine.inputs_disabled
        if not disabled or self.config.safety_keeps_stops:
            machine.si00 = state.inputs.is_on("SI00")
            machine.si06 = state.inputs.is_on("SI06")
        config = self.config
        disabled |= config.parallel_disables_si and config.parallel_io != "none"
        machine.si10 = state.inputs.is_on("SI10") and not disabled
        if edges and not disabled:
            for name in sorted(edges & REQUESTS.keys()):
                REQUESTS[name](machine)

    def _next_due_us(self) -> int | None:
        state = self._state
        machine_us = state.machine.next_due_us()
        if machine_us == state.now_us:
            return machine_us  # no event can be due before the next cycle
        due = (
            machine_us,
            state.inputs.next_due_us(),
            state.handshake.next_due_us(state.now_us),
        )
        return min((time for time in due if time is not None), default=None)

    def _build_area(self) -> bytes:
        state = self._state
        if not state.machine.booted:
            return bytes(self.config.size)
        words = state.handshake.shown
        if words[0] == 0 and self.config.program_words_between_commands:
            words = words[:2]
        machine = state.machine
        area = build_area(machine.ports.outputs, words, dedicated_outputs(machine))
        machine.data.real_time.lay_over(area)
        state.overlay.apply(area)
        return bytes(area)
