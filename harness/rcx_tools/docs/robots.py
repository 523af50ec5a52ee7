"""Generator of robots.md: the robot models, and their cycle times compared with the catalogue."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

from rcx_harness.robot import RobotConfig
from rcx_harness.spec.robots import RobotModel, law, robot_models
from rcx_tools.docs.cycle_times import fitted, measured_cycle, planned_cycle

__all__ = ["robots_page"]


_HEAD = """\
<!-- generated from spec/robots.toml by `make docs`; do not edit -->

# Robots

By default each axis of the virtual robot is one of X, Y, Z and R. One line in the robot file gives
the robot the arms of a real model:

```toml
robot = "YK400XE"                       # robot 1; ["YK400XE", "SXYX"] is robot 1 and 2

[[axes]]                                # axis 1: missing keys come from the model
start = 130000

[[axes]]                                # axis 2
start = 200000

[parameters]
WEIGHTG = 1500                          # the load in g; it makes the axes slower

[points.1]
mm = [150.0, 240.0, 30.0, 0.0]
hand = 1                                # right-handed
```

Tables `[[axes]]` change the model's axes in their order. Further `[[axes]]` tables add axes. All
other keys are in [files.md](files.md). `rcx new FOLDER --robot YK400XE` creates a project with this
robot.

## Models

Lengths are in mm, angles in degrees, speeds per second. Ranges are the soft limits.

| Model | Arms | X | Y | Z | R | Speed X, Y | Z | R | Load | Source |
|---|---|---|---|---|---|---|---|---|---|---|"""

_COORDINATES = """\
## Coordinates and movements

- X points to the right, Y to the front, and **Z downwards**, as in the controller. At 0
  degrees of axes 1 and 2 the arms are stretched along Y. Seen from above, positive angles turn from
  X to Y. R is the sum of the three angles and 90 degrees. The standard coordinates of a real robot
  may be taught differently.
- Right-handed means that axis 2 is positive: the elbow is to the right of the line from the base to
  the hand. The arm status shows the current pose of the arm. A position in millimetres without a
  hand system uses the arm designation. On lines and arcs, by jog and in relative movements the arm
  does not change.
- PTP: each joint turns evenly, and the path of the tool follows from this. Lines and arcs are lines
  and arcs of the tool. Arch: the arch axis moves as in the manual, the other joints evenly.
- The tool is at the end of the selected hand. A hand on the R axis turns with R. Any other hand
  replaces arm 2: data 1 is its angle in pulses of axis 2, data 2 its additional length, data 3 its
  depth.

| Movement | Alarm | Setting |
|---|---|---|"""

_ALARMS = (
    ("a target beyond a soft limit", "", "none: manual, 1.1"),
    ("a position out of reach of the arms", "out_of_reach_alarm", ""),
    ("a line or an arc with axis 2 nearer to stretched than `outer_angle` (3 degrees)",
     "outer_range_alarm", ""),
    ("a line or an arc from right-handed to left-handed", "to_left_alarm", ""),
    ("a line or an arc from left-handed to right-handed", "to_right_alarm", ""),
    ("DRIVE, DRIVEI, PUSH or an arch axis along X or Y in millimetres", "drive_xy_alarm", ""),
)  # fmt: skip

_LAW = """\
## How fast it gets there

One law holds for all types and axes. An axis has the force of its motor's power at its highest
speed, times a factor. With this force it moves the load and its own mass. Its own mass is a share
of the largest load that it is built for:

    acceleration = {factor} * (power / speed) / ({share} * largest load + load)

For an arm this is the acceleration of its stretched end. For R it is the angular acceleration, with
the largest moment of inertia instead of the largest load. The factor and the share were fitted to
the standard cycle times of {names}:
the smallest, the middle and the largest arm of five. The other two were held out.

**The cycle** is 25 mm up, 300 mm across, 25 mm down, and back, in arch motion with the catalogue's
load. We chose the details that are not in the catalogue. The movement is across the front. Its
distance from the base is that of the hand with the arms at a right angle. R does not change, and
the arch distances are 0 (all axes start and arrive together). The speed is 100 %. *Planned* is the
time of both movements. *Measured* is the time of the remote commands in virtual time, in cycles of
5 ms.

