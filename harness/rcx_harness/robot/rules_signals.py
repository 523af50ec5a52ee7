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
        "Where there is a parallel I/O board, all dedicated inputs but its stop input DI06 are "
        "disabled; where the board is set invalid, that is, too.",
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
        "The dedicated inputs that are disabled beside a parallel I/O board are its own; those of "
        "the network work. The other reading: SI(01) and SI(10) to SI(17) are disabled.",
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
        "Mode, authority, origin, program reset state, alarms and address at power-on. Later, what "
        "surrounds the controller stays through a power cycle: switches, stops, authority, safety "
        "setting, main power and the inputs of the parallel I/O board.",
    ),
    assumed(
        "power-cycle",
        "",
        "A power cycle ends all alarms and the warning; the alarm history and the latest alarm of "
        "a remote command stay. Programs are at their first line, their variables 0. It ends a "
        "running remote command, without a status.",
    ),
    assumed(
        "link-error-at-power-on",
        "link_error_alarm link_error_delay link_error_latches",
        "Without a connection for a while after power-on there is alarm 12.551, until the "
        "connection comes; it turns neither SO(03) ON nor SO(04) OFF. The other reading: it is a "
        "serious one, which stays until an alarm reset.",
    ),
    assumed(
        "link-loss-alarm",
        "link_loss_alarm",
        "Loss of the connection in operation raises 12.552, besides the emergency stop. Chapter 4, "
        "4 gives cable and master as causes of 12.551 and of 12.552 alike.",
    ),
    assumed(
        "link-first-image",
        "recovery_edges",
        "The first image of a connection is taken as it is: levels count, an input that is ON "
        "there makes no edge, and nothing in it counts as a change by the master; the interval "
        "counts from no change before it.",
    ),
    assumed(
        "first-image-command",
        "first_image_commands",
        "A command code in the first image of a connection is executed like any other, if the "
        "status is 0x0000. The other reading: another code or 0x0000 must come first.",
    ),
    assumed(
        "link-command",
        "link_loss_alarm",
        "A command that runs when the link is lost ends abnormally; that is shown until a reset. "
        "One that was not begun yet, continuous output, and a status that is being reset leave the "
        "ready status.",
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
        "A change that comes earlier is never recognised, nor are two in one exchange; each "
        "change begins the interval anew, also one that is not recognised.",
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
        "ch. 5, 3.1; guide, 1.2",
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
    manual(
        "program-restart",
        "ch. 5, 3.3",
        "After a stop, SI(06) and SI(12) ON start the program again: SO(13) ON.",
    ),
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
        "warning-reset",
        "reset_clears_warning",
        "A warning comes and goes by itself: an alarm reset leaves it.",
    ),
    assumed(
        "cpu-ok",
        "cpu_fault_alarms",
        "SO(01) is ON from the end of the boot on, also with an alarm; those of the knob turn it "
        "OFF.",
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
        "SO(04) stays ON in an emergency stop and at a link alarm, although SO(03) is ON. Word for "
        "word chapter 5, 2 has one serious error turn SO(03) ON and SO(04) OFF; but the shift to "
        "emergency stop of 3.1 lists all outputs that change, and SO(04) is not among them, nor "
        "does it come back in the process from there to servo ON, where SO(03) goes OFF. So an "
        "emergency stop is an alarm, and no error that takes the readiness. The other reading: "
        "SO(04) is OFF whenever SO(03) is ON, and in an emergency stop.",
    ),
    assumed(
        "servo-needs-reset",
        "servo_on_with_alarm",
        "SI(01) is without effect while SO(03) is ON.",
    ),
    assumed(
        "minor-alarms",
        "minor_alarms",
        "12.400 goes into the history only: a program goes on after a stop without alarm reset. "
        "It comes at SI(12), SI(14) and SI(17) in the stop status, too.",
    ),
    assumed(
        "alarm-stops",
        "alarm_stops_servo",
        "A serious alarm switches the servos off and stops program and movements; until its reset "
        "nothing starts. The other reading: the servos stay on, and what runs goes on.",
    ),
    assumed(
        "free-axes",
        "servo_off_brakes_free_axes",
        "An axis that is free gets its brake in an emergency stop, at a serious alarm and without "
        "main power. The other reading: it stays free. Power off and 0x0041 lock every brake.",
    ),
    assumed(
        "alarm-restart",
        "power_restart_alarms",
        "Which alarms need a power restart.",
    ),
    assumed(
        "history",
        "alarm_history_length",
        "How many alarms the history keeps. An alarm that is active already is not entered again.",
    ),
    assumed(
        "reset-after-release",
        "reset_in_emergency_stop",
        "12.600 can be reset only after the emergency stop is released.",
    ),
    assumed("program-servo", "program_needs_servo", "A program starts with the servos off, too."),
    assumed(
        "program-mode",
        "start_needs_auto",
        "A program starts in AUTO mode only: the manual asks for it at the reset. Return-to-origin "
        "and the remote commands of all categories but 5 work in both modes.",
    ),
    assumed(
        "program-goes-on",
        "restart_begins_anew",
        "Started again after a stop, a program goes on where it was. The other reading: it begins "
        "at its first line.",
    ),
    assumed(
        "start-withdrawn",
        "",
        "What stops a program also takes back a start that was not answered yet, without an alarm.",
    ),
    assumed(
        "program-reset-running",
        "reset_while_running",
        "SI(15) is without effect while the program runs, also where it starts before the answer.",
    ),
    assumed(
        "program-length",
        "programs",
        "A program is a duration, or a list of steps in a small part of the robot language, of "
        "which it does 100 in a cycle at most; it ends or begins again.",
    ),
    assumed(
        "tasks",
        "running_shows_all_tasks main_ends_tasks",
        "SO(13) is ON while any task runs. SI(06) and an emergency stop stop all tasks, SI(12) "
        "lets all that were stopped go on, SI(15) resets all; the others outlive the main program. "
        "A suspended task goes on with RESTART only. The time of a DELAY stands still in a stop, "
        "that of OUT does not.",
    ),
    assumed(
        "outputs-kept",
        "reset_clears_outputs",
        "General-purpose outputs stay as they are at a stop, at the program's end and at its "
        "reset; power-on clears them. Of a value that is too long the lower bits count.",
    ),
    assumed(
        "internal-outputs",
        "power_clears_internal_outputs",
        "Power-on clears MO, LO and TO, too; the manual does not say whether they are kept.",
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
    assumed(
        "main-power",
        "main_power_alarm motor_power_stops_program",
        "Without main power the servos are off; there is no alarm. Its loss ends movements and "
        "stops the programs; they stay so when it comes back. The other reading: programs go on.",
    ),
    assumed(
        "manual-mode",
        "manual_mode_stops_program",
        "A change to MANUAL mode stops the programs, not the movements.",
    ),
    assumed(
        "origin-model",
        "origin_time origin_needs_servo origin_clears_complete di17_mode axes",
        "A return-to-origin needs servos and stop input ON and takes its time; SO(11) is OFF until "
        "all axes have their origin. Incremental and absolute axes end at position 0, a "
        "semi-absolute one keeps its own; the positions change at the end of that time only. "
        "Without an axis to move, nothing happens, nor while any axis moves. What was moving at a "
        "stop has no origin; what had not begun keeps its own.",
    ),
    assumed(
        "origin-kept",
        "power_loses_origin",
        "Only absolute axes keep their origin without power.",
    ),
    assumed(
        "sequence-program",
        "sequence_program emergency_stops_sequence",
        "There is a sequence program, in either mode. It ends at once with SI(10), without a "
        "connection and under a safety setting, but not in a stop or an emergency stop.",
    ),
    assumed(
        "pendant-inputs",
        "pendant_blocks_inputs",
        "While the programming box has authority, SI(01), SI(12), SI(14), SI(15) and SI(17) are "
        "without effect; what runs goes on.",
    ),
    assumed(
        "safety-inputs",
        "safety_keeps_stops",
        "A safety setting that disables dedicated inputs leaves SI(00) and SI(06) working. The "
        "other reading: both are without effect, as if they were ON. Inputs that are ON when it "
        "ends make no edge.",
    ),
)
