"""The cyclic exchange: read the PLC and the robot, decide, and write to both of them."""

from __future__ import annotations

from collections.abc import Callable

from rcx_harness.bridge.core import (
    Actions,
    Bridge,
    Limits,
    Lost,
    PlcSeen,
    Registers,
    State,
    area_of,
)
from rcx_harness.bridge.figures import Figures
from rcx_harness.bridge.plc import PlcError, PlcLink
from rcx_harness.enip.cyclic.shared import now_us
from rcx_harness.enip.originator.persistent_connection import PersistentConnection

__all__ = ["Loop", "RobotLink"]

_RETRY_US = 500_000
_VALID_GAPS = 2
"""If the loop writes no new data for this multiple of `gap_us`, the packets to the robot end. The
bridge's process then hangs, so the outputs of the PLC are unknown."""


class RobotLink(PersistentConnection):
    """The exclusive-owner connection to the robot."""

    def read(self) -> bytes | Lost:
        """Return the latest area from the robot, or the reason of its loss."""
        received = self.received()
        return Lost(received) if isinstance(received, str) else received.image


class Loop:
    """The exchange between both sides: each call of `turn` is one exchange.

    A call blocks only until the PLC answers.

    Args:
        on_state: Function that is called with the new state and its reason at each change of state.
    """

    def __init__(
        self,
        plc: PlcLink,
        robot: RobotLink,
        registers: Registers,
        limits: Limits,
        on_state: Callable[[State, str], None] = lambda state, reason: None,
        clock_us: Callable[[], int] = now_us,
    ) -> None:
        self._plc, self._robot = plc, robot
        self._words = registers.words
        self._bridge = Bridge(registers.size, limits)
        self._valid_us = _VALID_GAPS * limits.gap_us
        self._on_state = on_state
        self._clock_us = clock_us
        self._failure: str | None = None
        self._retry_us = 0
        self._told: tuple[State, str] | None = None
        self.state, self.reason = State.NO_PLC, "not asked yet"
        self.figures = Figures()

    def turn(self) -> Actions:
        """Read the PLC and the robot, decide, and write to both of them."""
        asked_us = self._clock_us()
        plc = self._look_at_plc(asked_us)
        actions = self._bridge.step(self._clock_us(), plc, self._robot.read())
        # Zeros are safe and stay valid. The PLC's words expire, so that the robot stops if this
        # process hangs.
        valid_us = self._valid_us if actions.state is State.RUN else None
        self._robot.write(actions.to_robot, valid_us)
        self._tell(actions)
        if isinstance(plc, PlcSeen):
            try:
                self._plc.write((*actions.to_plc, actions.life))
            except PlcError as error:
                self._fail(error)
            else:
                ended_us = self._clock_us()
                self.figures.add(ended_us, ended_us - asked_us)
        return actions

    def end(self) -> None:
        """Write zeros to each side that can be reached."""
        nothing = (0,) * (self._words + 1)
        self._robot.write(area_of(nothing[:-1]), None)
        if self._plc.connected:
            try:
                self._plc.write(nothing)
            except PlcError as error:
                self._fail(error)

    def _look_at_plc(self, asked_us: int) -> PlcSeen | Lost:
        # Report a failed write before anything that can block, so that the robot gets zeros at
        # once.
        failure, self._failure = self._failure, None
        if failure is not None:
            return Lost(failure)
        try:
            if not self._plc.connected:
                if asked_us < self._retry_us:
                    return Lost(self.reason)
                self._plc.connect()
            words = self._plc.read()
        except PlcError as error:
            self._retry_us = self._clock_us() + _RETRY_US
            return Lost(str(error))
        return PlcSeen(area_of(words[: self._words]), words[self._words], asked_us)

    def _fail(self, error: PlcError) -> None:
        self._failure = str(error)
        self._retry_us = self._clock_us() + _RETRY_US

    def _tell(self, actions: Actions) -> None:
        self.state, self.reason = actions.state, actions.reason
        told = (actions.state, actions.reason if actions.state in _REASONS_COUNT else "")
        if told != self._told:
            self._told = told
            self._on_state(actions.state, actions.reason)


#: The states in which a new reason is reported. In all other states only a number in the reason
#: changes.
_REASONS_COUNT = (State.NO_PLC, State.NO_ROBOT, State.CLEARING)
