"""A virtual controller that keeps a list of the commands it has executed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.robot.findings import Findings
from rcx_harness.robot.handshake import Handshake, Words
from rcx_harness.robot.machine import Machine

__all__ = ["Execution", "RecordingController"]


@dataclass
class Execution:
    """A command that the controller has begun.

    Attributes:
        t_us: When.
        words: Its telegram, n to n + 30.
        end: End status and response, m to m + 30; None as long as none was shown.
    """

    t_us: int
    words: Words
    end: Words | None = None


class _Recording(Handshake):
    def __init__(self, config: RobotConfig, findings: Findings, log: list[Execution]) -> None:
        super().__init__(config, findings)
        self._log = log

    def _begin(self, machine: Machine) -> None:
        self._log.append(Execution(machine.now_us, self._taken))
        super()._begin(machine)

    def _end(self, status: int, response: Words) -> None:
        super()._end(status, response)
        self._log[-1].end = (status, *response)


class RecordingController(Controller):
    """A controller with the list of what it has executed, also before a restart.

    Args:
        config: Its properties.
        seed: Decides its delays.
    """

    def __init__(self, config: RobotConfig | None = None, seed: int = 0) -> None:
        super().__init__(config, seed)
        self.executions: list[Execution] = []
        self._record()

    def inject(self, event: str, **args: Any) -> None:
        """Let something happen; see `Controller.inject`."""
        super().inject(event, **args)
        self._record()

    def _record(self) -> None:
        """Every start of the controller makes a handshake of its own."""
        state = self._state
        if not isinstance(state.handshake, _Recording):
            state.handshake = _Recording(self.config, state.findings, self.executions)
