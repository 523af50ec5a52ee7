"""The cell of a campaign: a program and a controller that records its executions."""

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
        timing: Scan, packets and their time-out, for the longest packet interval.
        intervals_us: The packet intervals that the run may change to.
        late_us: The greatest delay of a late packet.
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
    """A command that the controller has begun.

    Attributes:
        t_us: Time of the begin.
        words: Its telegram, n to n + 30.
        end: End status and response, m to m + 30; None until they are shown.
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
    """A controller with the list of its executions, which survives restarts.

    Args:
        config: Its properties.
        seed: Determines its delays.
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
        """Install the recording handshake: every start of the controller makes a new handshake."""
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
        self.plc.inputs_stay = False  # all variables belong to the program
