"""The rules on remote commands and movements; see rules.py."""

from __future__ import annotations

from rcx_harness.robot.rule import Rule, assumed, manual

__all__ = ["COMMAND_RULES"]

COMMAND_RULES: tuple[Rule, ...] = (
    manual("ready-first", "guide, 1.2", "A command is executed only in the ready status 0x0000."),
    manual(
        "hold-command",
        "guide, 1.1",
        "A command is held until its end status; if it is changed, its status is not reflected.",
    ),
    manual("response-with-status", "guide, 2", "Response and end status change at the same time."),
    manual("status-reset", "guide, 4.1", "0x0000 clears status and response."),
    manual("run-status", "guide, 1.2", "0x0100 may be skipped where a command is short."),
    manual(
        "abnormal-end",
        "guide, 1.2",
        "0x4000 has the alarm's group in m+2 and its category in m+4; the rest is 0.",
    ),
    manual(
        "both-outputs", "guide, 4.2.1", "Both position output flags end in 4.2 Input format error."
    ),
    manual(
        "safety-commands",
        "guide, 3",
        "A safety setting that disables dedicated inputs disables all commands.",
    ),
    manual(
        "pendant-commands",
        "guide, 3",
        "While the programming box has authority, only the reference commands work.",
    ),
    manual("robot-zero", "guide, 4.2.1", "Robot 0 is robot 1."),
    manual(
        "continuous",
        "guide, 4.7.4",
        "In continuous mode positions come with status 0x0100 until the status reset command.",
    ),
    manual(
        "stop-in-motion",
        "guide, 1.2",
        "A command that an emergency stop interrupts ends abnormally with 12.600.",
    ),
    manual("soft-limit", "guide, 1.1", "A target beyond a soft limit ends in 2.334."),
    assumed(
        "command-times",
        "command_accept_delay command_delay status_reset_delay skip_run_status",
        "How long commands take, and when 0x0100 is skipped.",
    ),
    assumed(
        "changed-command",
        "changed_command_status",
        "A movement whose command was changed goes on to its end with status 0x0100, then the "
        "status is 0x0000; a code that is there then must go back to 0x0000 first.",
    ),
    assumed(
        "early-command",
        "",
        "A code set before the status is 0x0000 is never executed; 0x0000 must come first.",
    ),
    assumed(
        "format",
        "format_alarm strict_unused_words",
        "Ranges, fixed bits and unused words are all checked; the alarm is 4.2.",
    ),
    assumed(
        "other-alarms",
        "undefined_code_alarm absent_robot_alarm no_axis_alarm pendant_alarm servo_off_alarm "
        "undefined_point_alarm busy_alarm",
        "Where the manual gives no alarm for what a command cannot do, it is 4.2.",
    ),
    assumed(
        "command-alarms",
        "command_alarm_is_serious",
        "An alarm that ends a command goes into the history; SO(03) stays as it is.",
    ),
    assumed(
        "movement-beside",
        "motion_during_program",
        "Movements by command are possible while a program runs, not during a return-to-origin.",
    ),
    assumed(
        "reset-command",
        "",
        "0x0604 ends abnormally with the number of an alarm that it could not reset.",
    ),
    assumed(
        "unasked-positions",
        "unasked_positions_zero",
        "m+8 to m+30 are 0 where no position was asked for; axes that are not there are 0.",
    ),
    assumed(
        "flag-bit-0",
        "position_flag_bit0",
        "0x0506 answers bit 0 of m+6 as 1, as the manual prints it in its example.",
    ),
    assumed(
        "versions",
        "host_version host_revision fpga_version driver_version",
        "The versions of the manual's example.",
    ),
    # Movements
    assumed(
        "example-points",
        "points",
        "A robot without points of its own knows those of the manual's examples: 19, 50 and 100; "
        "where point 19 lies is ours.",
    ),
    assumed(
        "profile",
        "axes auto_speed program_speed",
        "PTP: all axes start and end together, the slowest with constant acceleration and speed. "
        "A speed in % is taken of the automatic speed, a direct one of the maximum; without one "
        "the program speed counts, without acceleration 100 %.",
    ),
    assumed("halt", "", "A stop or emergency stop halts the axes at once, without a ramp."),
    assumed(
        "millimetres",
        "axes",
        "Millimetres are pulses by a factor per axis, as on a Cartesian robot; hands and arm "
        "rotation are kept in points and do not count in movements.",
    ),
)
