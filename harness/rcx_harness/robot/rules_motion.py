"""The rules on jog, inching, paths and coordinates; see rules.py."""

from __future__ import annotations

from rcx_harness.robot.rule import Rule, assumed, manual

__all__ = ["MOTION_RULES"]

MOTION_RULES: tuple[Rule, ...] = (
    # Jog and inching
    manual(
        "jog-stop",
        "guide, 4.2.6",
        "A jog goes on until SI(06) is OFF, and then ends abnormally with 12.400; the position is "
        "shown where it was asked for.",
    ),
    manual("jog-speed", "guide, 4.2.6", "A jog moves at the manual speed of its robot."),
    manual(
        "jog-frames",
        "guide, 4.2.6",
        "Jog and inching move one axis in pulse units, else the tool on a line along one axis of "
        "the Cartesian or tool coordinates.",
    ),
    manual("inching", "guide, 4.2.7", "Inching moves by the inching amount: pulses, or 0.001 mm."),
    assumed(
        "jog-limit",
        "jog_limit",
        "A jog that comes to a soft limit brakes so that it stands there, and ends with 2.334, or "
        "by the knob normally. Away from the limit it can be started.",
    ),
    assumed(
        "jog-refused",
        "",
        "A jog in the stop status ends with 12.400 without a position: it never moved.",
    ),
    assumed(
        "jog-cleared",
        "",
        "A jog whose command is cleared or changed goes on, with status 0x0100, until SI(06) is "
        "OFF or at the soft limit.",
    ),
    assumed("inching-speed", "manual_speed", "Inching moves at the manual speed, too."),
    # Paths
    assumed(
        "path-speed",
        "scara_robots axes",
        "On lines and arcs the speed is that of the tool: 100 % are 1000 mm/s on a SCARA robot, "
        "750 on others, at most what lets no axis exceed its own speed and acceleration. The "
        "other axes turn with it; where they turn by more degrees than X, Y and Z move mm, these "
        "count. A speed in mm/s is not reduced by the automatic speed.",
    ),
    assumed(
        "arc",
        "no_circle_alarm",
        "An arc is the circle through X, Y and Z of where the robot is and both points; the other "
        "axes pass the first point with them. Where there is no circle, the command ends in this "
        "alarm.",
    ),
    assumed(
        "arch-motion",
        "",
        "Where arch distance 1 is longer than the way to the arch position, the others start "
        "there; where distance 2 is longer than the way down, the arch axis waits for them. It "
        "always reaches the arch position.",
    ),
    assumed(
        "limits-on-the-way",
        "",
        "Soft limits are looked at before a movement starts: at the target, on lines and arcs on "
        "the whole way, of an arch at the arch position. An axis beyond its limit can come back.",
    ),
    assumed(
        "arrival",
        "end_in_tolerance",
        "A movement ends when all its axes are at the target; by the knob, when they are within "
        "the parameter TOLE, of an arch OUTPOS (the OUT valid position range).",
    ),
    assumed(
        "coordinates",
        "axes shifts hands",
        "Axes 1 to 3 are X, Y and Z, axis 4 is R about Z, in degrees. Positions in millimetres "
        "are those of the tool, at the end of the selected hand (data 1 to 3), in the coordinates "
        "of the selected shift; pulses know neither. A hand on the R axis turns with it, and so "
        "do the tool coordinates; else these lie as the Cartesian ones.",
    ),
    assumed(
        "robots-move",
        "",
        "Each robot moves for itself, also while another one returns to its origin; a stop ends "
        "all movements, servo OFF those of its axes. A robot that moves takes no other movement.",
    ),
    assumed(
        "relative-kept",
        "",
        "Only the last movement of a robot can be gone on with: another one, a return-to-origin "
        "or a power cycle in between makes MOVEI and DRIVEI start anew.",
    ),
)
