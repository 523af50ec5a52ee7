"""The remote-command handshake (guide, chapters 1 and 2), one step per controller cycle.

The master sets a command code in word n while the status in word m is 0x0000. The controller shows
RUN, executes the command, and shows an end status with the response. The master then sets the code
to 0 (status reset command), and the controller answers with status 0x0000. The master must not
change code or data before the end status. It must not set a code before status 0x0000. Breaking
either rule is recorded as a violation.
"""

from __future__ import annotations

from enum import Enum

from rcx_harness.robot.alarms import ActiveAlarm, CommandError, Place
from rcx_harness.robot.area import WORDS_AT_REST
from rcx_harness.robot.commands import Call, Execution, Response, start
from rcx_harness.robot.commands.base import acts_once, answers_absent
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.config.checks import alarm_code
from rcx_harness.robot.findings import Findings
from rcx_harness.robot.machine import Machine
from rcx_harness.spec import Command, commands
from rcx_harness.spec.wire import ABNORMAL_END, NORMAL_END, RUN
from structured_text.output.units import format_word

__all__ = ["Handshake", "Kind", "Phase", "Words"]

Words = tuple[int, ...]

_ROBOT, _AXIS = 0, 1  # values of `kind` and `detail` of a Place


class Phase(Enum):
    """The phases of the handshake; the values are their descriptions."""

    READY = "ready for a command"
    ACCEPTING = "a command was seen and is not yet begun"
    RUNNING = "a command is executed"
    ABANDONED = "a command is executed whose status is not reflected any more"
    ENDED = "an end status is shown"
    CLEARING = "the status reset command was seen, the status is not yet 0x0000"


class Kind(Enum):
    """The course of a command: refused, short or lasting."""

    REFUSED = "it ends abnormally as soon as it is begun"
    SHORT = "it acts once, `command_delay` after it was begun"
    LASTING = "it takes time, such as a movement"


