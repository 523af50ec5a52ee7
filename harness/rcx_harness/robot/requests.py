"""What the dedicated inputs ask for; each is refused silently, as the real outputs are."""

from __future__ import annotations

from collections.abc import Callable

from rcx_harness.robot.alarms import STOP
from rcx_harness.robot.machine import Machine

__all__ = ["REQUESTS"]


def _servo_on(machine: Machine) -> None:
    if machine.may_switch_servo_on() and not machine.servos.all_on:
        machine.schedule("servo_on_delay")


def _alarm_reset(machine: Machine) -> None:
    machine.schedule("alarm_reset_delay")


def _program_reset(machine: Machine) -> None:
    running = machine.program.busy and not machine.config.reset_while_running
    if machine.auto_mode and not running and not machine.pendant_blocks():
        machine.program.order_reset(None)
        machine.schedule("program_reset_delay")


def _program_start(machine: Machine) -> None:
    if machine.pendant_blocks() or not machine.mode_allows_start() or machine.program.running:
        return
    if machine.stopped and not machine.emergency:
        machine.raise_alarm(STOP)
    if machine.may_run_program():
        machine.program.order_start(None)
        machine.schedule("program_start_delay")


def _origin(machine: Machine, name: str) -> None:
    free = not machine.motion.under_way and not machine.origin_running
    groups = machine.origins.plan(name)
    if machine.pendant_blocks() or not free or not groups:
        return
    if machine.stopped and not machine.emergency:
        machine.raise_alarm(STOP)
    servo = machine.servos_on(index for group in groups for index in group)
    if machine.may_move() and (servo or not machine.config.origin_needs_servo):
        machine.return_to_origin(groups)


#: By input; called at its OFF to ON edge.
REQUESTS: dict[str, Callable[[Machine], None]] = {
    "SI01": _servo_on,
    "SI12": _program_start,
    "SI14": lambda machine: _origin(machine, "SI14"),
    "SI15": _program_reset,
    "SI16": _alarm_reset,
    "SI17": lambda machine: _origin(machine, "SI17"),
}
