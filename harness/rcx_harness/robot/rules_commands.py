"""The rules on the handshake and format of remote commands; see rules.py."""

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
    assumed(
        "command-times",
        "command_accept_delay command_delay status_reset_delay skip_run_status",
        "How long commands take, and when 0x0100 is skipped: short, what takes less than a cycle. "
        "A command that moves nothing and switches no servo on acts at the end of its time.",
    ),
    assumed(
        "changed-command",
        "changed_command_status",
        "A command that was changed goes on to its end with status 0x0100, then the status is "
        "0x0000. The other reading: the status is 0x0000 at once, and the next command is taken "
        "beside what goes on. An alarm that ends it is not entered. One that was not begun yet is "
        "never executed.",
    ),
    assumed(
        "changed-data",
        "data_belong_to_command",
        "Data are held as the code is: a changed word of n+2 to n+30 changes the command, also if "
        "the command does not use it. The other reading: they are taken with the code and are free "
        "from then on.",
    ),
    assumed(
        "early-command",
        "early_command_waits",
        "A code set before the status is 0x0000 is never executed; 0x0000 or another code must "
        "come first. The other reading: it is executed once the status is 0x0000.",
    ),
    assumed(
        "disabled-while-running",
        "",
        "A command that runs when the programming box takes authority or a safety setting comes "
        "goes on to its end.",
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
        "Where the manual gives no alarm for what a command cannot do, it is 4.2. Of several "
        "reasons the first counts: code, robot, authority, format, then the robot's state. A "
        "number of a robot without axes is refused, but where absent-robot-zero has an answer.",
    ),
    assumed(
        "command-alarms",
        "command_alarm_is_serious",
        "An alarm that ends a command goes into the history; SO(03) stays as it is.",
    ),
    assumed(
        "reset-command",
        "",
        "0x0604 ends abnormally with the number of an alarm that it could not reset.",
    ),
    assumed(
        "flag-bit-0",
        "position_flag_bit0",
        "0x0506 answers bit 0 of m+6 as 1, as the manual prints it in its example.",
    ),
    assumed(
        "versions",
        "host_version host_revision fpga_version driver_version",
        "The versions of the manual's example; one driver for each axis, four at most.",
    ),
)