class Handshake:
    """The state machine of the handshake: words n to n+30 in, words m to m+30 out.

    Attributes:
        phase: The current phase.
        executed: Number of commands that have ended and have shown their end status.
    """

    def __init__(self, config: RobotConfig, findings: Findings) -> None:
        self._config = config
        self._findings = findings
        self.phase = Phase.READY
        self.executed = 0
        self._shown: Words = WORDS_AT_REST
        self._taken: Words = WORDS_AT_REST
        self._due_us = 0
        self._execution: Execution | None = None
        self._failure: CommandError | None = None
        self._blocked = 0  # a code that was set before the ready status; it is never executed
        # commands that are still executed although their status is no longer shown
        self._unseen: list[Execution] = []
        self._waits = False  # whether an early code will be accepted in the next cycle
        self._reported = 0  # the last code that was reported as set too early

    @property
    def shown(self) -> Words:
        """Return the words m to m+30 for the output area."""
        return self._shown

    def takes(self, machine: Machine) -> Kind:
        """Return whether the accepted command is refused, short or lasting in the current state."""
        try:
            call = _check(machine, self._taken)
        except CommandError:
            return Kind.REFUSED
        return Kind.SHORT if acts_once(call.code) else Kind.LASTING

    def next_due_us(self, now_us: int) -> int | None:
        """Return when the handshake continues by itself [us]; None if it waits for the master."""
        if self._unseen or self._waits or self.phase in (Phase.RUNNING, Phase.ABANDONED):
            return now_us
        return self._due_us if self.phase in (Phase.ACCEPTING, Phase.CLEARING) else None

    def step(self, machine: Machine, words: Words) -> None:
        """Process the words n to n+30 that the master sends in this cycle."""
        self._unseen = [one for one in self._unseen if _goes_on(one, machine)]
        if self.phase is Phase.READY:
            self._look_for_command(machine, words)
        elif self.phase is Phase.ENDED:
            self._look_for_reset(machine, words)
        elif self.phase in (Phase.CLEARING, Phase.ABANDONED):
            self._report_early_code(machine, words)
        elif words[0] != self._taken[0] or (
            words != self._taken and self._config.data_belong_to_command
        ):
            self._change(machine, words)

        if self.phase is Phase.ACCEPTING and machine.now_us >= self._due_us:
            self._begin(machine)
        elif self.phase in (Phase.RUNNING, Phase.ABANDONED):
            self._go_on(machine, words)
        if self.phase is Phase.CLEARING and machine.now_us >= self._due_us:
            self._rest(words)

    def connect(self, words: Words) -> None:
        """Process the first image of a connection.

        By default, a command code in this first image is not executed.
        """
        if not self._config.first_image_commands:
            self._blocked = words[0]

    def disconnect(self, machine: Machine) -> None:
        """Process the loss of the link.

        A running command that is not stoppable ends abnormally, and its end status stays until a
        reset. Any other command is dropped, and the handshake returns to the ready status.
        """
        self._unseen.clear()
        if self.phase is Phase.RUNNING and self._execution and not self._execution.stoppable:
            self._end_abnormally(machine, CommandError(self._config.link_loss_alarm))
        elif self.phase not in (Phase.READY, Phase.ENDED):
            self._rest(WORDS_AT_REST)

    def _look_for_command(self, machine: Machine, words: Words) -> None:
        self._waits = False
        if words[0] != self._blocked:
            self._blocked = 0
        if words[0] and not self._blocked and not machine.inputs_disabled:
            self._taken = words
            self._due_us = machine.now_us + machine.draw_us("command_accept_delay")
            self.phase = Phase.ACCEPTING

    def _look_for_reset(self, machine: Machine, words: Words) -> None:
        if words[0] == 0:
            self._due_us = machine.now_us + machine.draw_us("status_reset_delay")
            self._reported = 0
            self.phase = Phase.CLEARING
        elif words[0] != self._taken[0]:
            self._report_early_code(machine, words)

    def _report_early_code(self, machine: Machine, words: Words) -> None:
        """Record a violation if a code is set while the status is not 0x0000.

        The code is not executed in this cycle. Each code is reported only once.
        """
        known, self._reported = self._reported, words[0]
        if words[0] in (0, known):
            return
        waits = self._config.early_command_waits and self.phase is not Phase.ENDED
        text = (
            f"command {format_word(words[0])} is set while the status is "
            f"{format_word(self._shown[0])}; a command may be set only in status 16#0000; "
            f"{'it waits' if waits else 'not executed'}"
        )
        self._findings.add(machine.now_us, "ready-first", text)

    def _change(self, machine: Machine, words: Words) -> None:
        """Process a change of the command code or data before the end status."""
        # Code 0 during a stoppable command (jog) is its regular end, not a violation. Any other
        # change is a violation, and a command that is already executed cannot be recalled. The
        # configuration decides how it continues: with RUN shown until its end (ABANDONED), or
        # without any status while the handshake is ready for the next command (`_unseen`).
        stoppable = self._execution is not None and self._execution.stoppable
        if stoppable and words[0] == 0:
            self._due_us = machine.now_us + machine.draw_us("status_reset_delay")
            self._execution = None
            self.phase = Phase.CLEARING
            return
        changes = [
            f"n{f'+{2 * k}' if k else ''} {format_word(old)} to {format_word(new)}"
            for k, (old, new) in enumerate(zip(self._taken, words, strict=True))
            if old != new
        ]
        text = (
            f"command {format_word(self._taken[0])} was changed before its end status "
            f"({', '.join(changes)}; status {format_word(self._shown[0])}); "
            "its status is not reflected any more"
        )
        self._findings.add(machine.now_us, "hold-command", text)
        if self._execution and not stoppable:
            if self._config.changed_command_status == "run":
                self._reported = words[0]  # the violation already reports the new code
                self._show(RUN, WORDS_AT_REST[1:])
                self.phase = Phase.ABANDONED
                return
            self._unseen.append(self._execution)
        self._rest(words)

    def _begin(self, machine: Machine) -> None:
        """Begin the accepted command; a short command may end in the same cycle."""
        self._failure = None
        try:
            self._execution = start(machine, _check(machine, self._taken))
        except CommandError as alarm:
            self._execution, self._failure = None, alarm
        self.phase = Phase.RUNNING
        if self._config.skip_run_status == "never":
            self._show(RUN, WORDS_AT_REST[1:])
        else:
            self._go_on(machine, self._taken)

    def _go_on(self, machine: Machine, words: Words) -> None:
        response: Response | None = None
        if self._execution and not self._failure:
            try:
                response = self._execution.step(machine)
            except CommandError as alarm:
                self._failure = alarm
        ended = response is not None or self._failure is not None
        if self.phase is Phase.ABANDONED:
            if ended:
                self._rest(words)
        elif self._failure:
            self._end_abnormally(machine, self._failure)
        elif response is not None:
            self._end(NORMAL_END, _command(self._taken).respond(response))
        elif self._execution:
            self._show_running(machine, self._execution)

    def _show_running(self, machine: Machine, execution: Execution) -> None:
        if execution.stoppable or self._config.skip_run_status != "always":
            interim = execution.interim(machine)
            words = _command(self._taken).respond(interim) if interim else WORDS_AT_REST[1:]
            self._show(RUN, words)

    def _end_abnormally(self, machine: Machine, failure: CommandError) -> None:
        number = failure.number
        place = _place(self._taken[0], failure)
        machine.alarms.latest_of_command = ActiveAlarm(number, machine.now_us, False, place)
        if self._config.command_alarm_is_serious:
            machine.raise_alarm(number, serious=True)
        elif not machine.alarms.has(number):
            machine.alarms.note(number, machine.now_us, place=place)
        data: Words = (0,) * 13
        if failure.response:
            data = _command(self._taken).respond(failure.response)[2:]
        self._end(ABNORMAL_END, (*alarm_code(number), *data))

    def _end(self, status: int, response: Words) -> None:
        self._execution = None
        self._reported = 0
        self.executed += 1
        self._show(status, response)
        self.phase = Phase.ENDED

    def _rest(self, words: Words) -> None:
        """Return to the command ready status; a code in `words` counts as set too early."""
        self._execution = None
        self._shown = WORDS_AT_REST
        self._waits = self._config.early_command_waits and words[0] != 0
        self._blocked = 0 if self._config.early_command_waits else words[0]
        self.phase = Phase.READY

    def _show(self, status: int, response: Words) -> None:
        self._shown = (status, *response)


