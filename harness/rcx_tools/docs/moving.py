"""Generator of docs/first.svg, the picture of the README: a moving arm and its signals.

Arm and signals are drawn from one run of example 04, with the dimensions of a real robot
(scara.toml). The animation is SMIL, which browsers also play inside an `img`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate
from math import cos, pi, radians, sin

from rcx_harness.cell import Cell
from rcx_harness.robot.shape import shapes
from rcx_harness.trace.chart_svg import CURVE, STYLE, Look, Scale, document, draw_lane, rule, text
from rcx_tools.docs.examples import FOLDER, ChartSpec, Recorder, examples

__all__ = ["moving_svg"]

_ORIGIN = (
    "<!-- generated from a run of plc/examples/04_pick_and_place by `make docs`; do not edit -->"
)
_ROBOT = FOLDER / "04_pick_and_place/scara.toml"
_SPEC = ChartSpec(
    "Pick and place, as the virtual controller moves a SCARA robot",
    700_000,
    3_500_000,
    (
        "stage Main.Carry.Stage = Carry.Stage",
        "SI01 = SI(01) servo on",
        "SO02 = SO(02) servos on",
        "Main.Carry.Execute = Carry.Execute",
        "Main.Carry.Done = Carry.Done",
        "DO(20) = DO(20) hand closed",
        "axis 1 = Axis 1 [pulse]",
        "axis 2 = Axis 2 [pulse]",
        "Main.Cycle.Count = Parts placed",
    ),
)
#: Sampling period of the arm [us]; factor by which the animation is slowed down; pause at the end
#: [s].
_SAMPLE_US, _SLOWER, _REST_S = 20_000, 2, 1.2
_WIDTH, _HEIGHT, _ROW, _TOP = 1080, 392, 28, 66
_NAMES, _LEFT, _RIGHT = 372, 530, 1066
#: Position of the robot's first joint [px], and pixels per mm.
_X, _Y, _SCALE = 172, 226, 0.25
_STYLE = (
    STYLE + ".h{font-weight:bold;font-size:15px}.m{font-size:10px;fill:#777}"
    ".b{font-size:10.5px;text-anchor:middle}.e{text-anchor:end}"
    ".reach{fill:#1a62ab;fill-opacity:.08;stroke:#1a62ab;stroke-opacity:.4}"
    ".arm{stroke:#566371;stroke-width:15;stroke-linecap:round}"
    ".fore{stroke:#4b86bf;stroke-width:11;stroke-linecap:round}"
    ".way{stroke:#a03a6a;stroke-width:1.5}.joint{fill:#fff;stroke:#222;stroke-width:1.5}"
    ".point{fill:#1b7a3d}.tip{fill:#b34f00}.now{stroke:#b34f00;stroke-width:1.5}"
)

#: Angles of both arms of the robot [degree].
_Angles = tuple[float, float]


def moving_svg() -> str:
    """Return the picture, from a run on the built-in engine.

    Raises:
        InputError: the run broke a rule.
    """
    recorder, angles = Recorder(_SPEC), list[_Angles]()
    example = examples()["04_pick_and_place"]
    with example.build("builtin", watch=recorder.watch, robot=[_ROBOT]) as cell:
        recorder.listen(cell)
        cell.run(_SPEC.begin_us)
        angles.append(_angles(cell))
        while cell.now_us < _SPEC.end_us:
            cell.run(_SAMPLE_US)
            angles.append(_angles(cell))
        shape = shapes(cell.robot)[0]
    upper, fore = shape["arms"]
    body = [
        text(14, 26, _SPEC.title, "h"),
        text(14, 46, f"{shape['name']}, from above; half as fast as in the run", "m"),
        *_robot(angles, upper, fore, [(one["number"], one["mm"]) for one in shape["points"]]),
        *_chart(recorder),
    ]
    return document(_WIDTH, _HEIGHT, _STYLE, body, [f"<title>{_SPEC.title}</title>", _ORIGIN])


def _angles(cell: Cell) -> _Angles:
    """Return the angles of both arms, counterclockwise from straight ahead [degree]."""
    axes = shapes(cell.robot)[0]["axes"][:2]
    pairs = zip(cell.robot.positions, axes, strict=False)
    first, second = ((pulses - axis["zero"]) / axis["per"] for pulses, axis in pairs)
    return first, second


def _robot(
    angles: Sequence[_Angles], upper: float, fore: float, points: Sequence[tuple[int, list[float]]]
) -> Iterator[str]:
    reach = (upper + fore) * _SCALE
    yield f'<circle class="reach" cx="{_X}" cy="{_Y}" r="{reach:g}"/>'
    way = [_tip(one, upper, fore) for one in angles]
    steps = " ".join(f"{x:.1f},{y:.1f}" for x, y in dict.fromkeys(way))
    yield f'<polyline class="way" fill="none" points="{steps}"/>'
    for number, place in points:
        x, y = _X + place[0] * _SCALE, _Y - place[1] * _SCALE
        yield f'<circle class="point" cx="{x:g}" cy="{y:g}" r="5"/>'
        yield text(x + 8, y + 16, f"P{number}")
    first, second = ([-one[k] for one in angles] for k in (0, 1))
    long, short = upper * _SCALE, fore * _SCALE
    yield f'<g transform="translate({_X} {_Y})"><g transform="rotate({first[0]:.1f})">'
    yield _turning(first)
    yield rule("arm", 0, 0, 0, -long)
    yield f'<g transform="translate(0 {-long:g})"><g transform="rotate({second[0]:.1f})">'
    yield _turning(second)
    yield rule("fore", 0, 0, 0, -short)
    yield f'<circle class="tip" cy="{-short:g}" r="6"/></g>'
    yield '<circle class="joint" r="4"/></g></g><circle class="joint" r="6"/></g>'


def _tip(angles: _Angles, upper: float, fore: float) -> tuple[float, float]:
    """Return the position of the tool in the picture, rounded to a tenth of a pixel."""
    first, both = radians(angles[0]), radians(sum(angles))
    ahead = upper * cos(first) + fore * cos(both)
    right = upper * sin(first + pi) + fore * sin(both + pi)
    return round(_X + right * _SCALE, 1), round(_Y - ahead * _SCALE, 1)


def _turning(angles: Sequence[float]) -> str:
    return _animated("animateTransform", "transform", [f"{one:.1f}" for one in angles], "rotate")


def _animated(element: str, attribute: str, values: Sequence[str], kind: str) -> str:
    """Return an SVG animation of the run with a pause at its end. Repeated values are left out."""
    run_s = (_SPEC.end_us - _SPEC.begin_us) / 1e6 * _SLOWER
    whole_s = run_s + _REST_S
    last = len(values) - 1
    kept = [
        (number, value)
        for number, value in enumerate(values)
        if number in (0, last) or values[number - 1] != value or values[number + 1] != value
    ]
    times = [f"{number / last * run_s / whole_s:.4f}".rstrip("0") for number, _ in kept]
    texts = [value for _, value in kept]
    return (
        f'<{element} attributeName="{attribute}" type="{kind}" dur="{whole_s:g}s" '
        f'repeatCount="indefinite" keyTimes="{";".join([*times, "1"])}" '
        f'values="{";".join([*texts, texts[-1]])}"/>'
    )


def _chart(recorder: Recorder) -> Iterator[str]:
    axis = Scale(_LEFT, _RIGHT, _SPEC.begin_us, _SPEC.end_us)
    heights = [CURVE + 14 if lane.kind == "curve" else _ROW for lane in recorder.lanes]
    bases = list(accumulate(heights, initial=_TOP))[1:]
    yield text(_NAMES, _TOP - 6, "time [s]", "m")
    for t_us, x in axis.round_times((500_000,), 12):
        yield text(x, _TOP - 6, f"{t_us / 1e6:g}", "t")
        yield rule("g", x, _TOP, x, bases[-1])
    for lane, base, high in zip(recorder.lanes, bases, heights, strict=True):
        yield rule("r", _NAMES, base, _RIGHT, base)
        yield text(_NAMES, base - high / 2 + 5, lane.name)
        yield from draw_lane(lane, axis, base - 6, Look(edge=0))
    moved = ["0 0", f"{_RIGHT - _LEFT} 0"]
    yield f'<g><line class="now" x1="{_LEFT}" y1="{_TOP}" x2="{_LEFT}" y2="{bases[-1]}"/>'
    yield f"{_animated('animateTransform', 'transform', moved, 'translate')}</g>"