| Model | Load [kg] | Catalogue [s] | Planned [s] | Measured [s] | Difference | |
|---|---|---|---|---|---|---|"""

_CHOICES = """\

The table shows the result of a fit to any other three of the five models (the search ends at a
factor of 12 and a share of 3):

| Fitted to | Factor | Share | Largest error of the two held out |
|---|---|---|---|"""

_LIMITS = """\

So the law is good between the fitted models, and less good beyond them: without the smallest or the
largest arm, the error of that arm grows. A movement in your cell will take another time than in the
model. Use it to test the order of events and the alarms.

## What is not there

The model does not contain flexing arms, settling, collisions, and the tables by which a real
controller reduces the acceleration. It does not set the type number in the answer of the system
configuration (`robot_type` of the axes). [fidelity.md](../explanation/fidelity.md), `robot-figures`
and the rows after it, shows which of these figures are public and which are assumed."""


def robots_page() -> str:
    """Return robots.md as Markdown."""
    return "\n".join([_HEAD, *_lines()]) + "\n"


def _lines() -> Iterator[str]:
    models = robot_models()
    sources = list(dict.fromkeys(model.source for model in models.values()))
    for model in models.values():
        yield _model_row(model, sources.index(model.source) + 1)
    yield ""
    yield from (f"{number}. {source}." for number, source in enumerate(sources, 1))
    yield ""
    yield from (f"- {model.name}: {model.also}" for model in models.values() if model.also)
    yield "- Speeds of axes 1 and 2 of a SCARA robot: the sources give one speed of both together."
    yield "  The model divides it in the ratio that fits YK510XEC, YK610XEC and YK710XEC: they"
    yield "  differ only in arm 1."
    yield "  If no source gives pulses, an axis has the pulses per degree or mm of the YK400XE.\n"
    yield _COORDINATES
    config = RobotConfig()
    for asked, knob, instead in _ALARMS:
        alarm = getattr(config, knob) if knob else "2.334"
        yield f"| {asked} | {alarm} | {f'`{knob}`' if knob else instead} |"
    yield "\n" + _LAW.format(
        factor=law().factor, share=law().own_share, names=_listed(law().fitted)
    )
    for model in models.values():
        for load, seconds in model.cycles:
            yield _cycle_row(model, load, seconds)
    yield _CHOICES
    for names in combinations([name for name, model in models.items() if model.cycles], 3):
        yield _choice_row(names, models)
    yield _LIMITS


def _model_row(model: RobotModel, source: int) -> str:
    ranges = [f"{joint.low:g} to {joint.high:g}" for joint in model.joints]
    speeds = [f"{joint.speed:.0f}" for joint in model.joints]
    cells = [
        model.name,
        " + ".join(f"{arm:g}" for arm in model.arms) or "none",
        *[*ranges, "none"][:4],
        f"{speeds[0]}, {speeds[1]}",
        *[*speeds[2:], "none"][:2],
        f"{model.payload:g} kg",
        str(source),
    ]
    return f"| {' | '.join(cells)} |"


def _cycle_row(model: RobotModel, load: float, seconds: float) -> str:
    planned, measured = planned_cycle(model, law(), load), measured_cycle(model.name, load)
    own = load == model.cycles[0][0]
    part = "another load" if not own else "fitted" if model.name in law().fitted else "held out"
    difference = f"{100 * (measured / seconds - 1):+.1f} %"
    return (
        f"| {model.name} | {load:g} | {seconds:.2f} | {planned:.3f} | {measured:.3f} "
        f"| {difference} | {part} |"
    )


def _choice_row(names: Sequence[str], models: Mapping[str, RobotModel]) -> str:
    of = fitted(names)
    errors = {
        name: planned_cycle(model, of, model.cycles[0][0]) / model.cycles[0][1] - 1
        for name, model in models.items()
        if model.cycles and name not in names
    }
    worst = max(errors, key=lambda name: abs(errors[name]))
    cells = (_listed(names), f"{of.factor:.2f}", f"{of.own_share:.2f}")
    return f"| {' | '.join(cells)} | {100 * errors[worst]:+.1f} % ({worst}) |"


def _listed(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"
