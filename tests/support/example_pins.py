"""The block and the pins for each worked example of the guide.

The tables are written by hand for tests/data/worked_examples.toml. The head of that file explains
the keys.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from structured_text.engines.base import Value

Pins = dict[str, Value]
Meaning = Mapping[str, Callable[[Any], Pins]]

#: The block of each example. A line begins with the number of its first example.
_NAMES = {
    # guide 4.2.1, 4.2.2
    1: "MovePtp MoveArch MoveLinear MoveCircular MoveDirectMm MoveDirectPulses MoveIPtp",
    8: "MoveILinear MoveIDirectMm MoveIDirectPulses",
    # guide 4.2.3, 4.2.4
    11: "DrivePoint DriveDirectMm DriveDirectPulses DriveIPoint DriveIDirectMm DriveIDirectPulses",
    # guide 4.2.5 to 4.2.11
    17: "PalletMovePtp PalletMoveArch Jog Jog Jog Inching Inching Inching SetInchingAmount",
    26: "TeachPoint AbsoluteResetMovement AbsoluteReset",
    # guide 4.2.12 to 4.2.20
    29: "ReturnToOriginRobot ReturnToOriginAxis Servo ChangeSpeed ChangeSpeed ChangeSpeed",
    35: "ChangeShift ChangeHand ChangeArm MotorPower",
    # guide 4.2.21 to 4.2.23
    39: "MoveTPtp MoveTLinear SetMaxTorque PushPoint PushDirectMm PushDirectPulses",
    # guide 4.3
    45: "WritePoint ReadPoint WritePointComment ReadPointComment WritePallet ReadPallet WriteShift",
    52: "ReadShift WriteHand ReadHand",
    # guide 4.4
    55: "AssignValue AssignVariable AssignValue AssignVariable ReadVariable WriteParameter",
    61: "ReadParameter AssignPoint AssignPoint AssignPalletPoint AssignPointElementMm",
    66: "AssignShiftElement",
    # guide 4.5, 4.6
    67: "WriteIoPort WriteIoPortBit ReadIoPort ReadIoPort RegisterProgram ExecuteProgram",
    73: "ResetSelectedProgram ReadProgramInfo",
    # guide 4.7
    75: "ReadVersions ReadSystemConfiguration ReadServoStatus ReadPositionPulses ReadPositionMm",
    80: "ReadTaskStatus ReadTaskLines ReadMessage ReadSpeeds ReadArmDesignation ReadArmStatus",
    86: "ReadOriginStatus ReadTorqueOfMax ReadDate ReadTime ReadOptionSlots ReadInchingAmount",
    92: "ReadLatestAlarm ReadTorqueOfRated",
    # guide 4.8, 4.9
    94: "SetDate SetTime RemoteAlarmReset ResetSystemData DefineRealTimeOutput ReadRealTimeOutput",
    100: "EnableRealTimeOutput",
}
#: Pins whose values are in the example's heading and not in `given`.
_FROM_HEADING: dict[int, Pins] = {
    19: {"Frame": "JOG_PULSES"},
    20: {"Frame": "JOG_CARTESIAN"},
    21: {"Frame": "JOG_TOOL"},
    22: {"Frame": "JOG_PULSES"},
    23: {"Frame": "JOG_CARTESIAN"},
    24: {"Frame": "JOG_TOOL"},
    32: {"Setting": "SETTING_MANUAL"},
    33: {"Setting": "SETTING_AUTOMATIC"},
    34: {"Setting": "SETTING_PROGRAM"},
    55: {"Operation": "ARITHMETIC_ASSIGN"},
    56: {"Operation": "ARITHMETIC_ASSIGN"},
    62: {"Operation": "POINT_ASSIGN"},
    86: {"MotorType": "MOTOR_TYPE_ALL"},
}
EXAMPLE_BLOCKS: dict[int, tuple[str, Pins]] = {
    number: (f"FB_{name}", _FROM_HEADING.get(number, {}))
    for first, names in _NAMES.items()
    for number, name in enumerate(names.split(), first)
}


def _to(*pins: str) -> Callable[[Any], Pins]:
    """Return a function that maps a value to this pin, or several values to the pins in order."""
    if len(pins) > 1:
        return lambda values: dict(zip(pins, values, strict=True))
    return lambda value: {pins[0]: value}


def _each(pairs: str) -> Meaning:
    """Return, for each `key=Pin`, a function that maps the value of the key to the pin."""
    return {key: _to(pin) for key, pin in (pair.split("=") for pair in pairs.split())}


def _one_of(pin: str, **names: str) -> Callable[[Any], Pins]:
    return lambda word: {pin: names[word]}


def _nothing(_: Any) -> Pins:
    return {}


def _bit(axis: int) -> int:
    return 1 << axis - 1


def _port(kind: str, number: str) -> Callable[[Any], Pins]:
    """Return a function that maps `DO12()` to port 12 of the digital outputs at these pins."""
    return lambda text: {kind: f"PORT_{text[:2]}", number: int(text[2:-2])}


_GIVEN: Meaning = {
    **_each(
        """
        robot=RobotNumber axis=Axis acceleration_percent=Acceleration
        deceleration_percent=Deceleration point=Point point1=Point1 point2=Point2
        target_mm=TargetMm target_pulses=TargetPulses distance_mm=DistanceMm
        distance_pulses=DistancePulses arch_axis=ArchAxis pallet=Pallet work=WorkPosition nx=Nx
        ny=Ny nz=Nz first_point=FirstPoint inching_amount=Amount shift=ShiftNumber
        hand_number=HandNumber torque_percent=Torque push_time_ms=PushTime comment=Comment
        program_name=ProgramName variable=Variable1 variable1=Variable1 variable2=Variable2
        value=ValueInteger element=PointElement value_mm=ElementMm program=ProgramNumber
        task=TaskNumber priority=TaskPriority message=MessageNumber controller=ControllerNumber
        year=DateYear month=DateMonth day=DateDay hour=TimeHour minute=TimeMinute
        second=TimeSecond word=OutputWord option1=Option1 option2=Option2 enabled=EnableOutput
        """
    ),
    "axes": _nothing,  # Axes = 0, the default, means all axes
    "speed_percent": lambda value: {"SpeedMode": "SPEED_PERCENT", "Speed": float(value)},
    "speed_mm_s": lambda value: {"SpeedMode": "SPEED_MM_S", "Speed": float(value)},
    "position_output": _one_of("PositionOutput", pulses="POSITION_PULSES", mm="POSITION_MM"),
    "arch_position_mm": lambda value: {"ArchUnit": "UNIT_MM", "ArchPositionMm": value},
    "direction": _one_of("Direction", plus="DIRECTION_PLUS", minus="DIRECTION_MINUS"),
    "unit": _one_of("Units", pulses="UNIT_PULSES", mm="UNIT_MM"),
    "servo": _one_of("State", free="SERVO_FREE"),
    "motor_power": _one_of("Power", on="MOTOR_POWER_ON"),
    "arm": _one_of("Arm", right="ARM_RIGHT", left="ARM_LEFT"),
    "push_force_percent": lambda value: {"PushForceGiven": True, "PushForce": value},
    "data_pulses": lambda values: {"Unit": "UNIT_PULSES", "Pulses": values},
    "operation": _one_of(
        "Operation", addition="ARITHMETIC_ADD", multiplication="ARITHMETIC_MULTIPLY"
    ),
    "port": _port("PortType", "PortNumber"),
    "method": _one_of(
        "Selection", program_number="SELECT_PROGRAM_NUMBER", program_name="SELECT_PROGRAM_NAME"
    ),
    "first_task": lambda task: {"TaskRange": {1: "TASKS_1_TO_8", 9: "TASKS_9_TO_16"}[task]},
    "last_task": _nothing,
    "reset_item": _one_of("SystemData", power_on_count="SYSTEM_DATA_POWER_ON_COUNT"),
    "item": lambda name: {"OutputItem": {"motor_duty": 13}[name]},
}

_PARAMETER: Meaning = {
    "parameter": lambda number: {
        "Parameter": {259: "PARAMETER_TOLE", 260: "PARAMETER_OUTPOS"}[number]
    },
    "axis": _to("ParameterAxis"),
    "value": _to("ParameterValue"),
}

_TORQUE: Meaning = {"axis": lambda axis: {"TorqueAxes": _bit(axis)}}

#: Blocks in which a key of the request belongs to another pin than in most blocks.
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
    "FB_ReadProgramInfo": {"method": _nothing},  # each method has its own block
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
    """Return a version as a word: V1.08 is 16#0108, V1.001 is 16#1001."""
    return int(text.strip("V").replace(".", ""), 16)


