"""The rules on programmed movements (guide, 4.2.1 to 4.2.5, 4.2.21, 4.2.23); see rules.py."""

from __future__ import annotations

from rcx_harness.robot.rule import Rule, assumed, manual

__all__ = ["MOVEMENT_RULES"]

MOVEMENT_RULES: tuple[Rule, ...] = (
    manual(
        "both-outputs", "guide, 4.2.1", "Both position output flags end in 4.2 Input format error."
    ),
    manual(
        "stop-in-motion",
        "guide, 1.2",
        "A command that an emergency stop interrupts ends abnormally with 12.600.",
    ),
    manual("soft-limit", "guide, 1.1", "A target beyond a soft limit ends in 2.334."),
    manual(
        "arch",
        "guide, 4.2.1",
        "The arch axis starts to its arch position; the others start once it has done arch "
        "distance 1; it leaves so that arch distance 2 remains to it when they arrive.",
    ),
    manual(
        "line-speed",
        "guide, 4.2.1",
        "Only lines and arcs take a speed in mm/s: up to 1000 on a SCARA robot, 750 on others.",
    ),
    manual(
        "scara-axis-4",
        "guide, 4.2.1",
        "MOVE direct in mm with axis 4 alone takes axes 1 and 2 of a SCARA robot to the target.",
    ),
    manual(
        "movei-keep",
        "guide, 4.2.2",
        "With Keep, the default of its parameter, an interrupted MOVEI or DRIVEI that is executed "
        "again goes on to its old target.",
    ),
    manual("one-axis", "guide, 4.2.3", "DRIVE, DRIVEI and PUSH move one axis, and name it."),
    manual(
        "push",
        "guide, 4.2.23",
        "PUSH ends after the push time with completion result 1, else at its target with 0.",
    ),
    assumed(
        "movement-beside",
        "motion_during_program",
        "Movements by command are possible while a program runs, not during a return-to-origin.",
    ),
    assumed(
        "unasked-positions",
        "unasked_positions_zero",
        "m+8 to m+30 are 0 where no position was asked for; axes that are not there are 0.",
    ),
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
        "the program speed counts, without acceleration the parameters ACCEL and DECEL.",
    ),
    assumed("halt", "", "A stop or emergency stop halts the axes at once, without a ramp."),
    assumed(
        "millimetres",
        "axes",
        "Millimetres are pulses by a factor per axis, as on a Cartesian robot.",
    ),
    assumed(
        "hand-system",
        "",
        "A movement to a position in mm with a hand system changes the arm status of a SCARA "
        "robot, and no position. Arm rotation is kept in points and does not count: none of the "
        "robots is a YK500TW.",
    ),
    assumed(
        "linear-axes",
        "",
        "Bit 0 of MOVE with linear interpolation, printed as fixed 0 and as a flag, is the axis "
        "designation flag.",
    ),
    assumed(
        "arch-axis-alone",
        "",
        "An arch axis that is not designated to move comes back to where it was.",
    ),
    assumed(
        "arch-distances",
        "arch_zero_is_parameter",
        "An arch distance of 0 is 0, not that of the parameters ARCHP1 and ARCHP2; a negative one "
        "ends in the format alarm.",
    ),
    assumed(
        "movei-start",
        "movei_start_position",
        'The parameter "MOVEI/DRIVEI start position", which no remote command reaches; with Reset '
        "the movement starts anew from where the robot is. It is the same command again where "
        "code, axes and distances are the same; speed and position output may differ.",
    ),
    assumed(
        "movet",
        "",
        "MOVET goes from where the tool is by the point's data along the axes of the tool, which "
        "are those that it designates; they turn with axis 4 where the selected hand is on it. "
        "Data in pulses are a way of each axis.",
    ),
    assumed(
        "push-model",
        "axes",
        "PUSH meets a workpiece where the axis' `workpiece` stands; whatever the force, the axis "
        "stops there, and the push time counts from then on. If it is taken away, the axis is at "
        "once where it would be without it. No other movement meets it.",
    ),
    assumed(
        "push-parameters",
        "",
        "A push time that is not given is PSHTIME; PSHSPD is a part of the speed. PSHFRC, PSHMTD "
        "and PSHJGSP are stored and do not count.",
    ),
)