def _goes_on(execution: Execution, machine: Machine) -> bool:
    """Execute a command for one cycle without showing a status; return False once it has ended."""
    try:
        return execution.step(machine) is None
    except CommandError:
        return False


def _command(words: Words) -> Command:
    return commands()[words[0] & 0x0FFF]


def _place(code: int, failure: CommandError) -> Place | None:
    """Return the robot and axis of a command's alarm; None if the controller raised the alarm."""
    entry = commands().get(code & 0x0FFF)
    own = failure.number.startswith("12.")  # stop and network alarms belong to no robot
    if entry is None or not entry.robot or own:
        return None
    axis = (_AXIS, failure.axis) if failure.axis else (0, 0)
    return Place(_ROBOT, code >> 12 or 1, *axis)


def _check(machine: Machine, words: Words) -> Call:
    """Check code, robot, authority and format of a command, and return the call.

    Raises:
        CommandError: a check has failed; the error has the alarm of the first failed check.
    """
    config = machine.config
    entry = commands().get(words[0] & 0x0FFF)
    robot = words[0] >> 12
    if entry is None or entry.code == 0 or (robot and not entry.robot):
        raise CommandError(config.undefined_code_alarm)
    if robot > 4 or not (config.axes_of(robot) or answers_absent(entry.code)):
        raise CommandError(config.absent_robot_alarm)
    if machine.pendant_authority and not entry.pendant:
        raise CommandError(config.pendant_alarm)
    if entry.problem(words, unused_words=config.strict_unused_words):
        raise CommandError(config.format_alarm)
    return Call(entry.code, machine.arm(robot or 1), entry.decode(words), robot)