_ANSWER: Meaning = {
    **_each(
        """
        positions_mm=PositionMm positions_pulses=Pulses push_timed_out=Pushed point=PointRead
        comment=Comment pallet=PalletRead nx=Nx ny=Ny nz=Nz first_point=FirstPoint
        shift=ShiftRead hand_number=HandRead robot=RobotRead variable=VariableRead
        value=ValueInteger parameter=ParameterRead program=CurrentProgram
        program_name=CurrentName task=CurrentTask line=CurrentLine priority=CurrentPriority
        robot_type=RobotType axis_types=AxisTypes task_lines=TaskLines auto_speed=AutoSpeed
        manual_speed=ManualSpeed program_speed=ProgramSpeed torque_percent=Torques year=DateYear
        month=DateMonth day=DateDay hour=TimeHour minute=TimeMinute second=TimeSecond
        option_slots=OptionUnits ivy2=Ivy2Unit inching_amount=InchingAmount word=AnsweredWord
        option1=Option1 option2=Option2
        """
    ),
    "data_mm": lambda values: {"Unit": "UNIT_MM", "PositionMm": values},
    "on_r_axis": lambda there: {"Mount": "HAND_ON_R_AXIS" if there else "HAND_NOT_ON_R_AXIS"},
    "axis": lambda axis: {"AxesRead": _bit(axis)},
    "port": _port("AnsweredType", "AnsweredPort"),
    "host_version": lambda text: {"HostVersion": _version(text)},
    "host_revision": lambda text: {"HostRevision": int(text.strip("R"))},
    "fpga_version": lambda text: {"FpgaVersion": _version(text)},
    "driver_versions": lambda texts: {"DriverVersions": [_version(text) for text in texts]},
    "servo_states": _states("ServoStates", "SERVO", _SERVO),
    "task_status": _states("TaskStates", "TASK", _TASK),
    "alarm": lambda text: dict(
        zip(("MessageGroup", "MessageCategory"), map(int, text.split(".")), strict=True)
    ),
    "place": lambda text: {
        "Place": f"ALARM_PLACE_{_PLACE[text[0]]}",
        "PlaceNumber": int(text[1]),
        "Detail": f"ALARM_DETAIL_{_DETAIL[text[2]]}",
        "DetailNumber": int(text[3]),
    },
    "arm": _one_of("ArmState", right="ARM_STATE_RIGHT", left="ARM_STATE_LEFT"),
    "origin_complete": _states("OriginStates", "ORIGIN", _ORIGIN),
    "item": lambda name: {"OutputItem": {"motor_duty": 13}[name]},
}

