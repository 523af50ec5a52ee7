"""The cell of a campaign: a cell whose PLC can lose its power and whose network has faults."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.build import source_files
from rcx_harness.engine.base import Program
from rcx_harness.engine.load import build
from rcx_harness.verify.campaign.network import FaultAgenda, FaultLink, FaultNetwork
from rcx_harness.verify.campaign.recorder import RecordingController
from rcx_harness.watch.calls_source import steady_instances
from rcx_harness.watch.wire import WireMonitor
from rcx_tools.evidence.campaign.schedule import Act, Conditions

__all__ = ["Compiled", "Station"]

_PROGRAM = Path(__file__).parent / "Campaign.st"


class Compiled:
    """The campaign's program, compiled once, ready for its first scan again and again.

    Args:
        engine: `auto`, `matiec` or `builtin`.
        lib: Folder of the library; None for plc/lib.
    """

    def __init__(self, engine: str = "auto", lib: Path | None = None) -> None:
        files = source_files(_PROGRAM, lib)
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
    """The campaign's program and a controller that records, on a network with faults.

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
            m=8,
            n=16,
            seed=seed,
            trace=trace,
            steady=compiled.steady,
            agenda=self.clock,
        )
        assert link.made is not None
        self.network: FaultNetwork = link.made
        self["Main.WriteArea.Margin"] = f"T#{-(-conditions.margin_us // 1000)}ms"
        for block, timeout_ms in conditions.timeouts_ms.items():
            self[f"Main.{block}.Timeout"] = f"T#{timeout_ms}ms"
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
