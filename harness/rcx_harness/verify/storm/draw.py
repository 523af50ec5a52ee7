"""What befalls a cell in a storm: drawn from a seed in advance, as a list that can be cut."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from random import Random
from typing import Any

from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.storm.demands import Demands
from rcx_harness.verify.storm.storms import Storm

__all__ = ["draw_storms"]

#: How often each kind of fault is drawn, beside the others.
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
#: Faults that do not last.
_AT_ONCE = ("power_cycle", "alarm", "plc_overrun")
#: A connection is lost after its time-out: a scan that comes later is taken for a STOP.
_LATEST_SCAN_US = 90_000
_LONGEST_US = 4_000_000
#: How long storms are, in parts of the demanded length.
_LENGTHS = (0.1, 0.2, 0.2, 0.3, 0.3, 0.5, 1.0, 3.0)


def draw_storms(demands: Demands, seed: int, controllers: int, scan_us: int) -> list[Storm]:
    """The storms of a seed, each followed by the way back.

    Args:
        demands: What the operator can do, what can go wrong.
        seed: Decides everything.
        controllers: How many the cell has.
        scan_us: Period of the PLC: times are multiples of it, mostly.
    """
    random = Random(f"storms {seed}")
    if demands.start:  # a good run is gone through once
        return [_Drawn(demands, random, controllers, scan_us, demands.length_us).storm()]
    return [
        _Drawn(demands, random, controllers, scan_us, _length(demands, random)).storm()
        for _ in range(random.choice((1, 2, 3, 5)))
    ]


def _length(demands: Demands, random: Random) -> int:
    """Short storms show most; what takes its time comes in a long one."""
    return round(demands.length_us * random.choice(_LENGTHS) * random.uniform(0.3, 1.0))


class _Drawn:
    def __init__(
        self, demands: Demands, random: Random, controllers: int, scan_us: int, length_us: int
    ) -> None:
        self._demands, self._random = demands, random
        self._controllers, self._scan_us = controllers, scan_us
        self._length_us = max(length_us, 2 * scan_us)
        self._marks: list[int] = []
        """When something began or ended: much goes wrong close to it."""

    def storm(self) -> Storm:
        random, demands = self._random, self._demands
        inputs = bool(demands.buttons or demands.switches or demands.values)
        faults = random.choice((0, 1, 1, 1, 2, 2, 3)) if demands.faults else 0
        uses = random.choice((0, 0, 1, 1, 2, 4)) if inputs else 0
        acts: list[Entry] = []
        for drawn in [self._use] * uses + [self._fault] * faults:
            for act in drawn():
                acts.append(act)
                self._marks += [part.t_us for part in act.parts()]
        if demands.recovery is not None:
            for _ in range(random.choice((0, 0, 0, 0, 1, 2))):
                acts += self._way_back()
        acts.sort(key=lambda act: act.t_us)
        return Storm(tuple(acts), self._length_us)

    def _time(self) -> int:
        """Somewhere in the storm, or close to something else."""
        random = self._random
        if self._marks and random.random() < 0.4:
            near_us = random.choice(self._marks)
            scans = random.choice((0, 0, 1, 1, 2, 3, 5, 10, 20, 50, 100, 200))
            return min(near_us + scans * self._scan_us, self._length_us)
        t_us = random.randrange(self._length_us)
        return t_us if random.random() < 0.2 else t_us // self._scan_us * self._scan_us

    def _lasting(self, longest_us: int = _LONGEST_US) -> int:
        """A scan to some seconds, short and long ones alike."""
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
        kinds = [one for one in ("buttons", "switches", "values") if getattr(demands, one)]
        kind = random.choice(kinds)
        t_us = self._time()
        if kind == "values":
            path = random.choice(list(demands.values))
            yield Entry(t_us, values={path: random.choice(demands.values[path])})
            return
        names = getattr(demands, kind)
        together = 2 if len(names) > 1 and random.random() < 0.15 else 1
        chosen = random.sample(names, together)
        if kind == "buttons":
            held_us = random.choice((self._scan_us, 100_000, 100_000, self._lasting()))
            yield Entry(t_us, values=dict.fromkeys(chosen, True), held_us=held_us)
            return
        to = random.random() < 0.5
        held_us = self._lasting(self._length_us)
        if random.random() < 0.3:  # as it is for all of the time
            t_us, held_us = 0, self._length_us
        yield Entry(t_us, values=dict.fromkeys(chosen, to), held_us=held_us)

    def _way_back(self) -> Iterator[Entry]:
        """The operator goes the way back, some time after something has ended."""
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
