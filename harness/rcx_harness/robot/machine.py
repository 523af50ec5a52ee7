"""The state of a controller: power, stops, servos, programs, motion and alarms.

The bytes of the areas are made from this state in other modules. Every delayed answer is entered in
`pending` with the time at which it is due. The state therefore depends only on the calls and their
times.
"""

from __future__ import annotations

import random
from collections.abc import Hashable, Iterable

from rcx_harness.robot.alarms import EMERGENCY_STOP, STOP, AlarmList, CommandError
from rcx_harness.robot.arm import Arm, Servos, Settings
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.controller_memory import Memory
from rcx_harness.robot.data import Data
from rcx_harness.robot.motion import Motion, Movement, OriginRun, Origins
from rcx_harness.robot.paths import Path
from rcx_harness.robot.ports import Ports
from rcx_harness.robot.program.observing import Observers
from rcx_harness.robot.stored import Point
from rcx_harness.robot.tasks import Perform, Programs

__all__ = ["Machine"]


class Machine:
    """The state of one robot controller; see RobotConfig for its properties.

    `si00`, `si06` and `si10` are the input levels that the controller has recognised. `link` is the
    state of the connection: `none` since power-on, `normal`, or `lost` in operation.
    """

    def __init__(self, config: RobotConfig, seed: int, perform: Perform) -> None:
        """Create a controller; `perform` executes program statements that are remote commands."""
        self.perform = perform
        self.config = config
        self.rng = random.Random(seed)
        self.now_us = 0
        self._observers = Observers()
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
        """Switch the controller on; do nothing if it is already on."""
        if self.powered:
            return
        self.powered = True
        self.data.accumulated.power_on()
        self.booted = False
        self.si00 = self.si06 = self.si10 = False
        # Emergency stop until SI(00) is ON. No alarm is raised, because this is the normal state at
        # power-on.
        self.emergency = True
        self.link = "none"
        self.auto_mode = self._auto_selected
        self.sequence_running = False
        self.ports.lose_power(clears_internal=self.config.power_clears_internal_outputs)
        self.program = Programs(self, self._observers)
        self.motion.forget()
        self.pending: dict[str, int] = {}
        self.schedule("boot_time")

    def power_off(self) -> None:
        """Switch the controller off; all state that is not stored is lost."""
        if self.powered:
            self.data.observe(self.now_us)
        self.powered = self.booted = False
        self.servos.switch_all_off()
        self.settings.lose_power()
        if self.config.power_clears_variables:
            self.memory.variables.clear()
        self.pending.clear()
        self._halt(EMERGENCY_STOP)
        self.origins.lose_power()
        self.alarms.active.clear()
        self.alarms.warning = False

    @property
    def stopped(self) -> bool:
        """Return whether a stop input is OFF: SI(06), or DI06 of a valid parallel I/O board."""
        parallel = self.config.parallel_io == "valid" and not self.parallel_stop
        ignored = self.inputs_disabled and not self.config.safety_keeps_stops
        return parallel or not (self.si06 or ignored)

    @property
    def mp_ready(self) -> bool:
        """Return SO(04), whether the servo ON input can switch the servos on."""
        config = self.config
        if not self.main_power:
            return False
        if not config.mp_ready_in_emergency_stop:
            return not self.emergency and not self.alarms.serious
        harmless = (EMERGENCY_STOP, config.link_loss_alarm, config.link_error_alarm)
        return not any(a.serious and a.number not in harmless for a in self.alarms.active)

    @property
    def servo_on(self) -> bool:
        """Return SO(02), whether the motor power is ON."""
        return self.servos.motor_power

    @property
    def origin_running(self) -> bool:
        """Return whether a return-to-origin is under way."""
        return "origin_time" in self.pending

    @property
    def origin_complete(self) -> bool:
        """Return SO(11), whether the return-to-origin of every axis is complete."""
        return all(self.origins.complete)

    @property
    def _auto_selected(self) -> bool:
        return self.auto_input and not self.manual_lock

    def advance(self, now_us: int) -> None:
        """Advance the state to `now_us`: first due answers, then programs and movements."""
        self.now_us = now_us
        # Process the stops first, because they may block an answer of this cycle, such as servo ON.
        # Each answer may change the stops again. Programs and movements come last, so that they use
        # the final state of the cycle.
        self._follow_stops()
        while self.pending and self._answer_next():
            self._follow_stops()
        self.program.advance(now_us)
        if self.motion.under_way:
            self.motion.advance(now_us, self.positions)
        self.data.observe(self.now_us)

    def next_due_us(self) -> int | None:
        """Return when the state next changes by itself [us]; None if no change is pending."""
        if self.motion.under_way:
            return self.now_us
        due = list(self.pending.values())
        if (program_us := self.program.next_due_us(self.now_us)) is not None:
            due.append(program_us)
        if (data_us := self.data.real_time.next_due_us()) is not None:
            due.append(data_us)
        return min(due, default=None)

    def raise_alarm(self, number: str, *, serious: bool | None = None) -> None:
        """Raise an alarm; a serious alarm stops all robots and switches the servos off."""
        if serious is None:
            serious = number not in self.config.minor_alarms
        if not serious:
            self.alarms.note(number, self.now_us)
            return
        self.alarms.activate(number, self.now_us, serious=True)
        if self.config.alarm_stops_servo:
            self.switch_servos_off(number)

    def reset_alarms(self) -> str:
        """Reset all alarms that can be reset.

        Returns:
            The number of an alarm that is still active; empty if no alarm is active.
        """
        lasting = list(self.config.power_restart_alarms)
        if self.emergency and not self.config.reset_in_emergency_stop:
            lasting.append(EMERGENCY_STOP)
        self.alarms.reset(lasting)
        if self.config.reset_clears_warning:
            self.alarms.warning = False
        return self.alarms.active[0].number if self.alarms.active else ""

    def press_emergency_stop(self) -> None:
        """Press the emergency stop of the SAFETY connector or the programming box.

        The alarm is raised even if SI(00) has already caused an emergency stop.
        """
        self.hard_wired_stop = True
        if self.booted and self.emergency:
            self.raise_alarm(EMERGENCY_STOP, serious=True)

    def switch_main_power(self, on: bool) -> None:
        """Switch the main power of the motors, without which the servos cannot be switched on."""
        config = self.config
        self.main_power = on
        if on:
            return
        programs = config.motor_power_stops_program
        self.switch_servos_off(config.servo_off_alarm, stop_programs=programs)
        if self.booted and config.main_power_alarm:
            self.raise_alarm(config.main_power_alarm)

    def arm(self, robot: int) -> Arm:
        """Return a robot by its number, 1 to 4."""
        return Arm(robot, self.config, self.memory, self.settings, self.positions)

    def check_movable(
        self, arm: Arm, places: Iterable[int] | None = None, *, by_program: bool = False
    ) -> None:
        """Raise CommandError if the robot may not start a movement.

        Movements are refused in emergency stop, in stop, with servos off, with a serious alarm,
        during a program (if so configured), and while the robot is already moving. `places` are the
        indices of the moving axes in the robot; None: all axes. With `by_program` a robot program
        starts the movement.
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
        if self.program.running and not (by_program or config.motion_during_program):
            raise CommandError(config.busy_alarm)
        if self.motion.moving(arm.number) or self.origins.moves(arm.indices):
            raise CommandError(config.moving_alarm)

    def move(
        self, robot: int, path: Path, *, relative: Hashable | None = None, pushing: bool = False
    ) -> Movement:
        """Start a movement of one robot; see Movement for `relative` and `pushing`."""
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
        """Start a return-to-origin of the given groups of axes, one group after the other."""
        run = self.origins.begin(groups, by_command=by_command)
        for index in run.axes:
            self.motion.forget(self.config.axes[index].robot)
        self.schedule("origin_time")
        return run

    def halt_axes(self, indices: Iterable[int], number: str) -> None:
        """End all motion of these axes because of the alarm `number`."""
        axes = set(indices)
        self.motion.stop(self.now_us, self.positions, number, axes)
        if self.origins.moves(axes):
            self._stop_origin(number)

    def switch_servos_off(
        self, number: str, *, lock: bool = False, stop_programs: bool = True
    ) -> None:
        """Switch all servos off and end all motion, with the alarm `number` as its reason.

        With `lock`, all brakes are applied, also those of free axes (guide, 4.2.20). Without
        `lock`, the configuration determines the state of free axes. With `stop_programs` the robot
        programs stop as well.
        """
        self.servos.switch_all_off(keep_free=not (lock or self.config.servo_off_brakes_free_axes))
        self.pending.pop("servo_on_delay", None)
        self._halt(number, stop_programs=stop_programs)

    def draw_us(self, key: str) -> int:
        """Return a configured delay [us]; a delay from a range is drawn with the random numbers."""
        delay = getattr(self.config, key)
        low, high = delay if isinstance(delay, tuple) else (delay, delay)
        return self.rng.randint(round(low * 1000), round(high * 1000))

    def switch_mode(
        self, *, auto_input: bool | None = None, manual_lock: bool | None = None
    ) -> None:
        """Switch the SAFETY connector's AUTO input or the programming box's manual lock.

        AUTO mode needs the AUTO input ON and the lock OFF. If so configured, the end of AUTO mode
        stops the program.
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
        """Execute the pending answer that is due first; return False if none is due yet."""
        name = min(self.pending, key=lambda key: self.pending[key])
        if self.pending[name] > self.now_us:
            return False
        del self.pending[name]
        getattr(self, f"_on_{name}")()
        return True

    def schedule(self, key: str) -> None:
        """Schedule the method `_on_<key>` after its configured delay.

        If the method is already scheduled, its time does not change.
        """
        if key not in self.pending:  # A second draw would change all later random delays.
            self.pending[key] = self.now_us + self.draw_us(key)

    def pendant_blocks(self) -> bool:
        """Return whether the programming box has authority and so blocks dedicated inputs."""
        return self.pendant_authority and self.config.pendant_blocks_inputs

    def may_switch_servo_on(self) -> bool:
        """Return whether all conditions of servo ON are met."""
        alarm = self.alarms.serious and not self.config.servo_on_with_alarm
        return not self.emergency and self.mp_ready and not alarm and not self.pendant_blocks()

    def may_move(self) -> bool:
        """Return whether no stop and no serious alarm prevents movements."""
        return not self.emergency and not self.stopped and not self.alarms.serious

    def may_run_program(self) -> bool:
        """Return whether all conditions of a program start are met."""
        servo = self.servo_on or not self.config.program_needs_servo
        return self.mode_allows_start() and servo and self.may_move()

    def mode_allows_start(self) -> bool:
        """Return whether programs may be started in the current mode."""
        return self.auto_mode or not self.config.start_needs_auto

    def _follow_stops(self) -> None:
        # Emergency stop and sequence control depend on the levels of their inputs, not on edges.
        # Each change of state takes a configured delay. If the level changes back during the delay
        # of a release or of the sequence, the pending answer is cancelled. An emergency stop that
        # has been requested is never cancelled. A stop input that is OFF ends motion in every
        # cycle, so that a movement cannot start in the same cycle and continue.
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
        """Stop the programs and the movements because a stop input is OFF (12.400)."""
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
        """End movements and return-to-origin at once; with `stop_programs`, also the programs."""
        self.motion.stop(self.now_us, self.positions, number)
        self._stop_origin(number)
        if stop_programs:
            self._pause_program()
            self.pending.pop("program_start_delay", None)

    def _pause_program(self) -> None:
        self.program.pause(self.now_us)
        self.pending.pop("program_stop_delay", None)

    # Handlers of the pending answers: one method for each key of `pending`. The key is also the
    # name of the configured delay (`boot_time`, `servo_on_delay`). `schedule` enters a key with the
    # time at which it is due. `_answer_next` calls the handler at that time. Conditions are checked
    # again in the handler, because they may have changed during the delay.

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
