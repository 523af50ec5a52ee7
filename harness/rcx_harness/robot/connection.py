"""What the EtherNet/IP connection means to the controller (manual chapter 1, 5)."""

from __future__ import annotations

from rcx_harness.robot.machine import Machine

__all__ = ["lose_link", "regain_link"]


def lose_link(machine: Machine, *, in_operation: bool) -> None:
    """There is no connection: SI(00), SI(06) and SI(10) turn off inside."""
    config = machine.config
    machine.si00 = machine.si06 = machine.si10 = False
    machine.link = "lost" if in_operation else "none"
    if config.loss_clears_inputs:
        machine.program.ports.forget_inputs()
    if in_operation:
        machine.raise_alarm(config.link_loss_alarm)
    else:
        machine.schedule("link_error_delay")


def regain_link(machine: Machine) -> None:
    """The connection is there (again)."""
    machine.link = "normal"
    machine.pending.pop("link_error_delay", None)
    if not machine.config.link_error_latches:
        machine.alarms.clear(machine.config.link_error_alarm)
