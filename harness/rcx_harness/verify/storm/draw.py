"""The drawing of the actions of storms from a seed, as lists that can be shortened."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from random import Random
from typing import Any

from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.storm.demands import Demands
from rcx_harness.verify.storm.moments import Moments
from rcx_harness.verify.storm.storms import Storm

__all__ = ["Drawn", "draw_storms"]

#: The weight of each kind of fault; other kinds have weight 1.
_OFTEN = {
    "link_down": 4,
    "emergency_stop": 3,
    "alarm": 3,
    "power_cycle": 2,
    "power_off": 2,
    "packets_lost": 2,
    "packets_late": 2,
    "plc_overrun": 2,
    "plc_stop": 2,
    "plc_power_off": 2,
}
#: Faults without a duration.
_AT_ONCE = ("power_cycle", "alarm", "plc_overrun")
#: Longest time between two scans [us]. After a longer time the connection would time out, so the
#: late scan would count as a STOP of the PLC.
_LATEST_SCAN_US = 90_000
_LONGEST_US = 4_000_000
#: Lengths of storms, as shares of the demanded length.
_LENGTHS = (0.1, 0.2, 0.2, 0.3, 0.3, 0.5, 1.0, 3.0)
_CALM_LENGTHS = (1.0, 1.0, 1.0, 3.0)


def draw_storms(
    demands: Demands, seed: int, controllers: int, scan_us: int, moments: Moments = ((), ())
) -> list[Storm]:
    """Return the storms of a seed. The caller runs a recovery after each storm.

    The result depends only on the arguments. `moments` are the times of changes in the first storm
    and in later storms, in a run without faults.
    """
    random = Random(f"storms {seed}")
    first, others = moments
    drawn = Drawn(demands, random, controllers, scan_us)
    if demands.start:  # a good run is executed only once
        return [drawn.storm(demands.length_us, first)]
    storms = []
    for number in range(random.choice((1, 2, 3, 5))):
        if drawn.inputs and random.random() < 0.15:
            storms.append(drawn.calm())
            continue
        # Short storms find most failures. Long storms find the failures of slow processes.
        share = random.choice(_LENGTHS) * random.uniform(0.3, 1.0)
        storms.append(drawn.storm(round(demands.length_us * share), others if number else first))
    return storms


class Drawn:
    """The drawing of storms with one source of random numbers."""

    def __init__(self, demands: Demands, random: Random, controllers: int, scan_us: int) -> None:
        self._demands, self._random = demands, random
        self._controllers, self._scan_us = controllers, scan_us
        self.inputs = [kind for kind in ("buttons", "switches", "values") if getattr(demands, kind)]
        self._length_us = 0
        self._marks: list[int] = []
        """Times at which an action begins or ends. Many failures occur close to these times."""
        self._moments: Sequence[int] = ()

    def storm(self, length_us: int, moments: Sequence[int], marks: Sequence[int] = ()) -> Storm:
        """Return a storm with some operator actions, faults and recoveries in random order.

        Many actions are close to `moments`, and to `marks`, which also occur in later storms.
        """
        random, demands = self._random, self._demands
        self._length_us = max(length_us, 2 * self._scan_us)
        self._marks = list(marks)
        self._moments = [t_us for t_us in moments if t_us < self._length_us]
        faults = random.choice((0, 1, 1, 1, 2, 2, 3)) if demands.faults else 0
        uses = random.choice((0, 0, 1, 1, 2, 4)) if self.inputs else 0
        ways = random.choice((0, 0, 0, 0, 1, 2)) if demands.recovery is not None else 0
        kinds = [self._use] * uses + [self._fault] * faults + [self._way_back] * ways
        random.shuffle(kinds)
        acts: list[Entry] = []
        for drawn in kinds:
            new = list(drawn())
            acts += new
            self._marks += [part.t_us for act in new for part in act.parts()]
        acts.sort(key=lambda act: act.t_us)
        return Storm(tuple(acts), self._length_us)

    def calm(self) -> Storm:
        """Return a long storm without faults, with random switches and values."""
        random, demands = self._random, self._demands
        length_us = round(demands.length_us * random.choice(_CALM_LENGTHS))
        states = [*demands.switches, *demands.values]
        number = min(random.choice((1, 1, 2)), len(states))
        acts = []
        for path in random.sample(states, number):
            if path in demands.values:
                acts.append(Entry(0, values={path: self._value(path)}))
            else:
                to = random.random() < 0.5
                acts.append(Entry(0, values={path: to}, held_us=length_us))
        return Storm(tuple(acts), length_us)

    def _value(self, path: str) -> Any:
        """Return a random value of a variable. The first and the last value are preferred."""
        values = self._demands.values[path]
        return self._random.choice((values[0], values[-1], self._random.choice(values)))

    def _time(self) -> int:
        """Return a random time in the storm, often close to another event."""
        random, scan_us = self._random, self._scan_us
        how = random.random()
        if how < 0.4 and self._marks:
            near_us = random.choice(self._marks)
            scans = random.choice((0, 0, 1, 1, 2, 3, 5, 10, 20, 50, 100, 200))
        elif how < 0.7 and self._moments:
            near_us, scans = random.choice(self._moments), random.choice((-1, 0, 0, 1, 2))
        else:
            t_us = random.randrange(self._length_us)
            return t_us if random.random() < 0.2 else t_us // scan_us * scan_us
        return max(0, min(near_us + scans * scan_us, self._length_us))

    def _lasting(self, longest_us: int = _LONGEST_US) -> int:
        """Return a random duration from one scan to some seconds, distributed logarithmically."""
        share = self._random.random()
        lasts_us: float = self._scan_us * (longest_us / self._scan_us) ** share
        return max(1, round(lasts_us / self._scan_us)) * self._scan_us

    def _fault(self) -> Iterator[Entry]:
        random, faults = self._random, self._demands.faults
        name = random.choices(faults, [_OFTEN.get(one, 1) for one in faults])[0]
        controller = random.randint(1, self._controllers)
        args: dict[str, Any] = {}
        if name.startswith("packets_"):
            args = {"share": random.choice((0.1, 0.3, 0.6, 1.0))}
            if name != "packets_lost":
                args["by"] = f"{random.randint(1, max(1, self._demands.late_us // 1000))}ms"
            if (way := random.choice(("both", "robot", "plc"))) != "both":
                args["to"] = way
        elif name == "plc_overrun":
            most_us = max(_LATEST_SCAN_US - self._scan_us, 1_000)
            args = {"by": f"{random.randint(1, most_us // 1000)}ms"}
        elif name == "plc_stop":
            args = {"start": random.choice(("warm", "cold", "continue"))}
        elif name == "plc_power_off":
            args = {"start": random.choice(("warm", "cold"))}
        elif name == "alarm" and random.random() < 0.5:
            group, category = random.choice(((12, 600), (2, 334), (17, 4)))
            args = {"group": group, "category": category}
        if name.startswith("plc_"):
            controller = 1
        held_us = None if name in _AT_ONCE else self._lasting()
        act = Entry(self._time(), events=((name, args),), controller=controller, held_us=held_us)
        yield act
        others = [one for one in range(1, self._controllers + 1) if one != controller]
        if others and not name.startswith("plc_") and random.random() < 0.15:
            yield replace(act, controller=random.choice(others))

    def _use(self) -> Iterator[Entry]:
        random, demands = self._random, self._demands
        kind = random.choice(self.inputs)
        t_us = self._time()
        if kind == "values":
            path = random.choice(list(demands.values))
            yield Entry(t_us, values={path: self._value(path)})
            return
        names = getattr(demands, kind)
        together = 2 if len(names) > 1 and random.random() < 0.25 else 1
        chosen = random.sample(names, together)
        to = kind == "buttons" or random.random() < 0.5
        if kind == "buttons":
            held_us = random.choice((self._scan_us, 100_000, 100_000, self._lasting()))
        else:
            held_us = self._lasting(self._length_us)
            if random.random() < 0.3:  # the value applies to the whole storm
                t_us, held_us = 0, self._length_us
        apart_us = self._scan_us * random.choice((0, 0, 1, 2, 5))
        if together == 1 or not apart_us:
            yield Entry(t_us, values=dict.fromkeys(chosen, to), held_us=held_us)
            return
        for number, name in enumerate(chosen):  # pressed one after the other, not together
            yield Entry(t_us + number * apart_us, values={name: to}, held_us=held_us)

    def _way_back(self) -> Iterator[Entry]:
        """Yield the operator's recovery at a random time."""
        recovery = self._demands.recovery
        assert recovery is not None
        t_us = self._time() + self._lasting()
        for step in recovery.steps:
            if step.values:
                yield Entry(t_us, values=dict(step.values))
            if step.press:
                yield Entry(t_us, values=dict.fromkeys(step.press, True), held_us=step.for_us)
                t_us += step.for_us
            t_us += step.wait_us
