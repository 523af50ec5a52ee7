"""The rules on stored data: points, pallets, shifts, hands, variables, parameters; see rules.py."""

from __future__ import annotations

from rcx_harness.robot.rule import Rule, assumed, manual

__all__ = ["MEMORY_RULES"]

MEMORY_RULES: tuple[Rule, ...] = (
    manual(
        "point-hand",
        "guide, 4.3.1",
        "Hand and arm rotation count only in mm and with a SCARA robot; patterns without a "
        "meaning are none or 0.",
    ),
    manual(
        "comment-characters",
        "guide, 4.3.2",
        "A comment has 16 characters from 0x20 to 0x7E.",
    ),
    manual(
        "pallet-size",
        "guide, 4.3.3",
        "Nx * Ny * Nz is 1 to 32767; five points from the first one on define the pallet.",
    ),
    manual("hand-robot", "guide, 4.3.5", "Each robot has its own hands; 0xR111 names the robot."),
    manual(
        "variable-types",
        "guide, 4.4.1",
        "0 to 31 are integers; 256 to 287 are real numbers of single precision, as their bits.",
    ),
    manual(
        "parameter-axis",
        "guide, 4.4.2",
        "A parameter of an axis takes exactly one axis, one of a robot none.",
    ),
    manual(
        "pallet-point",
        "guide, 4.4.3",
        "A pallet point needs a defined pallet, whose size is the highest work position.",
    ),
    assumed(
        "stored",
        "",
        "Points, comments, pallets, shifts, hands, variables and parameters survive a power cycle.",
    ),
    assumed(
        "undefined-data",
        "undefined_data_alarm",
        "Comments, shifts and hands that were never defined are empty or 0; where the knob has a "
        "number, their reference ends with that alarm, except shift 0 and hand 0, as selected "
        "after power-on. A comment needs no point.",
    ),
    assumed(
        "undefined-pallet",
        "undefined_pallet_alarm work_position_alarm",
        "A pallet that is not defined, or a work position beyond it, ends in 4.2.",
    ),
    assumed(
        "preset-data",
        "comments pallets shifts hands variables parameters",
        "A robot file may preset all that is stored; else only the example points are there.",
    ),
    assumed(
        "comment-end",
        "comment_filler",
        "A comment is filled up with zeros or spaces, which are no part of it; zeros are behind "
        "everything else. The answer is filled with 0.",
    ),
    assumed(
        "work-positions",
        "",
        "Work positions count in X first, then Y, then Z. The five points are the first position, "
        "the ends in X and Y, the corner of both and the end in Z; between them all axes are "
        "interpolated and rounded. Points of a direction with one position are not looked at.",
    ),
    assumed(
        "point-units",
        "point_unit_alarm",
        "Points that are added, or define a pallet, have the same unit, and an element is assigned "
        "in the unit of its point; else 4.2. The result has hand and arm rotation of point 1, or "
        "of the pallet's first point.",
    ),
    assumed(
        "hand-data",
        "",
        "Hand data are kept as on the wire, whatever the robot; data 4 is 0 or 1.",
    ),
    assumed(
        "overflow",
        "overflow_alarm division_alarm",
        "A result beyond 32 bits or single precision, and a division by 0, end in 4.2; nothing "
        "changes then. Infinite values and those that are no number are refused as a wrong format.",
    ),
    assumed(
        "real-to-integer",
        "real_to_integer",
        "What an integer variable gets is rounded to the nearest, a half away from 0; also the "
        "quotient of two integers.",
    ),
    assumed(
        "mixed-arithmetic",
        "",
        "Two integers are calculated without loss, all else in single precision.",
    ),
    assumed(
        "payload",
        "max_payload",
        "The maximum payload is 50 kg for robots and axes; WEIGHT and WEIGHTG are one payload, "
        "given in kg without a fraction or in g.",
    ),
    assumed(
        "parameter-defaults",
        "",
        "As delivered: ACCEL, DECEL, PSHFRC, PSHSPD 100, TOLE 80, OUTPOS, ARCHP1, ARCHP2 2000, "
        "PSHTIME 1000, all others 0.",
    ),
    assumed(
        "several-elements",
        "several_elements",
        "An element assignment with several data numbers assigns the value to each of them: the "
        "guide does not ask for exactly one, as it does for axes. The blocks give one.",
    ),
)
