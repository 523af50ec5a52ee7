"""The rules on power, link, dedicated signals, programs and ports; see rules.py."""

from __future__ import annotations

from rcx_harness.robot.rule import Rule, assumed, manual

__all__ = ["SIGNAL_RULES"]

SIGNAL_RULES: tuple[Rule, ...] = (
    # Power and link
    manual("servo-off-at-power-on", "ch. 1, 5", "After power-on the servos are OFF."),
    manual("cycle", "ch. 5, 4", "Inputs and outputs are updated every 5 ms at the shortest."),
    manual(
        "link-lost",
        "ch. 1, 5.2",
        "Without a connection SI(00) and SI(06) are OFF inside the controller.",
    ),
    manual(
        "parallel-stop",
        "ch. 1, 5.1",
        "A parallel I/O board that is valid stops the robot by its own stop input, too.",
    ),
    manual(
        "parallel-inputs",
        "ch. 1, 4.1",
        "All other dedicated inputs of a parallel I/O board are disabled; where the board is set "
        "invalid, its stop input is, too.",
    ),
    manual(
        "emergency-terminal",
        "ch. 1, 5",
        "The emergency stop terminal of the SAFETY connector works with and without a connection.",
    ),
    manual(
        "link-recovery",
        "ch. 1, 5.2",
        "Once the connection is back, SI(00) and SI(06) are those of the master again.",
    ),
    manual(
        "conditions",
        "ch. 3, 1",
        "There is a connection only with the same size at both sides and a valid IP address.",
    ),
    manual(
        "leds",
        "ch. 1, 3",
        "Module Status and Network Status show power, self-test, connection, time-out and faults.",
    ),
    assumed(
        "module-faults",
        "module_fault_alarms module_error_alarms",
        "Which alarms light Module Status red, and which let it flash.",
    ),
    assumed(
        "parallel-reading",
        "parallel_disables_si",
        "The inputs that a parallel I/O board loses are its own; those of the network work. The "
        "other reading: SI(01) and SI(10) to SI(17) are disabled.",
    ),
    assumed(
        "boot",
        "booted boot_time",
        "The controller has booted at time 0. From a later power-on until it has booted all "
        "outputs are OFF.",
    ),
    assumed(
        "emergency-at-power-on",
        "power_on_emergency_alarm",
        "SI(00) still OFF at power-on is an emergency stop (SO(00) ON), but raises no alarm: "
        "the initial servo ON process has no alarm reset.",
    ),
    assumed(
        "emergency-terminal-alarm",
        "",
        "An emergency stop at the SAFETY connector or the programming box is alarm 12.600 also "
        "where SI(00) was OFF already, and at power-on.",
    ),
    assumed(
        "power-on-state",
        "auto_mode pendant_authority origin_complete program_is_reset power_on_alarm "
        "parallel_io parallel_stop safety_disables_inputs ip_address",
        "Mode, authority, origin, program reset state, alarms and address at power-on.",
    ),
    assumed(
        "link-error-at-power-on",
        "link_error_alarm link_error_delay link_error_latches",
        "Without a connection for a while after power-on there is alarm 12.551, until the "
        "connection comes.",
    ),
    assumed(
        "link-loss-alarm",
        "link_loss_alarm",
        "Loss of the connection in operation raises 12.552, besides the emergency stop.",
    ),
    assumed(
        "link-first-image",
        "recovery_edges",
        "The first image of a connection is taken as it is: levels count, an input that is ON "
        "there makes no edge, and nothing in it counts as a change by the master.",
    ),
    assumed(
        "link-command",
        "link_loss_alarm",
        "A command that runs when the link is lost ends abnormally; that is shown until a reset.",
    ),
    # Dedicated signals
    manual(
        "interval",
        "ch. 5, 3",
        "Between two changes of dedicated inputs, of the same or of different ones, there are at "
        "least 100 ms.",
    ),
    assumed(
        "interval-strict",
        "min_interval",
        "A change that comes earlier is never recognised, nor are two in one exchange.",
    ),
    assumed(
        "interval-stops",
        "",
        "A switch-off of SI(00) or SI(06) is always taken at once; it begins the interval anew. "
        "One other input that changes in its exchange is not recognised, but that is no fault.",
    ),
    assumed(
        "interval-levels",
        "late_levels",
        "An input that was not recognised is taken as a level, without an edge, once nothing has "
        "changed for the interval.",
    ),
    manual("reserved", "ch. 5, 1", "The reserved bits and bytes are not used."),
    manual(
        "emergency-stop",
        "ch. 5, 3.1",
        "SI(00) OFF in operation turns SO(00) and SO(03) ON and SO(02) OFF; the alarm is 12.600.",
    ),
    manual(
        "emergency-release",
        "ch. 5, 3.1",
        "SI(00) ON turns SO(00) OFF; SO(03) stays ON until the alarm reset.",
    ),
    manual(
        "servo-on",
        "ch. 5, 2",
        "SI(01) OFF to ON switches the servos on, if SI(00) is ON and no emergency stop is left.",
    ),
    manual(
        "alarm-reset",
        "ch. 5, 2",
        "SI(16) OFF to ON resets the alarms, but for those that need a power restart.",
    ),
    manual(
        "program-reset", "ch. 5, 2", "SI(15) OFF to ON resets the program, in AUTO mode: SO(14) ON."
    ),
    manual(
        "program-start",
        "ch. 5, 3.2",
        "SI(12) OFF to ON starts the program, if SI(00) and SI(06) are ON: SO(14) OFF, SO(13) ON.",
    ),
    manual("program-stop", "ch. 5, 3.3", "SI(06) OFF stops the program: SO(13) OFF."),
    manual("program-restart", "ch. 5, 3.3", "After a stop, SI(06) and SI(12) ON let it go on."),
    manual(
        "program-emergency",
        "ch. 5, 3.3",
        "An emergency stop stops the program: SO(13) and SO(02) OFF, SO(03) ON.",
    ),
    manual(
        "stop-alarm",
        "ch. 4, 4",
        "12.400: a program or movement was started in the stop status, or was stopped by it.",
    ),
    manual("sequence", "ch. 5, 2", "The sequence program runs while SI(10) is ON: SO(12)."),
    manual(
        "auto-switches",
        "ch. 5, 3.2",
        "AUTO mode: the AUTO input of the SAFETY connector ON, the programming box's manual lock "
        "OFF; SO(10) ON.",
    ),
    manual("origin", "ch. 5, 2", "SI(14) or SI(17) OFF to ON: return-to-origin, then SO(11) ON."),
    manual(
        "origin-types",
        "ch. 5, 2",
        "SI(14) moves incremental and semi-absolute axes; SI(17) absolute ones (DI17 mode ABS), or "
        "first these, then the others (ABS/ORG).",
    ),
    manual(
        "origin-mark",
        "ch. 5, 2",
        "Axes with the mark method are not moved by SI(14) and SI(17); while one of them has no "
        "origin, SI(17) does nothing.",
    ),
    manual(
        "mp-ready-power",
        "ch. 5, 2",
        "SO(04) is ON while main power is there and servo ON is possible.",
    ),
    manual(
        "ports",
        "ch. 3, 2",
        "Robot programs wait for and read SI and SIW/SID, and write SO and SOW/SOD: bits and bytes "
        "of ports 2 to 15, words unsigned, double words signed, lower word first.",
    ),
    manual("warning", "ch. 5, 2", "SO(15) is ON while there is a warning."),
    manual(
        "serious-alarm",
        "ch. 5, 2",
        "A serious error turns SO(03) ON and SO(04) OFF.",
    ),
    assumed(
        "answers",
        "emergency_stop_delay emergency_release_delay servo_on_delay alarm_reset_delay "
        "program_reset_delay program_start_delay program_stop_delay sequence_delay "
        "auto_mode_delay",
        "Each answer comes after a delay of its own.",
    ),
    assumed(
        "mp-ready",
        "mp_ready_in_emergency_stop",
        "SO(04) stays ON in an emergency stop and at a link alarm, which the charts do not show "
        "to turn it OFF.",
    ),
    assumed(
        "servo-needs-reset",
        "servo_on_with_alarm",
        "SI(01) is without effect while SO(03) is ON.",
    ),
    assumed(
        "minor-alarms",
        "minor_alarms",
        "12.400 goes into the history only: a program goes on after a stop without alarm reset.",
    ),
    assumed(
        "alarm-stops",
        "alarm_stops_servo",
        "A serious alarm switches the servos off and stops program and movements.",
    ),
    assumed(
        "alarm-restart",
        "power_restart_alarms",
        "Which alarms need a power restart.",
    ),
    assumed("history", "alarm_history_length", "How many alarms the history keeps."),
    assumed(
        "reset-after-release",
        "reset_in_emergency_stop",
        "12.600 can be reset only after the emergency stop is released.",
    ),
    assumed("program-servo", "program_needs_servo", "A program starts with the servos off, too."),
    assumed(
        "program-reset-running",
        "reset_while_running",
        "SI(15) is without effect while the program runs.",
    ),
    assumed(
        "program-length",
        "programs",
        "A program is a duration, or a list of steps in a small part of the robot language; it "
        "ends or begins again.",
    ),
    assumed(
        "tasks",
        "running_shows_all_tasks main_ends_tasks",
        "SO(13) is ON while any task runs. SI(06) and an emergency stop stop all tasks, SI(12) "
        "lets all that were stopped go on, SI(15) resets all; the others outlive the main program.",
    ),
    assumed(
        "outputs-kept",
        "reset_clears_outputs",
        "General-purpose outputs stay as they are at a stop, at the program's end and at its "
        "reset; power-on clears them.",
    ),
    assumed(
        "inputs-on-loss",
        "loss_clears_inputs",
        "Without a connection general-purpose inputs read OFF and 0.",
    ),
    assumed(
        "idle-header",
        "idle_header",
        "A master whose program stands still (the idle header of its cyclic packets) is as good as "
        "gone: the link is lost. The other reading: its last data stand.",
    ),
    assumed(
        "shared-words",
        "program_words_between_commands",
        "Words m+4 to m+30 show the response while the remote status is not 0x0000, and what the "
        "robot programs wrote while it is.",
    ),
    assumed("main-power", "", "Without main power the servos are off; there is no alarm."),
    assumed("manual-mode", "", "A change to MANUAL mode stops the program."),
    assumed(
        "origin-model",
        "origin_time origin_needs_servo origin_clears_complete di17_mode axes",
        "A return-to-origin needs servos and stop input ON and takes its time; SO(11) is OFF until "
        "all axes have their origin. Incremental and absolute axes end at position 0, a "
        "semi-absolute one keeps its own. Without an axis to move, nothing happens.",
    ),
    assumed(
        "origin-kept",
        "power_loses_origin",
        "Only absolute axes keep their origin without power.",
    ),
    assumed("sequence-program", "sequence_program", "There is a sequence program, in either mode."),
    assumed(
        "pendant-inputs",
        "pendant_blocks_inputs",
        "While the programming box has authority, SI(01), SI(12), SI(14), SI(15) and SI(17) are "
        "without effect.",
    ),
    assumed(
        "safety-inputs",
        "safety_keeps_stops",
        "A safety setting that disables dedicated inputs leaves SI(00) and SI(06) working.",
    ),
)
