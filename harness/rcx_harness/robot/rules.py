"""Every rule that the virtual controller follows: what the manual says, and what is assumed.

A manual rule has a section. An assumed one, where the manual is silent, has the knobs of
RobotConfig that change it; without a knob it is a simplification of the model.
Sections: `ch. 5, 3.1` is the main manual, `guide, 1.1` the remote command guide in it.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["RULES", "Rule"]


@dataclass(frozen=True)
class Rule:
    """One rule; `section` for what the manual says, `knobs` for what is assumed."""

    id: str
    text: str
    section: str = ""
    knobs: tuple[str, ...] = ()

    @property
    def from_manual(self) -> bool:
        """The manual says so."""
        return bool(self.section)


def _manual(name: str, section: str, text: str) -> Rule:
    return Rule(name, text, section=section)


def _assumed(name: str, knobs: str, text: str) -> Rule:
    return Rule(name, text, knobs=tuple(knobs.split()))


#: In the order of the areas: power and link, dedicated signals, remote commands, movements.
RULES: tuple[Rule, ...] = (
    # Power and link
    _manual("servo-off-at-power-on", "ch. 1, 5", "After power-on the servos are OFF."),
    _manual("cycle", "ch. 5, 4", "Inputs and outputs are updated every 5 ms at the shortest."),
    _manual(
        "link-lost",
        "ch. 1, 5.2",
        "Without a connection SI(00) and SI(06) are OFF inside the controller.",
    ),
    _manual(
        "parallel-stop",
        "ch. 1, 5.1",
        "A parallel I/O board that is valid stops the robot by its own stop input, too.",
    ),
    _assumed("boot", "boot_time", "All outputs are OFF until the controller has booted."),
    _assumed(
        "emergency-at-power-on",
        "power_on_emergency_alarm",
        "SI(00) still OFF at power-on is an emergency stop (SO(00) ON), but raises no alarm: "
        "the initial servo ON process has no alarm reset.",
    ),
    _assumed(
        "power-on-state",
        "auto_mode pendant_authority origin_complete program_is_reset power_on_alarm "
        "parallel_io parallel_stop safety_disables_inputs",
        "Mode, authority, origin, program reset state and alarms at power-on.",
    ),
    _assumed(
        "link-error-at-power-on",
        "link_error_alarm link_error_latches",
        "Without a connection at power-on there is alarm 12.551, until the connection comes.",
    ),
    _assumed(
        "link-loss-alarm",
        "link_loss_alarm",
        "Loss of the connection in operation raises 12.552, besides the emergency stop.",
    ),
    _assumed(
        "link-first-image",
        "recovery_edges",
        "The first image of a connection is taken as it is: levels count, an input that is ON "
        "there makes no edge, and nothing in it counts as a change by the master.",
    ),
    _assumed(
        "link-command",
        "link_loss_alarm",
        "A command that runs when the link is lost ends abnormally; that is shown until a reset.",
    ),
    # Dedicated signals
    _manual(
        "interval",
        "ch. 5, 3",
        "Between two changes of dedicated inputs, of the same or of different ones, there are at "
        "least 100 ms.",
    ),
    _assumed(
        "interval-strict",
        "min_interval",
        "A change that comes earlier is never recognised, nor are two in one exchange.",
    ),
    _assumed(
        "interval-stops",
        "",
        "A switch-off of SI(00) or SI(06) is always taken at once; it begins the interval anew. "
        "One other input that changes in its exchange is not recognised, but that is no fault.",
    ),
    _assumed(
        "interval-levels",
        "late_levels",
        "An input that was not recognised is taken as a level, without an edge, once nothing has "
        "changed for the interval.",
    ),
    _manual("reserved", "ch. 5, 1", "The reserved bits and bytes are not used."),
    _manual(
        "emergency-stop",
        "ch. 5, 3.1",
        "SI(00) OFF in operation turns SO(00) and SO(03) ON and SO(02) OFF; the alarm is 12.600.",
    ),
    _manual(
        "emergency-release",
        "ch. 5, 3.1",
        "SI(00) ON turns SO(00) OFF; SO(03) stays ON until the alarm reset.",
    ),
    _manual(
        "servo-on",
        "ch. 5, 2",
        "SI(01) OFF to ON switches the servos on, if SI(00) is ON and no emergency stop is left.",
    ),
    _manual(
        "alarm-reset",
        "ch. 5, 2",
        "SI(16) OFF to ON resets the alarms, but for those that need a power restart.",
    ),
    _manual(
        "program-reset", "ch. 5, 2", "SI(15) OFF to ON resets the program, in AUTO mode: SO(14) ON."
    ),
    _manual(
        "program-start",
        "ch. 5, 3.2",
        "SI(12) OFF to ON starts the program, if SI(00) and SI(06) are ON: SO(14) OFF, SO(13) ON.",
    ),
    _manual("program-stop", "ch. 5, 3.3", "SI(06) OFF stops the program: SO(13) OFF."),
    _manual("program-restart", "ch. 5, 3.3", "After a stop, SI(06) and SI(12) ON let it go on."),
    _manual(
        "program-emergency",
        "ch. 5, 3.3",
        "An emergency stop stops the program: SO(13) and SO(02) OFF, SO(03) ON.",
    ),
    _manual(
        "stop-alarm",
        "ch. 4, 4",
        "12.400: a program or movement was started in the stop status, or was stopped by it.",
    ),
    _manual("sequence", "ch. 5, 2", "The sequence program runs while SI(10) is ON: SO(12)."),
    _manual("origin", "ch. 5, 2", "SI(14) or SI(17) OFF to ON: return-to-origin, then SO(11) ON."),
    _manual("warning", "ch. 5, 2", "SO(15) is ON while there is a warning."),
    _manual(
        "serious-alarm",
        "ch. 5, 2",
        "A serious error turns SO(03) ON and SO(04) OFF.",
    ),
    _assumed(
        "answers",
        "emergency_stop_delay emergency_release_delay servo_on_delay alarm_reset_delay "
        "program_reset_delay program_start_delay program_stop_delay sequence_delay",
        "Each answer comes after a delay of its own.",
    ),
    _assumed(
        "mp-ready",
        "mp_ready_in_emergency_stop",
        "SO(04) stays ON in an emergency stop and at a link alarm, which the charts do not show "
        "to turn it OFF.",
    ),
    _assumed(
        "servo-needs-reset",
        "servo_on_with_alarm",
        "SI(01) is without effect while SO(03) is ON.",
    ),
    _assumed(
        "minor-alarms",
        "minor_alarms",
        "12.400 goes into the history only: a program goes on after a stop without alarm reset.",
    ),
    _assumed(
        "alarm-stops",
        "alarm_stops_servo",
        "A serious alarm switches the servos off and stops program and movements.",
    ),
    _assumed(
        "alarm-restart",
        "power_restart_alarms",
        "Which alarms need a power restart.",
    ),
    _assumed(
        "reset-after-release",
        "reset_in_emergency_stop",
        "12.600 can be reset only after the emergency stop is released.",
    ),
    _assumed("program-servo", "program_needs_servo", "A program starts with the servos off, too."),
    _assumed(
        "program-reset-running",
        "reset_while_running",
        "SI(15) is without effect while the program runs.",
    ),
    _assumed(
        "program-length",
        "programs",
        "A program is a duration, and ends or begins again.",
    ),
    _assumed("manual-mode", "", "A change to MANUAL mode stops the program."),
    _assumed(
        "origin-model",
        "origin_time origin_needs_servo",
        "A return-to-origin needs servos and stop input ON, takes its time, and ends with all "
        "positions 0; SI(14) and SI(17) do the same.",
    ),
    _assumed(
        "sequence-program", "sequence_program", "There is a sequence program, in either mode."
    ),
    _assumed(
        "pendant-inputs",
        "pendant_blocks_inputs",
        "While the programming box has authority, SI(01), SI(12), SI(14), SI(15) and SI(17) are "
        "without effect.",
    ),
    _assumed(
        "safety-inputs",
        "safety_keeps_stops",
        "A safety setting that disables dedicated inputs leaves SI(00) and SI(06) working.",
    ),
    # Remote commands
    _manual("ready-first", "guide, 1.2", "A command is executed only in the ready status 0x0000."),
    _manual(
        "hold-command",
        "guide, 1.1",
        "A command is held until its end status; if it is changed, its status is not reflected.",
    ),
    _manual("response-with-status", "guide, 2", "Response and end status change at the same time."),
    _manual("status-reset", "guide, 4.1", "0x0000 clears status and response."),
    _manual("run-status", "guide, 1.2", "0x0100 may be skipped where a command is short."),
    _manual(
        "abnormal-end",
        "guide, 1.2",
        "0x4000 has the alarm's group in m+2 and its category in m+4; the rest is 0.",
    ),
    _manual(
        "both-outputs", "guide, 4.2.1", "Both position output flags end in 4.2 Input format error."
    ),
    _manual(
        "safety-commands",
        "guide, 3",
        "A safety setting that disables dedicated inputs disables all commands.",
    ),
    _manual(
        "pendant-commands",
        "guide, 3",
        "While the programming box has authority, only the reference commands work.",
    ),
    _manual("robot-zero", "guide, 4.2.1", "Robot 0 is robot 1."),
    _manual(
        "continuous",
        "guide, 4.7.4",
        "In continuous mode positions come with status 0x0100 until the status reset command.",
    ),
    _manual(
        "stop-in-motion",
        "guide, 1.2",
        "A command that an emergency stop interrupts ends abnormally with 12.600.",
    ),
    _manual("soft-limit", "guide, 1.1", "A target beyond a soft limit ends in 2.334."),
    _assumed(
        "command-times",
        "command_accept_delay command_delay status_reset_delay skip_run_status",
        "How long commands take, and when 0x0100 is skipped.",
    ),
    _assumed(
        "changed-command",
        "changed_command_status",
        "A movement whose command was changed goes on to its end with status 0x0100, then the "
        "status is 0x0000; a code that is there then must go back to 0x0000 first.",
    ),
    _assumed(
        "early-command",
        "",
        "A code set before the status is 0x0000 is never executed; 0x0000 must come first.",
    ),
    _assumed(
        "format",
        "format_alarm strict_unused_words",
        "Ranges, fixed bits and unused words are all checked; the alarm is 4.2.",
    ),
    _assumed(
        "other-alarms",
        "undefined_code_alarm absent_robot_alarm no_axis_alarm pendant_alarm servo_off_alarm "
        "undefined_point_alarm busy_alarm",
        "Where the manual gives no alarm for what a command cannot do, it is 4.2.",
    ),
    _assumed(
        "command-alarms",
        "command_alarm_is_serious",
        "An alarm that ends a command goes into the history; SO(03) stays as it is.",
    ),
    _assumed(
        "movement-beside",
        "motion_during_program",
        "Movements by command are possible while a program runs, not during a return-to-origin.",
    ),
    _assumed(
        "reset-command",
        "",
        "0x0604 ends abnormally with the number of an alarm that it could not reset.",
    ),
    _assumed(
        "unasked-positions",
        "unasked_positions_zero",
        "m+8 to m+30 are 0 where no position was asked for; axes that are not there are 0.",
    ),
    _assumed(
        "flag-bit-0",
        "position_flag_bit0",
        "0x0506 answers bit 0 of m+6 as 1, as the manual prints it in its example.",
    ),
    _assumed(
        "versions",
        "host_version host_revision fpga_version driver_version",
        "The versions of the manual's example.",
    ),
    # Movements
    _assumed(
        "example-points",
        "points",
        "A robot without points of its own knows those of the manual's examples: 19, 50 and 100; "
        "where point 19 lies is ours.",
    ),
    _assumed(
        "profile",
        "axes auto_speed program_speed",
        "PTP: all axes start and end together, the slowest with constant acceleration and speed. "
        "A speed in % is taken of the automatic speed, a direct one of the maximum; without one "
        "the program speed counts, without acceleration 100 %.",
    ),
    _assumed("halt", "", "A stop or emergency stop halts the axes at once, without a ramp."),
    _assumed(
        "millimetres",
        "axes",
        "Millimetres are pulses by a factor per axis, as on a Cartesian robot; hands and arm "
        "rotation are kept in points and do not count in movements.",
    ),
)
