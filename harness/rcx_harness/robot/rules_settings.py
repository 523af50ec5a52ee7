"""The rules on settings, servos, teaching and origins by remote command; see rules.py."""

from __future__ import annotations

from rcx_harness.robot.rule import Rule, assumed, manual

__all__ = ["SETTING_RULES"]

SETTING_RULES: tuple[Rule, ...] = (
    # Speeds, designations, inching amount, torque
    manual(
        "robot-settings",
        "guide, 4.2.14",
        "Each robot has its own manual, automatic and program speed, selected shift and hand, arm "
        "designation and inching amount.",
    ),
    manual("torque-limit", "guide, 4.2.22", "A max. torque counts from the next movement on."),
    manual("arm-scara", "guide, 4.2.19", "An arm is designated on a SCARA robot only."),
    assumed(
        "first-settings",
        "manual_speed inching_amount",
        "Manual speed and inching amount before they are set; shift 0, hand 0, right-handed arm, "
        "100 % torque.",
    ),
    assumed(
        "settings-power",
        "power_loses_settings",
        "A power cycle ends a max. torque; the other settings are kept.",
    ),
    assumed(
        "select-undefined",
        "",
        "A shift or hand that was never defined is selected where a reference to it ends normally.",
    ),
    assumed(
        "arm-follows",
        "",
        "The arm status takes the arm designation when a movement of the robot starts.",
    ),
    assumed(
        "arm-robots",
        "scara_robots not_scara_alarm",
        "Which robots are SCARA robots; on another one an arm designation ends in this alarm.",
    ),
    # Servos and motor power
    manual("servo-output", "ch. 5, 2", "SO(02) is ON while the motor power is ON."),
    manual(
        "servo-command",
        "guide, 4.2.13",
        "A servo goes on, off or free on one axis, or without an axis on all of the robot.",
    ),
    manual(
        "motor-power",
        "guide, 4.2.20",
        "0x0041 switches motor power and all servos OFF with the brakes applied, 0x0042 both ON, "
        "0x0043 the motor power alone.",
    ),
    assumed(
        "servo-on-command",
        "servo_needs_motor_power motor_power_alarm",
        "Servos and motor power come ON after servo_on_delay where SI(01) could switch them on. "
        "In emergency stop the command ends with 12.600, at a serious alarm with its number, "
        "without main power with this alarm; so does servo ON without motor power.",
    ),
    assumed(
        "servo-off-command",
        "motor_power_stops_program",
        "Servo OFF, servo free and motor power OFF are possible in every state, and end what "
        "moves. Motor power OFF stops the program, too. A free axis stays where it is.",
    ),
    # Points and origins
    manual("teaching", "guide, 4.2.9", "The current position becomes a point in the unit given."),
    assumed(
        "taught-point",
        "",
        "n+6 alone gives the unit of a taught point, which has no hand system and no arm rotation; "
        "servo and origin do not matter.",
    ),
    manual(
        "absolute-reset",
        "guide, 4.2.11",
        "A mark method axis is absolute reset where that is possible: at each quarter rotation "
        "of its motor.",
    ),
    assumed(
        "absolute-reset-model",
        "axes origin_method_alarm absolute_reset_alarm",
        "The quarters count from position 0, which is where the axis is after the reset. The "
        "movement goes on to the next one in its direction, at manual speed; an axis that is there "
        "stays. Both commands end in an alarm on an axis of another method, and the reset between "
        "two quarters.",
    ),
    manual(
        "origin-command",
        "guide, 4.2.12",
        "Incremental and absolute axes move to their origin, semi-absolute ones search; in robot "
        "units robot 0 is all robots, and of the three flags one at most is 1.",
    ),
    assumed(
        "origin-command-axes",
        "semi_absolute_is_incremental",
        "Semi-absolute axes count as incremental ones. Absolute axes go first, the same axes of "
        "all robots together; with none to move the command ends normally.",
    ),
    assumed(
        "origin-command-mark",
        "",
        "Mark method axes do not take part, as with SI(17); one that is incomplete ends the "
        "command with origin_method_alarm.",
    ),
    assumed(
        "origin-command-needs",
        "",
        "A return-to-origin by command needs what a movement needs, and that no other one is under "
        "way on any robot; what stops it ends it with its alarm.",
    ),
)
