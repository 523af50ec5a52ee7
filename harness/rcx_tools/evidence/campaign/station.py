"""The cell of a campaign: a program, and a controller that records the commands it executes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.clock import Timing
from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.link import DirectLink
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.robot.findings import Findings
from rcx_harness.robot.handshake import Handshake, Words
from rcx_harness.robot.machine import Machine

__all__ = ["Conditions", "Execution", "RecordingController", "Station"]


@dataclass(frozen=True)
class Conditions:
    """The constants of a run.

    Attributes:
        timing: Scan time, packet intervals and time-out. The time-out belongs to the longest
            interval.
        intervals_us: Packet intervals to which the run may change.
        late_us: Greatest delay of a late packet [us].
        robot: Properties of the controller.
        start: Variables of the program that are set before its first scan.
        m: First byte of the robot's area in `Main.InputArea`.
        n: First byte of the robot's area in `Main.OutputArea`.
    """

    timing: Timing
    intervals_us: tuple[int, ...]
    late_us: int
    robot: RobotConfig
    start: Mapping[str, Any] = field(default_factory=dict)
    m: int = 0
    n: int = 0


@dataclass
class Execution:
    """The execution of a command by the controller.

    Attributes:
        t_us: Time at which the command begins.
        words: Telegram of the command, n to n + 30.
        end: End status and response, m to m + 30. None until the controller shows them.
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
    """A controller that records its executions. The list survives restarts of the controller.

    Args:
        config: Properties of the controller.
        seed: Seed of the controller's random delays.
    """

    def __init__(self, config: RobotConfig | None = None, seed: int = 0) -> None:
        super().__init__(config, seed)
        self.executions: list[Execution] = []
        self._record()

    def inject(self, event: str, **args: Any) -> None:
        """Inject an event; see `Controller.inject`."""
        super().inject(event, **args)
        self._record()

    def _record(self) -> None:
        """Install a handshake that records.

        Every start of the controller makes a new handshake that does not record.
        """
        state = self._state
        if not isinstance(state.handshake, _Recording):
            state.handshake = _Recording(self.config, state.findings, self.executions)


class Station(Cell):
    """A program and a recording controller.

    Args:
        compiled: The program.
        conditions: The constants of the run.
        seed: Seed of all random choices.
        trace: File for the trace.
    """

    def __init__(
        self, compiled: Compiled, conditions: Conditions, seed: int, trace: Path | None = None
    ) -> None:
        program = compiled.fresh()
        self.recorder = RecordingController(conditions.robot, seed)
        super().__init__(
            program,
            self.recorder,
            DirectLink(),
            conditions.timing,
            m=conditions.m,
            n=conditions.n,
            seed=seed,
            trace=trace,
            steady=compiled.steady,
            leave=lambda: None,
        )
        for path, value in conditions.start.items():
            self[path] = value
        self.plc.beginning = program.snapshot()
        self.plc.inputs_stay = False  # a cold start also resets the inputs of the program
