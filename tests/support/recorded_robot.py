"""Record a controller while a master tries everything that a robot file can configure.

The master comes from the module robot_master. Every cycle is recorded, together with the actions of
a person at the cell.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rcx_harness.look.compare.recording import Recording, of_cycles
from rcx_harness.look.compare.replay import Happening
from rcx_harness.spec import FieldValue, command
from rcx_harness.spec.wire import CYCLE_US, ENDS
from robot_master import Master


class RecordedMaster(Master):
    """A master that records every cycle."""

    def __init__(self, seed: int = 0, **config: Any) -> None:
        super().__init__(seed, **config)
        self.cycles: list[tuple[int, bytes | None, bytes]] = []
        self.happenings: list[Happening] = []

    def run(self, ms: float, *, idle: bool = True) -> None:
        """Let `ms` pass, in cycles of 5 ms. The inputs stay as they are."""
        for _ in range(round(ms * 1000) // CYCLE_US):
            si = bytes(self.si) if self.connected else None
            self.so = self.robot.cycle(self.now_us, si)
            self.cycles.append((self.now_us, si, self.so))
            self.now_us += CYCLE_US

    def happen(self, event: str, **args: int) -> None:
        """Inject an event into the controller before the next cycle."""
        self.happenings.append(Happening(self.now_us, event, args))
        self.robot.inject(event, **args)

    def ask(self, name: str, robot: int = 0, within_ms: float = 4000, **fields: FieldValue) -> None:
        """Send a remote command, and wait until the controller is ready again."""
        self.send(*_words(name, robot, **fields))
        self.wait_for_end(within_ms)

    def wait_for_end(self, within_ms: float = 4000) -> None:
        """Wait for the end of the command, then reset the status."""
        for _ in range(round(within_ms * 1000) // CYCLE_US):
            self.run(5)
            if self.status in ENDS:
                break
        self.send(0)
        self.run(60)

    def recording(self) -> Recording:
        """Return the recording of all cycles."""
        return of_cycles(self.cycles, every=True)


def short_run(master: RecordedMaster) -> None:
    """Run power-on, servo ON, a program start, some commands and an emergency stop in 3 s."""
    master.run(100)
    for name in ("SI00", "SI06"):
        master.turn_and_wait(name, True)
    for name in ("SI01", "SI15", "SI12"):
        master.pulse(name, 120)
    for name in ("ReadVersion", "ReadPositionPulses", "ReadSpeeds"):
        master.ask(name)
    master.turn_and_wait("SI00", False)
    master.pulse("SI16")
    master.turn_and_wait("SI00", True)
    master.pulse("SI16")


def busy_run(master: RecordedMaster) -> None:
    """Run `short_run`, then servo ON, a program, and commands at times when they have no effect."""
    short_run(master)
    master.turn_and_wait("SI00", False)
    master.pulse("SI01", 120)
    master.turn_and_wait("SI06", False)
    master.turn_and_wait("SI00", True)
    master.pulse("SI12", 120)
    master.pulse("SI16", 120)
    master.pulse("SI12", 120)
    master.turn_and_wait("SI06", True)
    master.pulse("SI15", 120)
    master.pulse("SI12", 120)
    master.turn_and_wait("SI06", False)
    master.send(0x0501)
    master.run(100)
    master.send(0x0505)  # a new command without a status reset
    master.run(100)
    master.send(0)
    master.run(60)


def exercised(master: RecordedMaster) -> None:
    """Run all exercises of this module in turn."""
    master.run(400)
    _signals(master)
    _references(master)
    _data(master)
    _handshake(master)
    _servos(master)
    _programs(master)
    _person(master)
    _link(master)
    _power(master)


def _up(master: RecordedMaster) -> None:
    """Switch SI(00) and SI(06) ON, reset alarms, and switch the servos ON."""
    for name in ("SI00", "SI06"):
        if not master.si[32] & {"SI00": 1, "SI06": 64}[name]:
            master.turn_and_wait(name, True)
    master.pulse("SI16", 120)
    master.pulse("SI01", 120)


def _signals(master: RecordedMaster) -> None:
    master.pulse("SI16", 120)
    master.turn_and_wait("SI00", True)
    master.turn_and_wait("SI10", True)
    master.pulse("SI12", 120)  # in the stop status: alarm 12.400
    master.pulse("SI17", 120)
    master.turn_and_wait("SI06", True)
    master.pulse("SI14", 120)  # with the servos off
    master.run(600)
    master.turn("SI16", True)  # another command 60 ms later
    master.run(60)
    master.turn_and_wait("SI00", False)
    master.turn_and_wait("SI16", False)
    master.pulse("SI16", 120)  # in the emergency stop
    master.turn_and_wait("SI00", True)
    master.pulse("SI01", 120)  # before the alarm reset
    master.turn("SI16", True)
    master.run(50)
    master.turn("SI16", False)
    master.run(200)
    _up(master)
    master.turn("SI10", False)
    master.run(60)
    master.turn("SI10", True)  # earlier than the minimum interval allows
    master.run(200)
    master.pulse("SI17", 120)
    master.run(1500)
    master.pulse("SI14", 120)
    master.run(900)


def _references(master: RecordedMaster) -> None:
    for name in ("ReadVersion", "ReadOptionSlots", "ReadDate", "ReadTime", "ReadLatestAlarm"):
        master.ask(name)
    for name in ("ReadSystemConfiguration", "ReadServoStatus", "ReadSpeeds", "ReadArmStatus"):
        master.ask(name, 1)
    for name in ("ReadPositionPulses", "ReadPositionMm", "ReadInchingAmount"):
        master.ask(name, 1)
    master.ask("ReadOriginStatus", 1, motor_type=1)
    master.ask("ReadOptionSlots", controller=3)
    for number in (1, 2, 3, 12, 400):
        master.ask("ReadMessage", message=number)
    master.ask("ReadProgramInfo", method=1, program=1)
    master.ask("ReadPointComment", point=77)
    master.ask("ReadShift", shift=7)
    master.ask("ReadPallet", pallet=3)
    master.send(0x0F00)  # a command code that the manual does not have
    master.wait_for_end()
    master.send(0x4505)  # a robot that does not exist
    master.wait_for_end()
    master.send(0x0501, 0, 0, 0, 5)  # a word that the command does not use
    master.wait_for_end()
    master.send(0x0101, 0, 0, 0, 0xFFFF, 0xFFFF)  # a point that does not exist
    master.wait_for_end()
    master.ask("ReadParameter", 1, parameter=257, axes=32)  # an axis that does not exist
    master.ask("ReadOptionSlots", controller=1)


def _data(master: RecordedMaster) -> None:
    master.ask("WritePointComment", point=50, comment="ABC")
    master.ask("ReadPointComment", point=50)
    master.ask("AssignValue", variable1=256, value=0x40200000)
    master.ask("AssignVariable", variable1=3, variable2=256)  # the key real_to_integer decides
    master.ask("ReadVariable", variable=3)
    master.ask("AssignValue", variable1=1, value=2_000_000_000)
    master.ask("MultiplyVariable", variable1=1, variable2=1)
    master.ask("AssignValue", variable1=2, value=0)
    master.ask("DivideVariable", variable1=1, variable2=2)
    master.ask("AssignPalletPoint", point=60, pallet=5, work=1)
    master.ask("WritePoint", point=61, unit=1, positions=(1000, 2000))
    master.ask("WritePoint", point=62, unit=0, positions=(1000, 2000))
    master.ask("AddPoint", point1=61, point2=62)
    master.ask("WritePallet", pallet=6, nx=2, ny=2, nz=1, first_point=61)
    for number in range(63, 66):
        master.ask("WritePoint", point=number, unit=1, positions=(number * 100, 5))
    master.ask("AssignPalletPoint", point=70, pallet=6, work=9)
    master.send(*_words("AssignPointElementMm", point=61, data_number=3, value=7))
    master.wait_for_end()
    master.ask("WriteParameter", 1, parameter=1, value=60)
    master.ask("SetDate", year=21, month=2, day=30)
    master.ask("ResetMotorData", 1, item=1, axes=1)
    master.ask("SelectArm", 1, arm=1)
    master.ask("SelectShift", 1, shift=9)
    master.ask("ExecuteProgram", method=1, program=44)
    master.ask("ExecuteProgram", method=2, task=9)
    master.ask("AbsoluteReset", 1, axes=1)


def _handshake(master: RecordedMaster) -> None:
    """Send commands that break the handshake: changed, too early or too late."""
    for words in ((0x0506,), (0x0501, 0, 0, 9)):
        master.send(0x0501)
        master.run(5)
        master.send(*words)
        master.run(80)
        master.send(0)
        master.run(60)
    master.send(0x0501)
    for _ in range(400):
        master.run(5)
        if master.status in ENDS:
            break
    master.send(0x0506)  # a new command without a status reset
    master.run(50)
    master.send(0)
    master.run(5)
    master.send(0x0501)
    master.wait_for_end()


def _servos(master: RecordedMaster) -> None:
    master.ask("MovePtp", 1, point=19, speed_mode=2, speed=5000, position_pulses=0)
    _up(master)
    master.ask("MotorPowerOff")
    master.ask("ServoOn", 1, axes=1)
    master.ask("MovePtp", 1, point=19)
    master.ask("MotorPowerOn")
    master.ask("MovePtp", 1, point=777)
    master.ask("MoveIDirectPulses", 1, distances=(20_000, 10_000))
    master.ask("MoveCircular", 1, point1=19, point2=19)
    master.ask("InchPulses", 1, axes=1, direction=0, position_pulses=1)
    master.ask("MoveArch", 1, point=19, arch_axis=4, arch_position=3000)
    master.ask("ServoFree", 1, axes=8)
    master.turn_and_wait("SI00", False)
    master.ask("ReadServoStatus", 1)
    _up(master)
    master.send(*_words("MoveIDirectPulses", 1, distances=(300_000, 0)))
    master.run(100)
    master.turn_and_wait("SI06", False)
    master.wait_for_end()
    master.turn_and_wait("SI06", True)
    master.ask("MoveIDirectPulses", 1, distances=(300_000, 0))
    master.ask("ReadPositionPulses", 1)
    master.send(*_words("JogPulses", 1, axes=1, direction=0, position_pulses=1))
    master.wait_for_end(12_000)
    master.ask("MoveDirectPulses", 1, targets=(1000, 1000, 0, 0))
    master.ask("AlarmReset")
    master.ask("ReturnToOriginRobot", 1, incremental_flag=1)


def _programs(master: RecordedMaster) -> None:
    _up(master)
    master.pulse("SI15", 120)
    master.pulse("SI12", 120)
    master.pulse("SI15", 120)  # while a program runs
    master.ask("ReadTaskStatus")
    master.ask("ReadProgramInfo", method=1, program=1)
    master.ask("MoveIDirectPulses", 1, distances=(1000, 0))
    master.ask("StepProgram", method=1, program=1)
    master.ask("WriteIoPort", port_type=6, port=2, pattern=5)
    master.turn_and_wait("SI06", False)
    master.turn_and_wait("SI06", True)
    master.pulse("SI12", 120)
    master.run(300)
    master.ask("ReadTaskLines")
    master.ask("MotorPowerOff")
    master.run(100)
    master.pulse("SI01", 120)
    master.turn_and_wait("SI06", False)
    master.turn_and_wait("SI06", True)
    master.pulse("SI15", 120)
    master.run(100)
    master.ask("ServoOff", 1)
    master.ask("MotorPowerOff")
    master.pulse("SI12", 120)  # with the servos off
    master.turn_and_wait("SI06", False)
    master.turn_and_wait("SI06", True)
    master.pulse("SI15", 120)


def _person(master: RecordedMaster) -> None:
    """Simulate the actions of a person at the cell."""
    _up(master)
    master.pulse("SI12", 120)
    master.happen("manual_mode")
    master.run(100)
    master.ask("ResetProgram", method=1, program=1)
    master.turn_and_wait("SI06", False)
    master.turn_and_wait("SI06", True)
    master.pulse("SI12", 120)
    master.happen("auto_mode")
    master.run(100)
    master.turn_and_wait("SI06", False)
    master.turn_and_wait("SI06", True)
    master.happen("pendant_on")
    master.pulse("SI15", 120)
    master.ask("SelectShift", 1, shift=2)
    master.happen("pendant_off")
    master.happen("warning")
    master.pulse("SI16", 120)
    master.happen("warning_clear")
    master.happen("emergency_stop")
    master.run(100)
    master.happen("emergency_stop_release")
    master.run(100)
    _up(master)
    master.happen("alarm")
    master.run(100)
    master.pulse("SI16", 120)
    _up(master)
    master.pulse("SI12", 120)
    master.happen("main_power_off")
    master.run(100)
    master.happen("main_power_on")
    master.run(100)
    master.turn_and_wait("SI06", False)
    master.turn_and_wait("SI06", True)
    master.pulse("SI16", 120)
    master.happen("safety_on")
    master.turn_and_wait("SI00", False)
    master.turn_and_wait("SI00", True)
    master.happen("safety_off")
    master.run(200)
    _up(master)


def _link(master: RecordedMaster) -> None:
    master.connected = False
    master.run(100)
    master.turn("SI16", True)  # SI(16) is ON in the first image after the connection
    master.send(0x0501)
    master.connected = True
    master.run(200)
    master.turn_and_wait("SI16", False)
    master.wait_for_end()
    for number in (1, 2):
        master.ask("ReadMessage", message=number)
    _up(master)


def _power(master: RecordedMaster) -> None:
    master.ask("SetManualSpeed", 1, speed=33)
    master.ask("WriteIoPort", port_type=2, port=0x20, pattern=5)
    master.ask("ReadIoPort", port_type=2, port=0x20)
    master.pulse("SI15", 120)
    master.turn_and_wait("SI00", False)
    master.happen("power_cycle")
    master.connected = False
    master.run(600)
    master.connected = True
    master.run(200)
    master.ask("ReadMessage", message=1)
    master.ask("ReadSpeeds", 1)
    master.ask("ReadIoPort", port_type=2, port=0x20)
    master.turn_and_wait("SI16", True)
    master.turn_and_wait("SI16", False)
    _up(master)


def _words(name: str, robot: int = 0, **fields: FieldValue) -> tuple[int, ...]:
    """Return the words of a command. The field values may be illegal."""
    entry = command(name)
    words = [0] * 16
    for part in entry.request:
        if part.name in fields or part.fixed is not None:
            part.write(words, fields.get(part.name, part.fixed or 0))
    return (entry.code | robot << 12, *words[1:])


def noted(values: Mapping[str, Any], seed: int = 0) -> RecordedMaster:
    """Return the master that has run all exercises with a controller with these values."""
    master = RecordedMaster(seed, **values)
    exercised(master)
    return master
