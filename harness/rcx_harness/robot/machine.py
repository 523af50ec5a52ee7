"""The controller's state behind its areas: power, stops, servo, program, motion, alarms.

Nothing here knows of bytes. What takes time is put into `pending` with the time it is due, so
that the state depends on nothing but the calls and their times.
"""

from __future__ import annotations

import random
from collections.abc import Hashable, Iterable

from rcx_harness.robot.alarms import EMERGENCY_STOP, STOP, AlarmList, CommandError
from rcx_harness.robot.arm import Arm, Servos, Settings
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.data import Data
from rcx_harness.robot.memory import Memory
from rcx_harness.robot.motion import Motion, Movement, OriginRun, Origins
from rcx_harness.robot.paths import Path
from rcx_harness.robot.ports import Ports
from rcx_harness.robot.stored import Point
from rcx_harness.robot.tasks import Programs

__all__ = ["Machine"]


class Machine:
    """One robot controller; see RobotConfig for its properties.

    `si00`, `si06` and `si10` are the levels of the inputs as the controller has taken them. `link`
    is the connection: `none` since power-on, `normal`, or `lost` in operation.
    """

    def __init__(self, config: RobotConfig, seed: int) -> None:
        self.config = config
        self.rng = random.Random(seed)
        self.now_us = 0
        self.alarms = AlarmList(config.alarm_history_length)
        self.memory = Memory(config)
        self.points: dict[int, Point] = self.memory.points
        self.positions = [axis.start for axis in config.axes]
        self.motion = Motion()
        self.motion.workpieces.update(config.workpieces)
        self.origins = Origins(config)
        self.settings = Settings(config)
        self.servos = Servos(len(config.axes))
        self.data = Data(config, self.positions, self.servos, self.settings)
        self.ports = Ports(config.size)
        self.auto_input = config.auto_mode
        self.manual_lock = not config.auto_mode
        self.pendant_authority = config.pendant_authority
        self.inputs_disabled = config.safety_disables_inputs
        self.parallel_stop = config.parallel_stop
        self.hard_wired_stop = False
        self.main_power = True
        self.powered = False
        self.power_on()
        if config.booted:
            self.pending.clear()
            self._on_boot_time()

    def power_on(self) -> None:
        """Switch the controller on; does nothing if it is on."""
        if self.powered:
            return
        self.powered = True
        self.data.accumulated.power_on()
        self.booted = False
        self.si00 = self.si06 = self.si10 = False
        self.emergency = True  # until SI(00) comes ON; this is no shift in operation: no alarm
        self.link = "none"
        self.auto_mode = self._auto_selected
        self.sequence_running = False
        self.ports.lose_power(clears_internal=self.config.power_clears_internal_outputs)
        self.program = Programs(self.config, self.ports)
        self.motion.forget()
        self.pending: dict[str, int] = {}
        self.schedule("boot_time")

    def power_off(self) -> None:
        """Switch the controller off: all that is not stored is lost."""
        if self.powered:
            self.data.observe(self.now_us)
        self.powered = self.booted = False
        self.servos.switch_all_off()
        self.settings.lose_power()
        self.pending.clear()
        self._halt(EMERGENCY_STOP)
        self.origins.lose_power()
        self.alarms.active.clear()
        self.alarms.warning = False

    @property
    def stopped(self) -> bool:
        """A stop input is OFF: SI(06), or DI06 of a parallel I/O board that is valid."""
        parallel = self.config.parallel_io == "valid" and not self.parallel_stop
        ignored = self.inputs_disabled and not self.config.safety_keeps_stops
        return parallel or not (self.si06 or ignored)

    @property
    def mp_ready(self) -> bool:
        """SO(04): the servo ON input may switch the servos on."""
        config = self.config
        if not self.main_power:
            return False
        if not config.mp_ready_in_emergency_stop:
            return not self.emergency and not self.alarms.serious
        harmless = (EMERGENCY_STOP, config.link_loss_alarm, config.link_error_alarm)
        return not any(a.serious and a.number not in harmless for a in self.alarms.active)

    @property
    def servo_on(self) -> bool:
        """SO(02): the motor power is ON."""
        return self.servos.motor_power

    @property
    def origin_running(self) -> bool:
        """A return-to-origin is under way."""
        return "origin_time" in self.pending

    @property
    def origin_complete(self) -> bool:
        """SO(11): every axis knows its origin."""
        return all(self.origins.complete)

    @property
    def _auto_selected(self) -> bool:
        return self.auto_input and not self.manual_lock

    def advance(self, now_us: int) -> None:
        """Let time pass: answers that are due, the program, and the movements."""
        self.now_us = now_us
        self._follow_stops()
        while self.pending and self._answer_next():
            self._follow_stops()
        self.program.advance(now_us)
        if self.motion.under_way:
            self.motion.advance(now_us, self.positions)
        self.data.observe(self.now_us)

    def next_due_us(self) -> int | None:
        """When something happens by itself; None if nothing is under way."""
        if self.motion.under_way:
            return self.now_us
        due = list(self.pending.values())
        if (program_us := self.program.next_due_us(self.now_us)) is not None:
            due.append(program_us)
        if (data_us := self.data.next_due_us()) is not None:
            due.append(data_us)
        return min(due, default=None)

    def raise_alarm(self, number: str, *, serious: bool | None = None) -> None:
        """Raise an alarm; a serious one stops the robot and switches the servos off."""
        if serious is None:
            serious = number not in self.config.minor_alarms
        if not serious:
            self.alarms.note(number, self.now_us)
            return
        self.alarms.activate(number, self.now_us, serious=True)
        if self.config.alarm_stops_servo:
            self.switch_servos_off(number)

    def reset_alarms(self) -> str:
        """Reset what can be reset; the number of an alarm that stays, else empty."""
        lasting = list(self.config.power_restart_alarms)
        if self.emergency and not self.config.reset_in_emergency_stop:
            lasting.append(EMERGENCY_STOP)
        self.alarms.reset(lasting)
        if self.config.reset_clears_warning:
            self.alarms.warning = False
        return self.alarms.active[0].number if self.alarms.active else ""

    def press_emergency_stop(self) -> None:
        """SAFETY connector or programming box: an alarm even where SI(00) has stopped already."""
        self.hard_wired_stop = True
        if self.booted and self.emergency:
            self.raise_alarm(EMERGENCY_STOP, serious=True)

    def switch_main_power(self, on: bool) -> None:
        """The power of the motors; without it there is no servo ON."""
        config = self.config
        self.main_power = on
        if on:
            return
        programs = config.motor_power_stops_program
        self.switch_servos_off(config.servo_off_alarm, stop_programs=programs)
        if self.booted and config.main_power_alarm:
            self.raise_alarm(config.main_power_alarm)

    def arm(self, robot: int) -> Arm:
        """One of the robots, 1 to 4."""
        return Arm(robot, self.config, self.memory, self.settings, self.positions)

    def check_movable(self, arm: Arm, places: Iterable[int] | None = None) -> None:
        """Refuse a movement in emergency stop, in stop, with servos off, or beside another one.

        Args:
            arm: The robot that is to move.
            places: Its axes that are to move; None: all.

        Raises:
            CommandError: with the alarm that says why.
        """
        config = self.config
        indices = arm.indices if places is None else [arm.indices[place] for place in places]
        if self.emergency:
            raise CommandError(EMERGENCY_STOP)
        if self.stopped:
            raise CommandError(STOP)
        if not self.servos.are_on(indices):
            raise CommandError(config.servo_off_alarm)
        for alarm in self.alarms.active:
            if alarm.serious:
                raise CommandError(alarm.number)
        if self.program.running and not config.motion_during_program:
            raise CommandError(config.busy_alarm)
        if self.motion.moving(arm.number) or self.origins.moves(arm.indices):
            raise CommandError(config.moving_alarm)

    def move(
        self, robot: int, path: Path, *, relative: Hashable | None = None, pushing: bool = False
    ) -> Movement:
        """Start a movement of one robot; `relative` and `pushing` as in Movement."""
        config = self.config
        tolerance = None
        if config.end_in_tolerance:
            tolerance = {
                index: self.memory.parameters.get(robot, path.arrival, place)
                for place, index in enumerate(config.axes_of(robot))
            }
        again = relative if config.movei_start_position == "keep" else None
        movement = Movement(path, self.now_us, again, tolerance, pushing)
        self.motion.start(robot, movement)
        self.settings.begin_movement(robot, path.target)
        return movement

    def return_to_origin(
        self, groups: Iterable[tuple[int, ...]], *, by_command: bool = False
    ) -> OriginRun:
        """Start a return-to-origin of these axes, one group after the other."""
        run = self.origins.begin(groups, by_command=by_command)
        for index in run.axes:
            self.motion.forget(self.config.axes[index].robot)
        self.schedule("origin_time")
        return run

    def halt_axes(self, indices: Iterable[int], number: str) -> None:
        """End what any of these axes takes part in, with the alarm `number` as its reason."""
        axes = set(indices)
        self.motion.stop(self.now_us, self.positions, number, axes)
        if self.origins.moves(axes):
            self._stop_origin(number)

    def switch_servos_off(
        self, number: str, *, lock: bool = False, stop_programs: bool = True
    ) -> None:
        """All servos; what runs ends with the alarm `number` as its reason.

        Args:
            number: Of the alarm.
            lock: All brakes, also of free axes (guide, 4.2.20); else as the configuration says.
            stop_programs: The robot programs stop, too.
        """
        self.servos.switch_all_off(keep_free=not (lock or self.config.servo_off_brakes_free_axes))
        self.pending.pop("servo_on_delay", None)
        self._halt(number, stop_programs=stop_programs)

    def draw_us(self, key: str) -> int:
        """A delay of the configuration [us], drawn from the seed where it is a range."""
        delay = getattr(self.config, key)
        low, high = delay if isinstance(delay, tuple) else (delay, delay)
        return self.rng.randint(round(low * 1000), round(high * 1000))

    def switch_mode(
        self, *, auto_input: bool | None = None, manual_lock: bool | None = None
    ) -> None:
        """The SAFETY connector's AUTO input, or the programming box's manual lock.

        AUTO mode needs the one ON and the other OFF. Any other mode stops the program.
        """
        self.auto_input = self.auto_input if auto_input is None else auto_input
        self.manual_lock = self.manual_lock if manual_lock is None else manual_lock
        if not self.powered:
            return
        if not self._auto_selected:
            self.auto_mode = False
            self.pending.pop("auto_mode_delay", None)
            if self.config.manual_mode_stops_program:
                self._pause_program()
                self.pending.pop("program_start_delay", None)
        elif self.config.auto_mode_delay == 0:
            self.auto_mode = True
        elif not self.auto_mode:
            self.schedule("auto_mode_delay")

    def _answer_next(self) -> bool:
        """Give the answer that is due first; False if none is due yet."""
        name = min(self.pending, key=lambda key: self.pending[key])
        if self.pending[name] > self.now_us:
            return False
        del self.pending[name]
        getattr(self, f"_on_{name}")()
        return True

    def schedule(self, key: str) -> None:
        """Let an answer (`_on_...`) come when its delay of the configuration is over."""
        if key not in self.pending:  # else a skipped cycle would shift all later draws
            self.pending[key] = self.now_us + self.draw_us(key)

    def pendant_blocks(self) -> bool:
        """The programming box has authority, and dedicated inputs have none."""
        return self.pendant_authority and self.config.pendant_blocks_inputs

    def may_switch_servo_on(self) -> bool:
        """Nothing is in the way of servo ON."""
        alarm = self.alarms.serious and not self.config.servo_on_with_alarm
        return not self.emergency and self.mp_ready and not alarm and not self.pendant_blocks()

    def may_move(self) -> bool:
        """Neither a stop nor an alarm keeps the axes from moving."""
        return not self.emergency and not self.stopped and not self.alarms.serious

    def may_run_program(self) -> bool:
        """Nothing is in the way of a program start."""
        servo = self.servo_on or not self.config.program_needs_servo
        return self.mode_allows_start() and servo and self.may_move()

    def mode_allows_start(self) -> bool:
        """The mode is one in which programs are started."""
        return self.auto_mode or not self.config.start_needs_auto

    def _follow_stops(self) -> None:
        ignored = self.inputs_disabled and not self.config.safety_keeps_stops
        wanted = self.hard_wired_stop or not (self.si00 or ignored)
        if not self.booted:
            return
        if wanted and not self.emergency:
            self.schedule("emergency_stop_delay")
        elif not wanted and self.emergency and "emergency_stop_delay" not in self.pending:
            self.schedule("emergency_release_delay")
        if wanted:
            self.pending.pop("emergency_release_delay", None)
        if self.stopped:
            self._stop()
        held = self.emergency and self.config.emergency_stops_sequence
        if self.si10 and self.config.sequence_program and not held:
            if not self.sequence_running:
                self.schedule("sequence_delay")
        else:
            self.pending.pop("sequence_delay", None)
            self.sequence_running = False

    def _stop(self) -> None:
        """The stop input is OFF: program and movements end (12.400)."""
        if self.program.busy and "program_stop_delay" not in self.pending:
            self.schedule("program_stop_delay")
            self.raise_alarm(STOP)
        self.pending.pop("program_start_delay", None)
        if self.motion.under_way:
            self.motion.stop(self.now_us, self.positions, STOP)
        run = self._stop_origin(STOP)
        if run and not run.by_command:
            self.raise_alarm(STOP)

    def _stop_origin(self, number: str) -> OriginRun | None:
        self.pending.pop("origin_time", None)
        return self.origins.interrupt(number)

    def _halt(self, number: str, *, stop_programs: bool = True) -> None:
        """Programs, movements and return-to-origin end at once."""
        self.motion.stop(self.now_us, self.positions, number)
        self._stop_origin(number)
        if stop_programs:
            self._pause_program()
            self.pending.pop("program_start_delay", None)

    def _pause_program(self) -> None:
        self.program.pause(self.now_us)
        self.pending.pop("program_stop_delay", None)

    # What is due: one method for each key of `pending`.

    def _on_boot_time(self) -> None:
        self.booted = True
        if self.config.power_on_alarm:
            self.raise_alarm(self.config.power_on_alarm)
        if self.config.power_on_emergency_alarm or self.hard_wired_stop:
            self.raise_alarm(EMERGENCY_STOP)

    def _on_link_error_delay(self) -> None:
        latched = self.config.link_error_latches
        self.alarms.activate(self.config.link_error_alarm, self.now_us, serious=latched)

    def _on_emergency_stop_delay(self) -> None:
        self.emergency = True
        self.switch_servos_off(EMERGENCY_STOP)
        self.raise_alarm(EMERGENCY_STOP, serious=True)

    def _on_emergency_release_delay(self) -> None:
        self.emergency = False

    def _on_servo_on_delay(self) -> None:
        if self.may_switch_servo_on():
            self.servos.switch_all_on()

    def _on_alarm_reset_delay(self) -> None:
        self.reset_alarms()

    def _on_program_reset_delay(self) -> None:
        if self.config.reset_while_running or not self.program.resets_running:
            self.program.reset()

    def _on_program_start_delay(self) -> None:
        if self.may_run_program():
            self.program.start(self.now_us)

    def _on_auto_mode_delay(self) -> None:
        self.auto_mode = self._auto_selected

    def _on_program_stop_delay(self) -> None:
        self._pause_program()

    def _on_sequence_delay(self) -> None:
        self.sequence_running = True

    def _on_origin_time(self) -> None:
        if self.origins.arrive(self.positions):
            self.schedule("origin_time")
