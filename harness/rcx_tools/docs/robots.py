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

Without further ado the virtual controller moves a robot whose axes are X, Y, Z and R themselves. A
line in the robot file gives it the arms of a real one:

```toml
robot = "YK400XE"                       # robot 1; ["YK400XE", "SXYX"] is robot 1 and 2

[[axes]]                                # axis 1: what is left out is the model's
start = 130000

[[axes]]                                # axis 2
start = 200000

[parameters]
WEIGHTG = 1500                          # the load in g: it makes the axes slower

[points.1]
mm = [150.0, 240.0, 30.0, 0.0]
hand = 1                                # right-handed
```

Tables `[[axes]]` change the model's axes in their order, further ones are axes of their own. All
other keys are those of [files.md](files.md). `rcx new FOLDER --robot YK400XE` begins a project
with one.

## Models

Lengths in mm, angles in degrees, speeds per second. Ranges are the soft limits.

| Model | Arms | X | Y | Z | R | Speed X, Y | Z | R | Load | Source |
|---|---|---|---|---|---|---|---|---|---|---|"""

_COORDINATES = """\
## Where it goes

- X points to the right, Y to the front, **Z downwards**, as the controller counts it: at 0 degrees
  of axes 1 and 2 the arms are stretched along Y, positive angles turn from X to Y, seen from
  above. R is the sum of the three angles and 90 degrees. A real robot's standard coordinates may
  be taught otherwise.
- Right-handed is axis 2 positive: the elbow lies to the right of the line from the base to the
  hand. The arm status tells how the arm really stands. A position in millimetres without a hand
  system is taken with the arm designation; on lines and arcs, by jog and in relative movements the
  arm stays as it is.
- PTP: each joint turns evenly, and the tool goes on the curve that comes of it. Lines and arcs are
  lines and arcs of the tool. Arch: the arch axis as the manual says, the other joints evenly.
- The tool is at the end of the selected hand: on the R axis it turns with R; beside it the hand is
  another arm 2, data 1 its angle in pulses of axis 2, data 2 what it is longer, data 3 its depth.

| What is asked for | Alarm | Knob |
|---|---|---|"""

_ALARMS = (
    ("a target beyond a soft limit", "", "none: manual, 1.1"),
    ("a place that the arms do not reach", "out_of_reach_alarm", ""),
    ("a line or an arc with axis 2 nearer to stretched than `outer_angle` (3 degrees)",
     "outer_range_alarm", ""),
    ("a line or an arc from right-handed to left-handed", "to_left_alarm", ""),
    ("a line or an arc from left-handed to right-handed", "to_right_alarm", ""),
    ("DRIVE, DRIVEI, PUSH or an arch axis along X or Y in millimetres", "drive_xy_alarm", ""),
)  # fmt: skip

_LAW = """\
## How fast it gets there

One law for all types and axes. In words: an axis has the force of its motor's power at its highest
speed, times a factor; with that it moves the load, and itself, a share of the largest load that it
is built for:

    acceleration = {factor} * (power / speed) / ({share} * largest load + load)

Of an arm it is the acceleration of its stretched end, of R the turning one with the largest moment
of inertia in place of the largest load. Both figures were fitted to the standard cycle times of
{names}: the smallest, the middle and the largest arm of five. The other two were held out.

**The cycle**: 25 mm up, 300 mm across, 25 mm down, and back, in arch motion with the catalogue's
load. What the catalogue leaves open is ours: across the front, as far from the base as the hand is
with the arms at a right angle, R as it is, arch distances 0 (all axes start and arrive together),
100 % speed. *Planned* is the time of both movements, *measured* that of the remote commands in
virtual time, in cycles of 5 ms.

| Model | Load [kg] | Catalogue [s] | Planned [s] | Measured [s] | Difference | |
|---|---|---|---|---|---|---|"""

_CHOICES = """\

Had it been fitted to another three of the five, the two that are left would have been met so (a
factor of 12 and a share of 3 are where the search ends):

| Fitted to | Factor | Share | Largest error of the two held out |
|---|---|---|---|"""

_LIMITS = """\

So it holds between models that it knows, less beyond them: without the smallest or the largest arm
the error of the one left out grows. A movement in your cell will differ from the model's; the
order of things and their alarms are what to test with it.

## What is not there

Flexing arms, settling, and the acceleration that a real controller reduces by its own tables;
collisions; the type number that the system configuration answers (`robot_type` of the axes). Which
of these figures are public and which assumed: [fidelity.md](../explanation/fidelity.md),
`robot-figures` and the
rows after it."""


def robots_page() -> str:
    """Return the page as Markdown."""
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
    yield "- Speeds of axes 1 and 2 of a SCARA robot: the sources give one of both together, the"
    yield "  model shares it out as YK510XEC, YK610XEC and YK710XEC do: they differ in arm 1 alone."
    yield "  Where no source gives pulses, an axis has those of the YK400XE's per degree or mm.\n"
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