#: Blocks in which a key of the answer belongs to another output than in most blocks.
_ANSWER_AT: dict[str, Meaning] = {
    "FB_ReadShift": {"data_mm": _to("ShiftMm")},
    "FB_ReadHand": {  # data 1 is output both with and without its scale
        "data_mm": lambda values: {
            **dict(zip(("Data1", "Data2", "Data3"), values, strict=True)),
            "Data1Integer": round(values[0] * 1000),
        }
    },
    "FB_ReadParameter": {"value": _to("ParameterValue")},
    "FB_ReadIoPort": {"value": _to("Pattern")},
}


def given_pins(name: str, given: Mapping[str, Any]) -> Pins:
    """Return the inputs of a block for an example's request. An unknown key is an error."""
    return _pins(given, _GIVEN_TO.get(name, {}), _GIVEN)


def answer_pins(name: str, answer: Mapping[str, Any]) -> Pins:
    """Return the outputs of a block for an example's answer. An unknown key is an error."""
    return _pins(answer, _ANSWER_AT.get(name, {}), _ANSWER)


def _pins(values: Mapping[str, Any], *meanings: Meaning) -> Pins:
    pins: Pins = {}
    for key, value in values.items():
        pins |= next(one[key] for one in meanings if key in one)(value)
    return pins
