"""Category 6: alarm history and latest alarm of a remote command (guide, 4.7.7 and 4.7.17)."""

from __future__ import annotations

from rcx_harness.robot.alarms import EMERGENCY_STOP, STOP, ActiveAlarm, Place
from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.config.checks import alarm_code
from rcx_harness.robot.machine import Machine

__all__ = ["read_latest", "read_message"]

_NETWORK_GROUP = 12
_ETHERNET_IP = 0x0401  # unit number
_CONTROLLER, _SLOT = 1, 3  # kind and detail of a Place


@act(0x509)
def read_message(machine: Machine, call: Call) -> Response:
    """An entry of the alarm history (4.7.7)."""
    config, history = machine.config, machine.alarms.history
    number = call.values["message"]
    if number > len(history):
        if config.undefined_data_alarm:
            raise CommandError(config.undefined_data_alarm)
        return {}
    return _entry(machine, history[-number if config.newest_message_first else number - 1])


@act(0x515)
def read_latest(machine: Machine, call: Call) -> Response:
    """The latest alarm in which a remote command ended (4.7.17); zeros before the first one."""
    latest = machine.alarms.latest_of_command
    return _entry(machine, latest) if latest else {}


def _entry(machine: Machine, alarm: ActiveAlarm) -> Response:
    group, category = alarm_code(alarm.number)
    place = alarm.place or _place(machine, alarm.number, group)
    return {
        "alarm_group": group,
        "alarm_category": category,
        "place": place.kind,
        "place_number": place.number,
        "detail": place.detail,
        "detail_number": place.detail_number,
    }


def _place(machine: Machine, number: str, group: int) -> Place:
    """Controller 1; of the alarms of the network its option slot, as the manual's C1O1."""
    slots = machine.config.option_slots
    of_network = group == _NETWORK_GROUP and number not in (EMERGENCY_STOP, STOP)
    if not of_network or _ETHERNET_IP not in slots:
        return Place(_CONTROLLER)
    return Place(_CONTROLLER, 1, _SLOT, slots.index(_ETHERNET_IP) + 1)
