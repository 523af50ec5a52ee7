"""A run of the campaign: storms, each followed by recovery to a working cell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.link import PacketNetwork
from rcx_harness.cell.sources import source_files
from rcx_harness.cell.stimulus import Entry
from rcx_harness.spec.wire import SIZE
from rcx_harness.trace import Record, Scan
from rcx_harness.verify.storm.storms import Storm, StormRun
from rcx_tools.evidence.campaign.commands import COMMANDS
from rcx_tools.evidence.campaign.judge import SEQUENCES, Judge
from rcx_tools.evidence.campaign.outcome import Outcome
from rcx_tools.evidence.campaign.station import Conditions, Station
from structured_text.errors import InputError

__all__ = ["compiled", "run_storms"]

_PROGRAM = Path(__file__).parent / "Campaign.st"

#: Longest time from the end of all causes until the cell is at rest [us]. It covers the longest
#: Timeout of each stage of FB_PowerUp that may still wait, and the queued commands.
QUIET_US = 30_000_000
#: Longest permitted time of the documented recovery [us].
RECOVERY_US = 20_000_000
#: Time that the resting cell is observed [us]: nothing may start by itself.
_REST_US = 500_000

_LEVELS = ("Jog", "Position", "SequenceControl", "AutoMode", "Watch")
_CALLS = ("CallMovePtp", "CallWritePoint", "CallJog", "CallPosition", "CallServoOn")
_PACKETS = ("packets_lost", "packets_late", "packets_doubled")
_CALM = (
    *("power_on", "link_up", "emergency_stop_release", "pendant_off", "auto_mode"),
    *("main_power_on", "safety_off"),
)


def compiled(engine: str = "auto", lib: Path | None = None) -> Compiled:
    """Return the compiled program. `lib` is the folder of the library. None means plc/lib."""
    return Compiled(source_files(_PROGRAM, lib), engine)


def run_storms(
    program: Compiled,
    conditions: Conditions,
    storms: Sequence[Storm],
    seed: int,
    *,
    trace: Path | None = None,
    listener: Callable[[Record], None] | None = None,
) -> Outcome:
    """Run the storms one after the other, and after each wait for rest and recover.

    Raises:
        Failure: the first error that is found.
    """
    station = Station(program, conditions, seed, trace)
    with station:
        if listener is not None:
            station.trace.listen(listener)
        run = _Run(station)
        run.of(storms)
        return run.outcome


class _Run(StormRun):
    def __init__(self, station: Station) -> None:
        super().__init__(station)
        self.station = station
        self.outcome = Outcome()
        self._serial = 0
        self._last = Scan(0, 0, bytes(SIZE), bytes(SIZE))
        self.judge = Judge(station.program, self.note)
        self.outcome.ends, self.outcome.done = self.judge.ends, self.judge.done
        station.trace.listen(self.judge.take)
        station.trace.listen(self._listen)
        station.plc.on_start.append(self.judge.restart)

    def _listen(self, record: Record) -> None:
        if isinstance(record, Scan):
            self._last = record

    def apply(self, act: Entry) -> None:
        """Apply an event now. If the PLC has no power, its variables are not set."""
        self.outcome.take(act)
        if self.station.plc.runs or not act.values:
            super().apply(act)

    def weathered(self) -> None:
        """Record the figures of a storm that has ended."""
        outcome, station = self.outcome, self.station
        network = station.network_of(1)
        assert isinstance(network, PacketNetwork)
        outcome.storms += 1
        outcome.virtual_us, outcome.scans = station.now_us, station.scans
        outcome.packets = network.disturbed

    # --- rest --------------------------------------------------------------------------------

    def come_to_rest(self) -> None:
        """Remove all causes and inputs; check that everything ends and nothing starts by itself."""
        station = self.station
        for block in [*SEQUENCES, *COMMANDS]:
            station[f"Main.{block}.Execute"] = False
        for block in _LEVELS:
            station[f"Main.{block}.Enable"] = False
        for name in (*_CALLS, "EmergencyStopOk", "StopOk"):
            station[f"Main.{name}"] = True
        for event in _CALM:
            station.inject(event)
        for event in _PACKETS:
            station.inject(event, share=0)
        # If the last packets of a connection were lost, the loss may be detected only now.
        unseen_us = 2 * station.timing.timeout_us
        station.run(unseen_us)
        took_us = self.wait(self._rests, QUIET_US, "not at rest", self._what_is_busy)
        self.outcome.longest_quiet_us = max(self.outcome.longest_quiet_us, unseen_us + took_us)
        sent = station.commands
        station.run(_REST_US)
        if station.commands != sent or not self._rests():
            self.fail("starts by itself", f"after the cell was at rest: {self._what_is_busy()}")
        self._settle()

    def _rests(self) -> bool:
        """Return whether link and controller are ready, and no block is busy or has a turn."""
        read = self.station.program.read
        if self.judge.busy or not read("Main.Robot.Connected"):
            return False
        free = all(
            read(f"Main.Robot.Inner.{turn}.Serving") == read(f"Main.Robot.Inner.{turn}.NextTicket")
            for turn in ("Command", "Sequence")
        )
        ready = read("Main.Robot.Inner.Phase") == "PHASE_READY" and read("Main.Robot.Settled")
        return free and ready and bool(read("Main.Robot.SO.SO01_CpuOk"))

    def _what_is_busy(self) -> str:
        read = self.station.program.read
        robot = {name: read(f"Main.Robot.{name}") for name in ("Connected", "Status")}
        robot["Phase"] = read("Main.Robot.Inner.Phase")
        turns = {name: read(f"Main.Robot.Inner.{name}") for name in ("Command", "Sequence")}
        return f"busy: {', '.join(self.judge.busy) or 'none'}; {robot}; {turns}"

    def _settle(self) -> None:
        executions = self.station.recorder.executions
        self.outcome.executions += len(executions)
        self.outcome.requests += self.judge.settle(executions)
        self.check()

    # --- recovery ----------------------------------------------------------------------------

    def recover(self) -> None:
        """Follow the documented recovery: reset the alarm, switch the servo on, do some work."""
        begin_us, read = self.station.now_us, self.station.program.read
        if read("Main.Robot.Inner.HoldEmergency"):
            self._do("FromEmergency")
        if self._on(0, 3):
            self._do("AlarmReset")
        if not self._on(0, 2):
            self._do("ServoOn")
        if read("Main.Robot.Inner.HoldStop"):
            self._do("ProgramContinue")
        if not self._on(1, 1):
            self._stop_program()
            self._do("ReturnToOrigin")
        self._work()
        took_us = self.station.now_us - begin_us
        self.outcome.longest_recovery_us = max(self.outcome.longest_recovery_us, took_us)
        self._settle()
        self.wait(self._rests, QUIET_US, "not at rest", self._what_is_busy)

    def _stop_program(self) -> None:
        """Stop a running program by the stop input, as a return-to-origin requires."""
        station = self.station
        station["Main.StopOk"] = False
        self.wait(lambda: not self._on(1, 3), RECOVERY_US, "no recovery", lambda: "SO(13) stays ON")
        station["Main.StopOk"] = True
        station.scan()
        self.wait(self._rests, RECOVERY_US, "no recovery", self._what_is_busy)

    def _on(self, byte: int, bit: int) -> bool:
        """Return a dedicated output of the controller, as the PLC has read it."""
        return bool(self._last.so[32 + byte] >> bit & 1)

    def _work(self) -> None:
        """Write a point, read it back and move to it."""
        self._serial += 1
        number, pulses = 29_990, [self._serial, -self._serial, 5, 7, 0, 0]
        self._do("WritePoint", Point=number, Pulses=pulses)
        self._do("ReadPoint", Point=number)
        if (back := self.station["Main.ReadPoint.Pulses"]) != pulses:
            self.fail("wrong data", f"after recovery a point is read as {back}, not {pulses}")
        self._do("MovePtp", Point=number, SpeedMode="SPEED_DIRECT", Speed=100.0)

    def _do(self, block: str, **pins: object) -> None:
        """Run a block to its normal end, with a long Timeout."""
        station = self.station
        before = station[f"Main.{block}.Timeout"]
        station[f"Main.{block}.Timeout"] = "T#10s"
        try:
            for pin, value in pins.items():
                station[f"Main.{block}.{pin}"] = value
        except InputError as error:
            self.fail("no recovery", str(error))
        station[f"Main.{block}.Execute"] = True
        station.scan()
        self.wait(
            lambda: not station[f"Main.{block}.Busy"],
            RECOVERY_US,
            "no recovery",
            lambda: f"{block} does not end; {self._what_is_busy()}",
        )
        if not station[f"Main.{block}.Done"]:
            error_id = station[f"Main.{block}.ErrorID"]
            self.fail("no recovery", f"{block} ends with 16#{error_id:04X}")
        station[f"Main.{block}.Execute"] = False
        station[f"Main.{block}.Timeout"] = before
        station.scan()
