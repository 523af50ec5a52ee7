"""The worked examples of the guide at the pins of the blocks: which block, and which pin is what.

Written by hand beside tests/data/worked_examples.toml, whose head explains the keys.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from structured_text.engines.base import Value

Pins = dict[str, Value]
Meaning = Mapping[str, Callable[[Any], Pins]]

#: The block of each example, and what its heading says that `given` does not.
EXAMPLE_BLOCKS: dict[int, tuple[str, Pins]] = {
    # 4.2.1, 4.2.2
    1: ("FB_MovePtp", {}),
    2: ("FB_MoveArch", {}),
    3: ("FB_MoveLinear", {}),
    4: ("FB_MoveCircular", {}),
    5: ("FB_MoveDirectMm", {}),
    6: ("FB_MoveDirectPulses", {}),
    7: ("FB_MoveIPtp", {}),
    8: ("FB_MoveILinear", {}),
    9: ("FB_MoveIDirectMm", {}),
    10: ("FB_MoveIDirectPulses", {}),
    # 4.2.3, 4.2.4
    11: ("FB_DrivePoint", {}),
    12: ("FB_DriveDirectMm", {}),
    13: ("FB_DriveDirectPulses", {}),
    14: ("FB_DriveIPoint", {}),
    15: ("FB_DriveIDirectMm", {}),
    16: ("FB_DriveIDirectPulses", {}),
    # 4.2.5 to 4.2.11
    17: ("FB_PalletMovePtp", {}),
    18: ("FB_PalletMoveArch", {}),
    19: ("FB_Jog", {"Frame": "JOG_PULSES"}),
    20: ("FB_Jog", {"Frame": "JOG_CARTESIAN"}),
    21: ("FB_Jog", {"Frame": "JOG_TOOL"}),
    22: ("FB_Inching", {"Frame": "JOG_PULSES"}),
    23: ("FB_Inching", {"Frame": "JOG_CARTESIAN"}),
    24: ("FB_Inching", {"Frame": "JOG_TOOL"}),
    25: ("FB_SetInchingAmount", {}),
    26: ("FB_TeachPoint", {}),
    27: ("FB_AbsoluteResetMovement", {}),
    28: ("FB_AbsoluteReset", {}),
    # 4.2.12 to 4.2.20
    29: ("FB_ReturnToOriginRobot", {}),
    30: ("FB_ReturnToOriginAxis", {}),
    31: ("FB_Servo", {}),
    32: ("FB_ChangeSpeed", {"Setting": "SETTING_MANUAL"}),
    33: ("FB_ChangeSpeed", {"Setting": "SETTING_AUTOMATIC"}),
    34: ("FB_ChangeSpeed", {"Setting": "SETTING_PROGRAM"}),
    35: ("FB_ChangeShift", {}),
    36: ("FB_ChangeHand", {}),
    37: ("FB_ChangeArm", {}),
    38: ("FB_MotorPower", {}),
    # 4.2.21 to 4.2.23
    39: ("FB_MoveTPtp", {}),
    40: ("FB_MoveTLinear", {}),
    41: ("FB_SetMaxTorque", {}),
    42: ("FB_PushPoint", {}),
    43: ("FB_PushDirectMm", {}),
    44: ("FB_PushDirectPulses", {}),
    # 4.3
    45: ("FB_WritePoint", {}),
    46: ("FB_ReadPoint", {}),
    47: ("FB_WritePointComment", {}),
    48: ("FB_ReadPointComment", {}),
    49: ("FB_WritePallet", {}),
    50: ("FB_ReadPallet", {}),
    51: ("FB_WriteShift", {}),
    52: ("FB_ReadShift", {}),
    53: ("FB_WriteHand", {}),
    54: ("FB_ReadHand", {}),
    # 4.4
    55: ("FB_AssignValue", {"Operation": "ARITHMETIC_ASSIGN"}),
    56: ("FB_AssignVariable", {"Operation": "ARITHMETIC_ASSIGN"}),
    57: ("FB_AssignValue", {}),
    58: ("FB_AssignVariable", {}),
    59: ("FB_ReadVariable", {}),
    60: ("FB_WriteParameter", {}),
    61: ("FB_ReadParameter", {}),
    62: ("FB_AssignPoint", {"Operation": "POINT_ASSIGN"}),
    63: ("FB_AssignPoint", {}),
    64: ("FB_AssignPalletPoint", {}),
    65: ("FB_AssignPointElementMm", {}),
    66: ("FB_AssignShiftElement", {}),
    # 4.5, 4.6
    67: ("FB_WriteIoPort", {}),
    68: ("FB_WriteIoPortBit", {}),
    69: ("FB_ReadIoPort", {}),
    70: ("FB_ReadIoPort", {}),
    71: ("FB_RegisterProgram", {}),
    72: ("FB_ExecuteProgram", {}),
    73: ("FB_ResetSelectedProgram", {}),
    74: ("FB_ReadProgramInfo", {}),
    # 4.7
    75: ("FB_ReadVersions", {}),
    76: ("FB_ReadSystemConfiguration", {}),
    77: ("FB_ReadServoStatus", {}),
    78: ("FB_ReadPositionPulses", {}),
    79: ("FB_ReadPositionMm", {}),
    80: ("FB_ReadTaskStatus", {}),
    81: ("FB_ReadTaskLines", {}),
    82: ("FB_ReadMessage", {}),
    83: ("FB_ReadSpeeds", {}),
    84: ("FB_ReadArmDesignation", {}),
    85: ("FB_ReadArmStatus", {}),
    86: ("FB_ReadOriginStatus", {"MotorType": "MOTOR_TYPE_ALL"}),
    87: ("FB_ReadTorqueOfMax", {}),
    88: ("FB_ReadDate", {}),
    89: ("FB_ReadTime", {}),
    90: ("FB_ReadOptionSlots", {}),
    91: ("FB_ReadInchingAmount", {}),
    92: ("FB_ReadLatestAlarm", {}),
    93: ("FB_ReadTorqueOfRated", {}),
    # 4.8, 4.9
    94: ("FB_SetDate", {}),
    95: ("FB_SetTime", {}),
    96: ("FB_RemoteAlarmReset", {}),
    97: ("FB_ResetSystemData", {}),
    98: ("FB_DefineRealTimeOutput", {}),
    99: ("FB_ReadRealTimeOutput", {}),
    100: ("FB_EnableRealTimeOutput", {}),
}


def _to(*pins: str) -> Callable[[Any], Pins]:
    """The value stands at this pin; several values one at each."""
    if len(pins) > 1:
        return lambda values: dict(zip(pins, values, strict=True))
    return lambda value: {pins[0]: value}


def _one_of(pin: str, **names: str) -> Callable[[Any], Pins]:
    return lambda word: {pin: names[word]}


def _nothing(_: Any) -> Pins:
    return {}


def _bit(axis: int) -> int:
    return 1 << axis - 1


def _port(kind: str, number: str) -> Callable[[Any], Pins]:
    """`DO12()` is port 12 of the digital outputs."""
    return lambda text: {kind: f"PORT_{text[:2]}", number: int(text[2:-2])}


_GIVEN: Meaning = {
    "robot": _to("RobotNumber"),
    "axes": _nothing,  # all axes: Axes = 0, as for the blocks that know no others
    "axis": _to("Axis"),
    "speed_percent": lambda value: {"SpeedMode": "SPEED_PERCENT", "Speed": float(value)},
    "speed_mm_s": lambda value: {"SpeedMode": "SPEED_MM_S", "Speed": float(value)},
    "acceleration_percent": _to("Acceleration"),
    "deceleration_percent": _to("Deceleration"),
    "position_output": _one_of("PositionOutput", pulses="POSITION_PULSES", mm="POSITION_MM"),
    "point": _to("Point"),
    "point1": _to("Point1"),
    "point2": _to("Point2"),
    "target_mm": _to("TargetMm"),
    "target_pulses": _to("TargetPulses"),
    "distance_mm": _to("DistanceMm"),
    "distance_pulses": _to("DistancePulses"),
    "arch_axis": _to("ArchAxis"),
    "arch_position_mm": lambda value: {"ArchUnit": "UNIT_MM", "ArchPositionMm": value},
    "pallet": _to("Pallet"),
    "work": _to("WorkPosition"),
    "nx": _to("Nx"),
    "ny": _to("Ny"),
    "nz": _to("Nz"),
    "first_point": _to("FirstPoint"),
    "direction": _one_of("Direction", plus="DIRECTION_PLUS", minus="DIRECTION_MINUS"),
    "inching_amount": _to("Amount"),
    "unit": _one_of("Units", pulses="UNIT_PULSES", mm="UNIT_MM"),
    "servo": _one_of("State", free="SERVO_FREE"),
    "motor_power": _one_of("Power", on="MOTOR_POWER_ON"),
    "arm": _one_of("Arm", right="ARM_RIGHT", left="ARM_LEFT"),
    "shift": _to("ShiftNumber"),
    "hand_number": _to("HandNumber"),
    "torque_percent": _to("Torque"),
    "push_force_percent": lambda value: {"PushForceGiven": True, "PushForce": value},
    "push_time_ms": _to("PushTime"),
    "data_pulses": lambda values: {"Unit": "UNIT_PULSES", "Pulses": values},
    "comment": _to("Comment"),
    "program_name": _to("ProgramName"),
    "variable": _to("Variable1"),
    "variable1": _to("Variable1"),
    "variable2": _to("Variable2"),
    "value": _to("ValueInteger"),
    "operation": _one_of(
        "Operation", addition="ARITHMETIC_ADD", multiplication="ARITHMETIC_MULTIPLY"
    ),
    "element": _to("PointElement"),
    "value_mm": _to("ElementMm"),
    "port": _port("PortType", "PortNumber"),
    "method": _one_of(
        "Selection", program_number="SELECT_PROGRAM_NUMBER", program_name="SELECT_PROGRAM_NAME"
    ),
    "program": _to("ProgramNumber"),
    "task": _to("TaskNumber"),
    "priority": _to("TaskPriority"),
    "first_task": lambda task: {"TaskRange": {1: "TASKS_1_TO_8", 9: "TASKS_9_TO_16"}[task]},
    "last_task": _nothing,
    "message": _to("MessageNumber"),
    "controller": _to("ControllerNumber"),
    "year": _to("DateYear"),
    "month": _to("DateMonth"),
    "day": _to("DateDay"),
    "hour": _to("TimeHour"),
    "minute": _to("TimeMinute"),
    "second": _to("TimeSecond"),
    "reset_item": _one_of("SystemData", power_on_count="SYSTEM_DATA_POWER_ON_COUNT"),
    "word": _to("OutputWord"),
    "item": lambda name: {"OutputItem": {"motor_duty": 13}[name]},
    "option1": _to("Option1"),
    "option2": _to("Option2"),
    "enabled": _to("EnableOutput"),
}

_PARAMETER: Meaning = {
    "parameter": lambda number: {
        "Parameter": {259: "PARAMETER_TOLE", 260: "PARAMETER_OUTPOS"}[number]
    },
    "axis": _to("ParameterAxis"),
    "value": _to("ParameterValue"),
}

_TORQUE: Meaning = {"axis": lambda axis: {"TorqueAxes": _bit(axis)}}

#: Where a key means another pin.
_GIVEN_TO: dict[str, Meaning] = {
    "FB_ChangeSpeed": {"speed_percent": _to("Percent")},
    "FB_WriteShift": {"data_mm": _to("ShiftMm")},
    "FB_WriteHand": {
        "data_mm": _to("Data1", "Data2", "Data3"),
        "on_r_axis": lambda there: {"Mount": "HAND_ON_R_AXIS" if there else "HAND_NOT_ON_R_AXIS"},
    },
    "FB_ReadVariable": {"variable": _to("Variable")},
    "FB_WriteParameter": _PARAMETER,
    "FB_ReadParameter": _PARAMETER,
    "FB_AssignPoint": {"operation": _one_of("Operation", addition="POINT_ADD")},
    "FB_AssignShiftElement": {"element": _to("ShiftElement")},
    "FB_WriteIoPort": {"value": _to("Pattern")},
    "FB_WriteIoPortBit": {  # DO(21) is bit 1 of port 2
        "port": lambda text: {
            "PortType": f"PORT_{text[:2]}",
            "PortNumber": int(text[3:-2]),
            "PortBit": int(text[-2]),
        },
        "value": lambda value: {"BitValue": value == 1},
    },
    "FB_ReadProgramInfo": {"method": _nothing},  # the block is the method
    "FB_ReadTorqueOfMax": _TORQUE,
    "FB_ReadTorqueOfRated": _TORQUE,
}

_SERVO = {0: "BRAKE", 1: "ON", 2: "FREE", 9: "NO_AXIS"}
_ORIGIN = {0: "INCOMPLETE", 1: "COMPLETE", 9: "NOT_APPLICABLE"}
_TASK = {0: "STOPPED", 1: "RUNNING", 2: "SUSPENDED", 3: "STANDBY", 9: "NO_TASK"}
_PLACE = {"R": "ROBOT", "C": "CONTROLLER", "T": "TASK"}
_DETAIL = {"A": "AXIS", "M": "MOTOR", "O": "SLOT", "T": "TASK"}


def _states(pin: str, prefix: str, names: Mapping[int, str]) -> Callable[[Any], Pins]:
    return lambda values: {pin: [f"{prefix}_STATE_{names[value]}" for value in values]}


def _version(text: str) -> int:
    """V1.08 is 16#0108, V1.001 is 16#1001."""
    return int(text.strip("V").replace(".", ""), 16)


