"""The search for the robot file with which the virtual controller answers like a recorded one.

Delays are measured in the recording. The values of other keys are tried one by one, but only if the
controller has read the key before the difference. The search changes the key that gives the longest
agreement, and repeats this step until there is no difference. If no key helps, the search notes the
difference as unexplained and continues behind the difference. At the end the search tries each key
again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from rcx_harness.look.compare.channels import RESPONSE, STATUS, Difference
from rcx_harness.look.compare.delays import DELAYS, Drawn, asked
from rcx_harness.look.compare.knobs import KNOBS, Seen, has_few_values, seen_at, values
from rcx_harness.look.compare.replay import Replay, Replayed, watched
from rcx_harness.robot import RobotConfig
from rcx_harness.spec.wire import CYCLE_US, READY
from rcx_harness.watch.wire import word
from structured_text.errors import InputError

__all__ = ["Fit", "Knob", "fit"]

_FREE = frozenset(DELAYS)
#: Greatest number of unexplained differences. More of them mean that the recording is from another
#: machine.
_MOST_LEFT = 100
_NEVER = 1 << 62
#: Initial value of `auto_mode_delay` [ms]. It is too short to be visible, because a controller may
#: show the mode immediately.
_LEAST_MODE_DELAY = 0.001


@dataclass(frozen=True)
class Knob:
    """The evidence of the recording for one key.

    Attributes:
        key: The key of the robot file.
        value: The value with which recording and replay agree. For a delay that varies this is
            (shortest, longest) in ms.
        found: True if the recording decides the value. With any other value the replay would differ
            from the recording.
        why: The reason for the value, in one line.
        others: Other values with which recording and replay agree.
        instead: Other keys with values. Each of these keys has the same effect if `key` stays
            unchanged.
    """

    key: str
    value: Any
    found: bool
    why: str
    others: tuple[Any, ...] = ()
    instead: tuple[tuple[str, Any], ...] = ()


@dataclass
class Fit:
    """The result of a fit.

    Attributes:
        config: The configuration with which recording and replay agree, except for `left`.
        knobs: All keys except those that only describe the robot.
        left: Differences that no key explains.
        runs: Number of replays.
    """

    config: RobotConfig
    knobs: list[Knob] = field(default_factory=list)
    left: list[Difference] = field(default_factory=list)
    runs: int = 0


def fit(
    replay: Replay, base: RobotConfig, progress: Callable[[float], None] = lambda share: None
) -> Fit:
    """Return the robot file that reproduces a recording best.

    `base` is the configuration to begin with; its axes, programs and points do not change.
    `progress` is called with the part of the recording that the virtual controller reproduces.
    """
    return _Search(replay, base, progress).search()


class _Search:
    def __init__(
        self, replay: Replay, base: RobotConfig, progress: Callable[[float], None]
    ) -> None:
        self._replay, self._progress, self._base = replay, progress, base
        self._result = Fit(base)
        self._asked = asked(replay.recording.inputs)
        # maps a changed key to its value before the fit and to the other keys that explain the
        # difference
        self._instead: dict[str, tuple[Any, list[tuple[str, Any]]]] = {}

    def search(self) -> Fit:
        result = self._result
        if not result.config.auto_mode_delay:
            result.config = replace(result.config, auto_mode_delay=_LEAST_MODE_DELAY)
        while True:
            here = self._run(watched(result.config), to_first=True)
            if here.first_us is None or len(result.left) >= _MOST_LEFT:
                break
            begin_us, end_us = self._replay.span
            self._progress((here.first_us - begin_us) / max(1, end_us - begin_us))
            better = self._better(here)
            if better is None:
                first = here.differences[0]
                same = [one for one in here.differences if one.begin_us == first.begin_us]
                result.left += same
            else:
                result.config = better
        if len(result.left) < _MOST_LEFT:
            self._take_acceptance()
            while (narrower := self._settle()) is not None:
                result.config, result.knobs = narrower, []
        return result

    def _run(
        self, config: RobotConfig, *, free: frozenset[str] = _FREE, to_first: bool = False
    ) -> Replayed:
        self._result.runs += 1
        return self._replay.run(config, free=free, expected=self._result.left, to_first=to_first)

    def _better(self, here: Replayed) -> RobotConfig | None:
        """Return the configuration with one changed key that gives the longest agreement.

        Among equally good keys, a key with few values wins: a truth value is a simpler explanation
        than the number of an alarm.
        """
        config, seen = self._result.config, self._seen(here)
        least = _reach(here)
        tried: list[tuple[tuple[int, ...], str, Any]] = []
        for key in KNOBS:
            if key not in here.read:
                continue
            for value in self._values(key, here, seen):
                changed = self._changed(config, key, value)
                if changed is None:
                    continue
                there = self._run(changed, to_first=True)
                if _reach(there) > least:
                    score = (*_reach(there), -_spread_us(there.drawn), has_few_values(key))
                    tried.append((score, key, value))
        if not tried:
            return None
        best, key, value = max(tried, key=lambda one: one[0])
        same = [(other, to) for score, other, to in tried if score[:3] == best[:3] and other != key]
        self._instead[key] = (getattr(config, key), same)
        return self._changed(config, key, value)

    def _values(self, key: str, here: Replayed, seen: Seen) -> list[Any]:
        current = getattr(self._result.config, key)
        return values(key, current, seen, here.alarms, self._asked)

    @staticmethod
    def _changed(config: RobotConfig, key: str, value: Any) -> RobotConfig | None:
        try:
            return replace(config, **{key: value})
        except InputError:  # the configuration refuses this value of the key
            return None

    def _seen(self, here: Replayed) -> Seen:
        """Return the values that the recording suggests at the first difference."""
        recording = self._replay.recording
        first = here.differences[0] if here.differences else None
        alarms: set[str] = set()
        at_first = Seen()
        si = bytes(recording.size)
        inputs = iter([*recording.inputs, (_NEVER, None)])
        due_us, coming = next(inputs)
        clock = self._result.config.clock
        outputs = recording.outputs
        behind = [t_us for t_us, _ in outputs[1:]] + [_NEVER]
        for (t_us, so), until_us in zip(outputs, behind, strict=True):
            while due_us <= t_us:
                si = coming if coming is not None and word(coming, 0) != READY else si
                due_us, coming = next(inputs)
            alarms |= seen_at(t_us, si, so, so, clock).alarms
            if first and first.channel in (STATUS, RESPONSE) and t_us <= first.begin_us < until_us:
                at_first = seen_at(t_us, si, so, _answer(here, first, so), clock)
        if at_first.alarms:
            return at_first
        return replace(at_first, alarms=frozenset(alarms))

    def _take_acceptance(self) -> None:
        """Use the acceptance delay of refused commands for all commands, if 0x0100 is never shown.

        Execution delays are afterwards measured from the acceptance of the command.
        """
        config = self._result.config
        if config.skip_run_status != "always":
            return
        drawn = self._run(config).drawn
        seen = [one.us / 1000 for one in drawn if one.seen and one.key == "command_accept_delay"]
        if seen:
            self._result.config = replace(config, command_accept_delay=(min(seen), max(seen)))

    def _settle(self) -> RobotConfig | None:
        """Try all values of every key at the end of the search.

        Returns:
            A configuration that agrees equally well and is likelier, because delays of the same key
            differ less. None if there is no such configuration.
        """
        result = self._result
        here = self._run(watched(result.config))
        measured = {key: [one for one in here.drawn if one.key == key] for key in DELAYS}
        for key, drawn in measured.items():
            knob = _delay(key, getattr(result.config, key), drawn)
            result.knobs.append(knob)
        seen = self._seen(here)
        spread_us = _spread_us(here.drawn)
        for key in KNOBS:
            value = getattr(result.config, key)
            if key not in here.read:
                why = "nothing in this recording depends on it"
                result.knobs.append(Knob(key, value, False, why))
                continue
            equal, other = [], 0
            for one in self._values(key, here, seen):
                changed = self._changed(result.config, key, one)
                if changed is None:
                    continue
                there = self._run(changed, to_first=True)
                narrower_us = spread_us - _spread_us(there.drawn)
                if there.first_us is None and narrower_us > CYCLE_US:
                    return changed
                if there.first_us is None and narrower_us >= -CYCLE_US:
                    equal.append(one)
                else:
                    other += 1
            if not other:
                why = f"no difference between its {len(equal) + 1} values"
                result.knobs.append(Knob(key, value, False, why))
            else:
                why = f"{other} other value{'s' * (other > 1)} would show"
                instead = tuple(self._as_well(key, spread_us))
                result.knobs.append(Knob(key, value, True, why, tuple(equal), instead))
        self._take_delays()
        return None

    def _as_well(self, key: str, spread_us: int) -> Iterator[tuple[str, Any]]:
        """Yield other keys and values that explain the same difference as the changed key."""
        was, others = self._instead.get(key, (None, []))
        for other, value in others:
            changed = replace(self._result.config, **{key: was, other: value})
            there = self._run(changed, to_first=True)
            if there.first_us is None and _spread_us(there.drawn) <= spread_us + CYCLE_US:
                yield other, value

    def _take_delays(self) -> None:
        """Replace initial delays by measured delays, unless the initial delay agrees as well.

        Delays are replaced one after the other, because the recording shows only the sum of two
        consecutive delays.
        """
        result = self._result
        free = _FREE
        for place, knob in enumerate(result.knobs):
            key = knob.key
            if key not in DELAYS:
                continue
            was = getattr(self._base, key)
            if knob.found:
                drawn = [one for one in self._run(result.config, free=free).drawn if one.key == key]
                knob = result.knobs[place] = _delay(key, was, drawn)
            free -= {key}
            kept = replace(result.config, **{key: was})
            if not knob.found:
                result.config = kept
            elif isinstance(was, tuple) or self._differs(kept, free):
                seen = [one.us / 1000 for one in drawn if one.seen]
                result.config = self._narrowest(key, seen, free)
                measured = getattr(result.config, key)
                result.knobs[place] = replace(knob, value=measured)
            else:
                result.config = kept

    def _narrowest(self, key: str, measured: Sequence[float], free: frozenset[str]) -> RobotConfig:
        """Return the configuration with the measured delays of a key, without useless outliers.

        An outlier arises if an input gets no answer. A later change with another cause then looks
        like the answer.
        """
        lengths = sorted(set(measured))
        config = self._result.config
        while True:
            config = replace(config, **_from_to(key, lengths))
            lengths.pop()
            if not lengths:
                return config
            if self._differs(replace(config, **_from_to(key, lengths)), free):
                return config

    def _differs(self, config: RobotConfig, free: frozenset[str]) -> bool:
        return self._run(config, free=free, to_first=True).first_us is not None


def _from_to(key: str, lengths: Sequence[float]) -> dict[str, Any]:
    """Return the key with its delay in ms: a number for one length, a range for several lengths.

    The shortest length comes first.
    """
    return {key: lengths[0] if len(lengths) == 1 else (lengths[0], lengths[-1])}


def _reach(result: Replayed) -> tuple[int, int]:
    """Return how far a replay agrees: the time of the first difference, and its negative size.

    The larger of two pairs is the better one.
    """
    first_us = result.first_us
    if first_us is None:
        return _NEVER, 0
    return first_us, -sum(map(_words, result.differences))


def _words(one: Difference) -> int:
    """Return the number of words in which recording and virtual controller differ."""
    apart = one.recorded ^ one.virtual
    return sum(apart >> 16 * k & 0xFFFF > 0 for k in range(-(-apart.bit_length() // 16)))


def _answer(here: Replayed, first: Difference, recorded: bytes) -> bytes:
    """Return the virtual controller's area that belongs to a recorded area at the first difference.

    The virtual controller may answer a little later than the recorded controller.
    """
    area = here.outputs[0][1]
    for t_us, one in here.outputs:
        if t_us > first.begin_us and (
            t_us >= first.end_us or word(area, 0) == word(recorded, 0) != READY
        ):
            break
        area = one
    return area


def _spread_us(drawn: Sequence[Drawn]) -> int:
    """Return the sum over all keys of the difference between longest and shortest delay [us]."""
    kinds: dict[str, list[int]] = {}
    for one in drawn:
        if one.seen:
            kinds.setdefault(one.key, []).append(one.us)
    return sum(max(kind) - min(kind) for kind in kinds.values())


def _delay(key: str, current: Any, drawn: Sequence[Drawn]) -> Knob:
    seen = [one.us for one in drawn if one.seen]
    if not seen:
        text = "no answer of this kind is in this recording"
        return Knob(key, current, False, text)
    low, high = min(seen) / 1000, max(seen) / 1000
    text = f"measured {len(seen)} time{'s' * (len(seen) > 1)}"
    return Knob(key, low if low == high else (low, high), True, text)
