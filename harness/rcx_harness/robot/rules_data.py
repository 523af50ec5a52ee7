"""The rules on ports, programs, references, clock and real time output; see rules.py."""

from __future__ import annotations

from rcx_harness.robot.rule import Rule, assumed, manual

__all__ = ["DATA_RULES"]

DATA_RULES: tuple[Rule, ...] = (
    # Ports
    manual(
        "port-commands",
        "guide, 4.5.1",
        "DO, MO, SO, LO and TO are assigned in bytes or bits, from port 2 on where 0 and 1 are "
        "dedicated; these, DI and SI are read in bytes.",
    ),
    assumed(
        "other-ports",
        "",
        "SO16() to SO27() are kept and read back, but are not in the area; SI16() to SI27() are "
        "0. SO0() and SO1() read as the dedicated outputs, DO0() and DO1() as 0. DI(06) is the "
        "stop input of the parallel I/O board, where there is one. An arm lock output does not "
        "hold its axis, and no timer runs.",
    ),
    # Programs
    manual(
        "register-program",
        "guide, 4.6.1",
        "A program is registered in a task with a priority; task 0 is the lowest vacant one. Of "
        "programs with the same first 16 characters the lowest number counts.",
    ),
    manual(
        "program-received",
        "guide, 1.2",
        "A normal end in category 5 says that the command was received; SO(13) and SO(14) show "
        "what comes of it.",
    ),
    manual(
        "program-lines",
        "guide, 4.6.2",
        "Step does one line and goes into a subroutine, next does a subroutine as a whole, skip "
        "leaves a line out.",
    ),
    manual(
        "program-info",
        "guide, 4.6.4",
        "Program, task, line (+ 10000 in COMMON), priority and name, filled with spaces.",
    ),
    assumed(
        "task-table",
        "undefined_program_alarm undefined_task_alarm",
        "The main program is in task 1 from power-on; START registers a program in the lowest "
        "vacant task, with priority 32, until its end or a reset of all. A program is in one task "
        "at most: registering moves it, puts it to its first line, and takes out what was there. "
        "A program that is not there, or is in no task, is one of these alarms.",
    ),
    assumed(
        "priorities", "", "In each cycle tasks of a low priority number go first, then the others."
    ),
    assumed(
        "execute-programs",
        "manual_mode_alarm",
        "Programs are run, stepped, skipped and reset in AUTO mode. To run or step, nothing may be "
        "in the way that stops SI(12); its alarm ends the command. All programs are those in a "
        "task that are stopped or ready, if there are none and none runs, those that have ended.",
    ),
    assumed(
        "busy-programs",
        "",
        "A running program is not stepped, skipped, registered or reset: busy_alarm. To run it is "
        "a normal end without effect. SO(14) comes ON once all programs in a task are reset, and "
        "goes OFF at a skip, too.",
    ),
    assumed(
        "program-info-details",
        "program_info_while_running",
        "A running program answers, too; COMMON is a program with that name.",
    ),
    assumed(
        "name-filler",
        "name_filler",
        "A program name is filled with spaces, as the text says, or with zeros, as in the example; "
        "one that is sent with either, not with both.",
    ),
    assumed(
        "task-states",
        "waiting_is_standby",
        "A task that waits for an input is in standby; one that was reset, was stopped or has "
        "ended is stopped. An ended task is at line 1.",
    ),
    # References
    manual(
        "references",
        "guide, 4.7",
        "What other commands set, and the state of servos, origins and alarms, is read back. Axes "
        "that are not there are 9 or 0, as each table says.",
    ),
    manual(
        "absent-robot-zero",
        "guide, 4.7.8",
        "Speeds and arm of a robot without axes are 0.",
    ),
    manual(
        "origin-system",
        "guide, 4.7.11",
        "Robot 0 is the entire system: one state, whatever the motor type.",
    ),
    assumed(
        "origin-types-read",
        "",
        "Semi-absolute axes count as incremental ones, as in a return-to-origin by command.",
    ),
    assumed(
        "continuous-details",
        "",
        "Continuous positions are new in every cycle, in an alarm, too; they end without an end "
        "status.",
    ),
    assumed("robot-type", "axes", "The type of a robot is that of its first axis."),
    assumed("position-hand", "position_hand", "0x0506 answers hand system 0, or that of the arm."),
    assumed(
        "torque-model",
        "axes",
        "With the servo off a torque is 0, at rest the axis' holding torque, on the way the moving "
        "torque beside it, never beyond the max. torque in effect. A push is no movement here.",
    ),
    assumed(
        "messages",
        "newest_message_first",
        "Message 1 is the newest one. Entries that are not there are 0, or undefined_data_alarm; "
        "so is the latest alarm of a remote command before the first one, always 0.",
    ),
    assumed(
        "alarm-places",
        "",
        "The alarm of a command with a robot comes from that robot, a soft limit from its axis; "
        "12.400, 12.600 and all others from controller 1, those of the network from the slot of "
        "the EtherNet/IP unit.",
    ),
    assumed(
        "option-slots",
        "option_slots ivy2_unit absent_controller_alarm",
        "The units of the manual's example, in controller 1; there is no other controller.",
    ),
    # Utilities
    manual("clock-set", "guide, 4.8", "Date and time are set and read back."),
    assumed(
        "clock",
        "clock impossible_date_alarm",
        "The clock begins with the manual's example and runs on virtual time, without power, too. "
        "Years are 2000 to 2099; setting the date keeps the time and the other way round. A day "
        "that does not exist is refused.",
    ),
    manual(
        "accumulated-reset",
        "guide, 4.8.4",
        "Servo ON count and time and moving distance are reset per motor or for all motors; power "
        "ON count, motor power ON count and operating time for the system.",
    ),
    assumed(
        "accumulated",
        "motor_data_of_all_robots",
        "All motors are those of the designated robot. The robot number of a system reset has no "
        "effect. The data survive a power cycle; real time output shows them.",
    ),
    # Real time output
    manual(
        "real-time-output",
        "guide, 4.9",
        "Words 24 to 127 show what was defined for them while the function is valid; item 13 is "
        "the motor duty of a robot's axis.",
    ),
    assumed(
        "real-time-items",
        "real_time_items",
        "The list of items is in another manual: which numbers show what. Others show 0; a word "
        "without definition answers item 0. A word is signed as its quantity; `.high` is the "
        "upper word. Motor duty is the torque in % of the rated one, without sign.",
    ),
    assumed(
        "real-time-update",
        "real_time_interval",
        "How often the words are updated. Words that are not put out are the robot programs'.",
    ),
    assumed(
        "real-time-stored",
        "",
        "Definitions and validity survive a power cycle; with 48 bytes they are kept without "
        "effect. A definition for an axis that is not there is no_axis_alarm.",
    ),
)