_ANSWER: Meaning = {
    "positions_mm": _to("PositionMm"),
    "positions_pulses": _to("Pulses"),
    "push_timed_out": _to("Pushed"),
    "point": _to("PointRead"),
    "data_mm": lambda values: {"Unit": "UNIT_MM", "PositionMm": values},
    "comment": _to("Comment"),
    "pallet": _to("PalletRead"),
    "nx": _to("Nx"),
    "ny": _to("Ny"),
    "nz": _to("Nz"),
    "first_point": _to("FirstPoint"),
    "shift": _to("ShiftRead"),
    "hand_number": _to("HandRead"),
    "robot": _to("RobotRead"),
    "on_r_axis": lambda there: {"Mount": "HAND_ON_R_AXIS" if there else "HAND_NOT_ON_R_AXIS"},
    "variable": _to("VariableRead"),
    "value": _to("ValueInteger"),
    "parameter": _to("ParameterRead"),
    "axis": lambda axis: {"AxesRead": _bit(axis)},
    "port": _port("AnsweredType", "AnsweredPort"),
    "program": _to("CurrentProgram"),
    "program_name": _to("CurrentName"),
    "task": _to("CurrentTask"),
    "line": _to("CurrentLine"),
    "priority": _to("CurrentPriority"),
    "host_version": lambda text: {"HostVersion": _version(text)},
    "host_revision": lambda text: {"HostRevision": int(text.strip("R"))},
    "fpga_version": lambda text: {"FpgaVersion": _version(text)},
    "driver_versions": lambda texts: {"DriverVersions": [_version(text) for text in texts]},
    "robot_type": _to("RobotType"),
    "axis_types": _to("AxisTypes"),
    "servo_states": _states("ServoStates", "SERVO", _SERVO),
    "task_status": _states("TaskStates", "TASK", _TASK),
    "task_lines": _to("TaskLines"),
    "alarm": lambda text: dict(
        zip(("MessageGroup", "MessageCategory"), map(int, text.split(".")), strict=True)
    ),
    "place": lambda text: {
        "Place": f"ALARM_PLACE_{_PLACE[text[0]]}",
        "PlaceNumber": int(text[1]),
        "Detail": f"ALARM_DETAIL_{_DETAIL[text[2]]}",
        "DetailNumber": int(text[3]),
    },
    "auto_speed": _to("AutoSpeed"),
    "manual_speed": _to("ManualSpeed"),
    "program_speed": _to("ProgramSpeed"),
    "arm": _one_of("ArmState", right="ARM_STATE_RIGHT", left="ARM_STATE_LEFT"),
    "origin_complete": _states("OriginStates", "ORIGIN", _ORIGIN),
    "torque_percent": _to("Torques"),
    "year": _to("DateYear"),
    "month": _to("DateMonth"),
    "day": _to("DateDay"),
    "hour": _to("TimeHour"),
    "minute": _to("TimeMinute"),
    "second": _to("TimeSecond"),
    "option_slots": _to("OptionUnits"),
    "ivy2": _to("Ivy2Unit"),
    "inching_amount": _to("InchingAmount"),
    "word": _to("AnsweredWord"),
    "item": lambda name: {"OutputItem": {"motor_duty": 13}[name]},
    "option1": _to("Option1"),
    "option2": _to("Option2"),
}

#: Where a key means another output.
_ANSWER_AT: dict[str, Meaning] = {
    "FB_ReadShift": {"data_mm": _to("ShiftMm")},
    "FB_ReadHand": {  # data 1 comes with its scale and without
        "data_mm": lambda values: {
            **dict(zip(("Data1", "Data2", "Data3"), values, strict=True)),
            "Data1Integer": round(values[0] * 1000),
        }
    },
    "FB_ReadParameter": {"value": _to("ParameterValue")},
    "FB_ReadIoPort": {"value": _to("Pattern")},
}


def given_pins(name: str, given: Mapping[str, Any]) -> Pins:
    """The inputs of a block for what an example orders; every key must have a meaning."""
    return _pins(given, _GIVEN_TO.get(name, {}), _GIVEN)


def answer_pins(name: str, answer: Mapping[str, Any]) -> Pins:
    """The outputs of a block for what an example answers; every key must have a meaning."""
    return _pins(answer, _ANSWER_AT.get(name, {}), _ANSWER)


def _pins(values: Mapping[str, Any], *meanings: Meaning) -> Pins:
    pins: Pins = {}
    for key, value in values.items():
        pins |= next(one[key] for one in meanings if key in one)(value)
    return pins
