"""The scenario of each block: start state, expected answers, and controller outputs at Done."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from fault_cell import FaultCell
from plc_bench import ROOT
from rcx_harness.robot import Axis, RobotProgram

#: Longest time until the cell is stable after boot, a new connection, and settling [scans].
_STEADY = 120

#: The robot program that executes the jobs of FB_ProgramCall.
_JOBS = (ROOT / "plc/robot/JOBS.PGM").read_text(encoding="utf-8")

_RECOVERY = ("FB_AlarmReset", "FB_ServoOn")
_START = (*_RECOVERY, "FB_AutoStart")
_EMERGENCY = (*_START, "FB_EmergencyStop", "FB_ServoOnFromEmergencyStop")
_STOP = (*_START, "FB_ProgramStop", "FB_ProgramContinue")


@dataclass(frozen=True)
class Scenario:
    """The conditions under which a block is tested.

    Attributes:
        prepare: Brings a cell without faults into the start state of the block.
        answers: Outputs of the controller for which the block waits, such as `SO02` or `Status`.
        means: Maps outputs of the controller to their states at Done (Valid).
        inputs: Values of input pins that differ from the defaults, and rows of tables.
        waits: Number of waits, each of them limited by Timeout.
        robot: Properties of the robot that differ from the defaults.
        helpers: Blocks that `prepare` and the recovery need.
    """

    prepare: Callable[[FaultCell], None]
    answers: tuple[str, ...]
    means: Mapping[str, bool]
    inputs: Mapping[str, Any] = field(default_factory=dict)
    waits: int = 1
    robot: Mapping[str, Any] = field(default_factory=dict)
    helpers: tuple[str, ...] = _RECOVERY


def recover(cell: FaultCell) -> None:
    """Recover as documented after the faults are removed: alarm reset, then servo on."""
    cell.until(lambda: bool(cell["Robot.Connected"]) and cell.on("SO01"), _STEADY, "CPU_OK")
    if cell["Robot.Inner.HoldEmergency"]:
        cell.help("FB_ServoOnFromEmergencyStop")
    cell.until(lambda: not cell.on("SO00"), _STEADY, "SO(00) OFF, all causes are removed")
    if cell.on("SO03"):
        cell.help("FB_AlarmReset")
    if not cell.on("SO02"):
        cell.help("FB_ServoOn")
    if cell["Robot.Inner.HoldStop"]:
        cell.help("FB_ProgramContinue")
    cell.until(lambda: bool(cell["Robot.Settled"]), _STEADY, "SI(00) and SI(06) ON and settled")


def _rest(cell: FaultCell) -> None:
    """Wait for the interval after the last input change. The next sequence then begins at once."""
    for _ in range(13):
        cell.scan()


def _program_stands(cell: FaultCell) -> None:
    recover(cell)
    if cell.on("SO13"):
        cell["StopOk"] = False
        cell.until(lambda: not cell.on("SO13"), 20, "SI(06) OFF stops the program")
        cell["StopOk"] = True
        cell.scan()
        cell.until(lambda: bool(cell["Robot.Settled"]), _STEADY, "SI(06) ON and settled")
    _rest(cell)


def _program_runs(cell: FaultCell) -> None:
    recover(cell)
    if not cell.on("SO13"):
        cell.help("FB_AutoStart")


def _program_is_not_reset(cell: FaultCell) -> None:
    _program_runs(cell)
    _program_stands(cell)


def _alarm(cell: FaultCell) -> None:
    recover(cell)
    cell.cell.inject("alarm", group=2, category=334)
    cell.until(lambda: cell.on("SO03"), 10, "the alarm is shown")
    _rest(cell)


def _servos_are_off(cell: FaultCell) -> None:
    _alarm(cell)
    cell.help("FB_AlarmReset")


def _axes_at_zero(cell: FaultCell) -> None:
    recover(cell)
    cell.cell.robot.positions[:] = [0] * len(cell.cell.robot.positions)


def _acknowledged(cell: FaultCell) -> None:
    """Recover, then pulse Acknowledge. The block reads again only after Acknowledge."""
    recover(cell)
    cell["Block.Acknowledge"] = True
    cell.scan()
    cell["Block.Acknowledge"] = False
    cell.scan()


def _emergency_stop(cell: FaultCell) -> None:
    recover(cell)
    cell.help("FB_EmergencyStop")


def _jobs_wait(cell: FaultCell) -> None:
    """Restart the robot program at its first line, where it waits for a job."""
    _program_stands(cell)
    cell.help("FB_ProgramReset")
    cell.help("FB_AutoStart")
    _rest(cell)


def _stopped_program(cell: FaultCell) -> None:
    _program_runs(cell)
    cell.help("FB_ProgramStop")


def _no_power(cell: FaultCell) -> None:
    cell.cell.inject("power_cycle")
    cell.until(lambda: not cell["Robot.Connected"], 20, "the link is lost with the power")


_POINT_19 = [0x0004, 0, 0x0032, 0x0013, *[0] * 11]

#: A record with point 50 of guide 4.3.1 in its only row. The checksum is that of zlib, inverted.
_HEAD_OF_50 = {
    "Kind": "DATA_POINTS",
    "RobotNumber": 0,
    "First": 50,
    "Count": 1,
    "Checksum": 0x40947D21,
}
_ROW_OF_50 = {"Defined": True, "Flag": 1, "Values": [10_000, -20_000, 5_000, -18_000, 0, 0]}

#: Every edge-triggered block of the library. Of the generated blocks, which are alike, only two.
SCENARIOS: dict[str, Scenario] = {
    "FB_AlarmReset": Scenario(_alarm, ("SO03",), {"SO03": False}),
    "FB_AutoStart": Scenario(_program_stands, ("SO13",), {"SO13": True}, helpers=_START),
    "FB_EmergencyStop": Scenario(
        _program_runs, ("SO00", "SO02"), {"SO00": True, "SO02": False}, waits=2, helpers=_EMERGENCY
    ),
    "FB_MovePtp": Scenario(_axes_at_zero, ("Status",), {}, {"Point": 19}),
    "FB_PickPlace": Scenario(
        _axes_at_zero,
        ("Status",),
        {},
        {"SourcePoint": 19, "TargetPoint": 19, "Speed": 50.0},
        waits=15,
    ),
    "FB_MoveTable": Scenario(
        _axes_at_zero, ("Status",), {}, {"Moves[1].Kind": "MOVE_PTP", "Moves[1].Point": 19}
    ),
    "FB_PointBackup": Scenario(recover, ("Status",), {}, {"First": 19, "Count": 1}),
    "FB_PointRestore": Scenario(
        recover, ("Status",), {}, {"Head": _HEAD_OF_50, "Point": _ROW_OF_50}
    ),
    "FB_PowerUp": Scenario(
        _no_power,
        ("SO01", "SO04", "SO10", "SO02", "SO14", "SO13"),
        {"SO13": True, "SO02": True},
        waits=9,
    ),
    "FB_ProgramCall": Scenario(
        _jobs_wait,
        (),
        {},
        {"JobNumber": 2, "AcknowledgeTimeout": "T#500ms"},
        robot={"programs": (RobotProgram("JOBS", text=_JOBS),)},
        helpers=(*_START, "FB_ProgramReset"),
    ),
    "FB_ProgramContinue": Scenario(
        _stopped_program, ("SO13",), {"SO13": True}, waits=2, helpers=_STOP
    ),
    "FB_ProgramReset": Scenario(_program_is_not_reset, ("SO14",), {"SO14": True}, helpers=_START),
    "FB_ProgramStop": Scenario(_program_runs, ("SO13",), {"SO13": False}, helpers=_STOP),
    "FB_ReadPoint": Scenario(recover, ("Status",), {}, {"Point": 19}),
    "FB_RemoteCommand": Scenario(
        _axes_at_zero, ("Status",), {}, {"Code": 0x0001, "Data": _POINT_19}
    ),
    "FB_ReturnToOrigin": Scenario(
        _program_stands,
        ("SO11",),
        {"SO11": True},
        robot={"origin_complete": False, "axes": (Axis(type="incremental"),) * 4},
    ),
    "FB_ServoOn": Scenario(_servos_are_off, ("SO02",), {"SO02": True}),
    "FB_ServoOnFromEmergencyStop": Scenario(
        _emergency_stop,
        ("SO00", "SO03", "SO04", "SO02"),
        {"SO00": False, "SO02": True},
        waits=4,
        robot={"mp_ready_in_emergency_stop": False},
        helpers=_EMERGENCY,
    ),
}

#: Every level block of the library.
LEVELS: dict[str, Scenario] = {
    "FB_AutoMode": Scenario(recover, ("SO10",), {"SO10": True}),
    "FB_ContinuousPosition": Scenario(recover, ("Status",), {}),
    "FB_Interlock": Scenario(_acknowledged, ("SO02",), {"SO02": True}),
    "FB_Jog": Scenario(_axes_at_zero, ("Status",), {}),
    "FB_SequenceControl": Scenario(recover, ("SO12",), {"SO12": True}),
    "FB_Override": Scenario(recover, ("Status",), {}),
    "FB_Status": Scenario(recover, ("SO01",), {}),
    "FB_ToolPosition": Scenario(recover, ("Status",), {}),
}
