"""The cell of a campaign: a PLC that can lose its power, a network with faults, and notes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from rcx_harness.cell import Cell
from rcx_harness.cell.build import source_files
from rcx_harness.cell.clock import Timing
from rcx_harness.engine.base import Program
from rcx_harness.engine.load import build
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.robot.findings import Findings
from rcx_harness.robot.handshake import Handshake, Words
from rcx_harness.robot.machine import Machine
from rcx_harness.watch.calls_source import steady_instances
from rcx_harness.watch.wire import WireMonitor
from rcx_tools.evidence.campaign.network import FaultAgenda, FaultLink, FaultNetwork

__all__ = ["Act", "Compiled", "Conditions", "Execution", "RecordingController", "Station"]


class Act(NamedTuple):
    """One thing that happens: when [us from the storm's begin], which kind, and its details."""

    t_us: int
    kind: str
    details: dict[str, Any]

    def __str__(self) -> str:
        shown = ", ".join(f"{name} = {value}" for name, value in self.details.items())
        return f"{self.t_us / 1000:9.1f} ms  {self.kind}: {shown}"


@dataclass(frozen=True)
class Conditions:
    """What stays the same in a run.

    Attributes:
        timing: Scan, packets and their time-out, for the longest packet interval.
        intervals_us: The packet intervals that the run may change to.
        latest_us: No packet arrives later than this.
        robot: Properties of the controller.
        start: Variables of the program that are set before its first scan.
        m: First byte of the robot's area in `Main.InputArea`.
        n: The same in `Main.OutputArea`.
    """

    timing: Timing
    intervals_us: tuple[int, ...]
    latest_us: int
    robot: RobotConfig
    start: Mapping[str, Any] = field(default_factory=dict)
    m: int = 0
    n: int = 0


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


class Compiled:
    """A program, compiled once, ready for its first scan again and again.

    Args:
        program: Its file.
        engine: `auto`, `matiec` or `builtin`.
        lib: Folder of the library; None for the one that comes with the harness.
    """

    def __init__(self, program: Path, engine: str = "auto", lib: Path | None = None) -> None:
        files = source_files(program, lib)
        built = build(files.all, engine)
        self.program: Program = built.program
        self.notice = built.notice
        self.steady = steady_instances(files.own, files.lib)
        self._first = self.program.snapshot()

    def fresh(self) -> Program:
        """The program before its first scan."""
        self.program.restore(self._first)
        return self.program


class Station(Cell):
    """A program and a controller that records, on a network with faults.

    Args:
        compiled: The program.
        conditions: What stays the same in the run.
        seed: Of everything that is drawn.
        trace: File for the trace.
    """

    def __init__(
        self, compiled: Compiled, conditions: Conditions, seed: int, trace: Path | None = None
    ) -> None:
        timing = conditions.timing
        program = compiled.fresh()
        link = FaultLink(timing, seed, conditions.latest_us)
        self.clock = FaultAgenda()
        self.recorder = RecordingController(conditions.robot, seed)
        super().__init__(
            program,
            self.recorder,
            link,
            timing,
            m=conditions.m,
            n=conditions.n,
            seed=seed,
            trace=trace,
            steady=compiled.steady,
            agenda=self.clock,
        )
        assert link.made is not None
        self.network: FaultNetwork = link.made
        for path, value in conditions.start.items():
            self[path] = value
        self._start = program.snapshot()
        self._quiet_contract: Any = self._contract.snapshot()
        self._powered = True
        self._plugged = True

    def apply(self, act: Act) -> None:
        """Let it happen now."""
        details = act.details
        if act.kind == "set":
            for path, value in details.items():
                self[path] = value
        elif act.kind == "event":
            arguments = {name: value for name, value in details.items() if name != "name"}
            self.inject(details["name"], **arguments)
        elif act.kind == "packets":
            until_us = self.now_us - act.t_us + details["until_us"]
            for direction in details["directions"]:
                self.network.fault(details["what"], direction, details["share"], until_us)
        elif act.kind == "overrun":
            self.clock.overrun_us = details["us"]
        elif act.kind == "interval":
            self.timing = replace(self.timing, rpi_us=details["us"])
            self.network.change_interval(self.timing)
        else:
            self._lose_plc_power(details["off_us"])

    def close(self) -> None:
        """Write out the trace; the program is that of all runs."""
        self.trace.close()

    def inject(self, event: str, **args: Any) -> None:
        """Let something happen now; a cable that is plugged in does not help a PLC that is off."""
        if event in ("link_down", "link_up"):
            self._plugged = event == "link_up"
        if event != "link_up" or self.plc_on:
            super().inject(event, **args)

    @property
    def plc_on(self) -> bool:
        """The PLC has power."""
        return self._powered

    def _lose_plc_power(self, off_us: int) -> None:
        """The PLC is off until its scanner has lost the connection, or longer."""
        if not self.plc_on:
            return
        self._powered = False
        self.network.set_cable(False)
        lost_us = self.timing.timeout_us + 20_000
        self.at(self.now_us + max(off_us, lost_us), self._restart_plc)

    def _restart_plc(self) -> None:
        self._powered = True
        self.program.restore(self._start)
        self._contract.restore(self._quiet_contract)
        self._first.wire = WireMonitor()
        self.network.set_cable(self._plugged)
        self.on_restart()

    def on_restart(self) -> None:
        """The PLC has started anew; a hook for who follows the blocks."""

    def _scan(self, now: int) -> None:
        if self.plc_on:
            super()._scan(now)
