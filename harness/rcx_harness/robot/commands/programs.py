"""Categories 4 and 5: ports and robot programs (guide, 4.5 and 4.6).

The normal end of a command of category 5 only confirms that the command was received, as if a key
of the programming box was pressed. The program starts or is reset a moment later. SO(13) and SO(14)
show the result.
"""

from __future__ import annotations

from rcx_harness.robot.alarms import EMERGENCY_STOP, STOP, CommandError
from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.ports import port_of
from rcx_harness.robot.program.task import NEXT_LINE, RUN, STEP
from rcx_harness.robot.signals import dedicated_outputs

_KINDS = ("DI", "DO", "MO", "LO", "TO", "SI", "SO")
_DEDICATED = 2  # number of dedicated ports: SO0() and SO1()
_STOP_PORT, _STOP_BIT = 0, 6  # DI(06), the stop input of the parallel I/O board
_ALL, _NUMBER, _TASK = 0, 1, 2  # designation methods; any other value means: by name
_NAME_LENGTH = 16
_COMMON, _IN_COMMON = "COMMON", 10000
_MODES = {0x403: STEP, 0x405: NEXT_LINE}


@act(0x300)
def write_port(machine: Machine, call: Call) -> None:
    """Set the eight bits of an output port, as a robot program does."""
    machine.ports.write(port_of(*_named(call)), call.values["pattern"])


@act(0x301)
def write_port_bit(machine: Machine, call: Call) -> None:
    """Switch one bit of an output port."""
    place = port_of(*_named(call), bit=call.values["port_bit"])
    machine.ports.write(place, call.values["pattern"])


@act(0x304)
def read_port(machine: Machine, call: Call) -> Response:
    """Return the eight bits of a port, with its type and number."""
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


@act(0x401)
def register(machine: Machine, call: Call) -> None:
    """Register a program in a task; the program begins at its first line (4.6.1)."""
    program, values = machine.program, call.values
    task = program.tasks[_place(machine, call)]
    before = program.in_task(values["task"]) if values["task"] else None
    if "running" in (task.state, before.state if before else ""):
        raise CommandError(machine.config.busy_alarm)
    task.reset()
    if not program.register(task, values["task"], values["priority"]):
        raise CommandError(machine.config.undefined_task_alarm)


@act(0x402)
def execute(machine: Machine, call: Call) -> None:
    """Run the selected programs (4.6.2); a program that is already running continues."""
    _check_may_run(machine)
    program, modes = machine.program, None
    if call.values["method"] != _ALL:
        place = _registered(machine, call)
        modes = {} if program.tasks[place].state == "running" else {place: RUN}
    _order_start(machine, modes)


@act(0x403, 0x405)
def execute_line(machine: Machine, call: Call) -> None:
    """Execute one line of a program that is not running (4.6.2)."""
    _check_may_run(machine)
    place = _stopped(machine, call)
    _order_start(machine, {place: _MODES[call.code]})


@act(0x404)
def skip(machine: Machine, call: Call) -> None:
    """Skip one line of a program that is not running (4.6.2)."""
    _check_auto(machine)
    place = _stopped(machine, call)
    machine.program.tasks[place].skip()
    machine.program.is_reset = False


@act(0x406)
def reset(machine: Machine, call: Call) -> None:
    """Reset one program or all programs; end with an alarm if a program is running (4.6.3)."""
    _check_auto(machine)
    program = machine.program
    place = None if call.values["method"] == _ALL else _registered(machine, call)
    busy = program.busy if place is None else program.tasks[place].state == "running"
    if busy and not machine.config.reset_while_running:
        raise CommandError(machine.config.busy_alarm)
    under_way = "program_reset_delay" in machine.pending
    program.order_reset(None if place is None else (place,), beside=under_way)
    machine.schedule("program_reset_delay")


@act(0x408)
def read_info(machine: Machine, call: Call) -> Response:
    """Return number, task, line, priority and name of a program (4.6.4)."""
    place = _registered(machine, call)
    task = machine.program.tasks[place]
    if task.state == "running" and not machine.config.program_info_while_running:
        raise CommandError(machine.config.busy_alarm)
    name = task.program.name
    filler = " " if machine.config.name_filler == "spaces" else "\0"
    return {
        "program": place + 1,
        "task": task.number,
        "line": task.line + (_IN_COMMON if name == _COMMON else 0),
        "priority": task.priority,
        "program_name": name[:_NAME_LENGTH].ljust(_NAME_LENGTH, filler),
    }


def _named(call: Call) -> tuple[str, int]:
    """Return the kind of the selected port and its index; the port number has octal digits."""
    tens, units = divmod(call.values["port"], 16)
    return _KINDS[call.values["port_type"]], 8 * tens + units


def _place(machine: Machine, call: Call) -> int:
    """Return the index of the selected program in the list of programs, from 0.

    If several programs have the requested name, the first of them is selected.
    """
    tasks, values = machine.program.tasks, call.values
    if values["method"] == _TASK:
        task = machine.program.in_task(values["task"])
        if task is None:
            raise CommandError(machine.config.undefined_task_alarm)
        return tasks.index(task)
    if values["method"] == _NUMBER:
        place = int(values["program"]) - 1
    else:
        names = [task.program.name[:_NAME_LENGTH] for task in tasks]
        name = values["program_name"]
        place = names.index(name) if name in names else len(tasks)
    if place >= len(tasks):
        raise CommandError(machine.config.undefined_program_alarm)
    return place


def _registered(machine: Machine, call: Call) -> int:
    place = _place(machine, call)
    if not machine.program.tasks[place].number:
        raise CommandError(machine.config.undefined_task_alarm)
    return place


def _stopped(machine: Machine, call: Call) -> int:
    place = _registered(machine, call)
    if machine.program.tasks[place].state == "running":
        raise CommandError(machine.config.busy_alarm)
    return place


def _check_auto(machine: Machine) -> None:
    if not machine.auto_mode:
        raise CommandError(machine.config.manual_mode_alarm)


def _check_may_run(machine: Machine) -> None:
    """Raise CommandError if the input SI(12) could not start a program in the current state."""
    if machine.emergency:
        raise CommandError(EMERGENCY_STOP)
    if machine.stopped:
        raise CommandError(STOP)
    for alarm in machine.alarms.active:
        if alarm.serious:
            raise CommandError(alarm.number)
    if not machine.mode_allows_start():
        raise CommandError(machine.config.manual_mode_alarm)
    if not machine.may_run_program():
        raise CommandError(machine.config.servo_off_alarm)


def _order_start(machine: Machine, modes: dict[int, str] | None) -> None:
    under_way = "program_start_delay" in machine.pending
    machine.program.order_start(modes, beside=under_way)
    machine.schedule("program_start_delay")
