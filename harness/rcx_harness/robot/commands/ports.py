"""Category 4: I/O ports (guide, 4.5)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.ports import port_of
from rcx_harness.robot.signals import dedicated_outputs

_KINDS = ("DI", "DO", "MO", "LO", "TO", "SI", "SO")
_DEDICATED = 2  # SO0() and SO1()
_STOP_PORT, _STOP_BIT = 0, 6  # DI(06)


@act(0x300)
def write_port(machine: Machine, call: Call) -> Response:
    """Assign eight bits to an output port, as a robot program does."""
    machine.ports.write(port_of(*_named(call)), call.values["pattern"])
    return {}


@act(0x301)
def write_port_bit(machine: Machine, call: Call) -> Response:
    """Switch one bit of an output port."""
    place = port_of(*_named(call), bit=call.values["port_bit"])
    machine.ports.write(place, call.values["pattern"])
    return {}


@act(0x304)
def read_port(machine: Machine, call: Call) -> Response:
    """The eight bits of a port, and which one it is."""
    kind, number = _named(call)
    if kind == "SO" and number < _DEDICATED:
        pattern = dedicated_outputs(machine) >> 8 * number & 0xFF
    else:
        pattern = machine.ports.read(port_of(kind, number))
    if (kind, number) == ("DI", _STOP_PORT) and machine.config.parallel_io != "none":
        mask = 1 << _STOP_BIT
        pattern = pattern | mask if machine.parallel_stop else pattern & ~mask
    values = call.values
    return {"port_type": values["port_type"], "port": values["port"], "pattern": pattern}


def _named(call: Call) -> tuple[str, int]:
    """Kind and number, counted, of the port; its tens and units are octal digits."""
    tens, units = divmod(call.values["port"], 16)
    return _KINDS[call.values["port_type"]], 8 * tens + units
