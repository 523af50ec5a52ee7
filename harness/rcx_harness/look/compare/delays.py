"""The delays of a controller in a replay, chosen so that the answers match the recording.

If a robot file gives a delay as a range, each answer has its own delay within the range. A replay
with random delays would differ from every recording. Therefore each delay is taken from the
recording, as far as the range allows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from rcx_harness.look.compare.channels import STATUS, Channel, Timeline
from rcx_harness.robot import Controller
from rcx_harness.robot.handshake import Kind
from rcx_harness.spec import commands, signals
from rcx_harness.spec.wire import ABNORMAL_END, CYCLE_US, DEDICATED_AT, ENDS, READY, RUN, SIZE

__all__ = ["DELAYS", "INPUTS", "Drawn", "Guide", "asked"]

#: Maps a delay to the changes that end it: channels, and the values that the channels reach.
_ANSWERS: dict[str, tuple[tuple[str, tuple[int, ...]], ...]] = {
    "boot_time": (("SO01", (1,)),),
    "link_error_delay": (("SO03", (1,)),),
    "emergency_stop_delay": (("SO00", (1,)),),
    "emergency_release_delay": (("SO00", (0,)),),
    "servo_on_delay": (("SO02", (1,)), (STATUS, ENDS)),
    "alarm_reset_delay": (("SO03", (0,)),),
    "program_reset_delay": (("SO14", (1,)),),
    "program_start_delay": (("SO13", (1,)), ("SO14", (0,))),
    "program_stop_delay": (("SO13", (0,)),),
    "sequence_delay": (("SO12", (1,)),),
    "auto_mode_delay": (("SO10", (1,)),),
    "origin_time": (("SO11", (1,)), (STATUS, ENDS)),
    "command_accept_delay": ((STATUS, ()),),
    "command_delay": ((STATUS, ENDS),),
    "status_reset_delay": ((STATUS, (READY,)),),
}
DELAYS = tuple(_ANSWERS)
#: Maps a delay to the inputs that start it, each with its level. A repeated request restarts the
#: delay.
_ASKED = {
    "emergency_stop_delay": (("SI00", 0),),
    "emergency_release_delay": (("SI00", 1),),
    "servo_on_delay": (("SI01", 1),),
    "alarm_reset_delay": (("SI16", 1),),
    "program_reset_delay": (("SI15", 1),),
    "program_start_delay": (("SI12", 1),),
    "program_stop_delay": (("SI06", 0),),
    "sequence_delay": (("SI10", 1),),
    "origin_time": (("SI14", 1), ("SI17", 1)),
}
#: The dedicated inputs by their short names.
INPUTS = {one.short: Channel(one.short, one.byte, one.byte + 1, one.bit) for one in signals().input}
_OF_COMMANDS = ("command_accept_delay", "command_delay")
_CODE, _WORDS = Channel("code", 0, 2), Channel("words", 0, DEDICATED_AT)
#: If a change comes later than this [us] after a request, it is not the answer to the request.
_LONGEST_US = 60_000_000


@dataclass(frozen=True)
class Drawn:
    """One delay of a replay.

    Attributes:
        key: The key of the delay.
        seen: True if the recording shows the delay or a lower limit of the delay.
    """

    key: str
    at_us: int
    us: int
    seen: bool


def asked(inputs: Sequence[tuple[int, bytes | None]]) -> dict[str, Timeline]:
    """Return the timelines of the dedicated inputs, of `code` and of `words`, as sent by the PLC.

    Without a connection all values are 0.
    """
    size = next((len(si) for _, si in inputs if si is not None), SIZE)
    areas = [(t_us, bytes(size) if si is None else si) for t_us, si in inputs]
    return {one.name: Timeline.of(one, areas) for one in (_CODE, _WORDS, *INPUTS.values())}


def _shows_run(status: Timeline, words: Timeline) -> bool:
    """Return whether status 0x0100 was seen for a command.

    Continuous output and commands that were changed before their end do not count.
    """
    for before, at_us, now in zip(status.values, status.times[1:], status.values[1:], strict=False):
        was, there = words.at(at_us - 1) or 0, words.at(at_us) or 0
        entry = commands().get(there & 0x0FFF)
        changed = was & 0xFFFF and was != there
        if before != READY or now != RUN or changed or entry is None:
            continue
        if all(part.name != "continuous" for part in entry.request):
            return True
    return False


class Guide:
    """The source of the delays of a controller in a replay.

    A recording without status 0x0100 shows the acceptance of a command only if the command is
    refused. For other commands the recording shows only the end, so their acceptance gets the
    shortest allowed delay.

    Args:
        recorded: The values of the recording by channel.
        asked: The requests of the PLC, by dedicated input, `code` and `words`: see `asked`.
        free: Keys of delays that follow the recording even outside the range of the configuration.

    Attributes:
        drawn: All delays of the replay, in the order in which they were needed.
    """

    def __init__(
        self,
        controller: Controller,
        recorded: Mapping[str, Timeline],
        asked: Mapping[str, Timeline],
        free: frozenset[str] = frozenset(),
    ) -> None:
        self._controller, self._recorded, self._asked = controller, recorded, asked
        self._free = free
        self._machine, self._config = controller.machine, controller.config
        self.drawn: list[Drawn] = []
        self._shows_run = _shows_run(recorded[STATUS], asked["words"])
        self._longest_us = 0  # longest time from the code of a short command to its end status
        # Latest delay by key. It is used again if the recording does not show the next delay.
        self._latest: dict[str, int] = {}
        draw: Callable[[str], int] = self.draw_us
        vars(self._machine)["draw_us"] = draw

    def draw_us(self, key: str) -> int:
        """Return the next delay for a key [us]. This method replaces `Machine.draw_us`."""
        now_us = self._machine.now_us
        delay = getattr(self._config, key)
        low, high = delay if isinstance(delay, tuple) else (delay, delay)
        low_us, high_us = round(low * 1000), round(high * 1000)
        seen_us, longer = self._seen_us(key, now_us), False
        if seen_us is None:
            us: int = low_us if self._hidden(key) else self._latest.get(key, low_us)
            least_us = max(us, self._least_us(key, now_us))
            longer = least_us > us
            us = least_us if key in self._free else max(low_us, min(least_us, high_us))
        elif key in self._free:
            us = self._latest[key] = seen_us
        else:
            us = min(max(seen_us, low_us), high_us)
        self.drawn.append(Drawn(key, now_us, us, seen_us is not None or longer))
        return us

    def _least_us(self, key: str, now_us: int) -> int:
        """Return the lower limit of a delay [us]; 0 if there is none.

        Example: the PLC changed its command after 30 ms, and the controller had not accepted the
        command by then. The delay was therefore longer than 30 ms.
        """
        status = self._recorded[STATUS]
        if key == "command_accept_delay":
            changed_us = self._asked["words"].next_change(now_us + 1, None)
            shown_us = status.next_change(now_us, None)
            if changed_us is not None and (shown_us is None or shown_us > changed_us):
                return changed_us - now_us
        elif key == "command_delay":
            ready_us = status.next_change(now_us + 1, READY)
            ends = [status.next_change(now_us, end) for end in ENDS]
            if ready_us is not None and all(one is None or one > ready_us for one in ends):
                return ready_us - now_us
        return 0

    def _hidden(self, key: str) -> bool:
        """Return whether the recording cannot show this delay.

        This is the acceptance delay if the controller does not show status 0x0100.
        """
        return key == "command_accept_delay" and not self._shows_run

    def _accepted(self, at_us: int) -> bool:
        """Return whether the status at the time `at_us` shows that a command was accepted."""
        if self._shows_run:
            return True
        status, us = self._recorded[STATUS].at(at_us), at_us - self._machine.now_us
        kind = self._controller.handshake.takes(self._machine)
        if kind is Kind.SHORT:
            self._longest_us = max(self._longest_us, us)
            return False
        refused = status == ABNORMAL_END and (kind is Kind.REFUSED or us <= self._longest_us)
        return refused or (kind is Kind.LASTING and status == RUN)

    def _seen_us(self, key: str, now_us: int) -> int | None:
        """Return the length of a delay in the recording; None if it is not visible."""
        found = []
        for channel, values in _ANSWERS[key]:
            line = self._recorded[channel]
            there = line.at(now_us - 1) in values and line.at(now_us + CYCLE_US) in values
            if there if channel != STATUS else not self._asked["code"].at(now_us) and key in _ASKED:
                # the channel already has the value, or there is no command: no answer follows
                continue
            for value in values or (None,):
                at_us = line.next_change(now_us, value)
                if at_us is not None and at_us - now_us <= _LONGEST_US:
                    found.append(at_us - now_us)
        if not found:
            return None
        us = min(found)
        again = [self._asked[name].next_change(now_us + 1, to) for name, to in _ASKED.get(key, ())]
        if key in _OF_COMMANDS or (
            key != "status_reset_delay"  # a change of the code does not end this delay
            and STATUS in dict(_ANSWERS[key])
            and self._recorded[STATUS].at(now_us) == RUN
        ):
            again = [self._asked["code"].next_change(now_us + 1, None)]
        # if the ready status comes before the end status, the end belongs to another command
        if key == "command_delay":
            again.append(self._recorded[STATUS].next_change(now_us + 1, READY))
        if any(at_us is not None and at_us < now_us + us for at_us in again):
            return None
        if key == "command_accept_delay" and not self._accepted(now_us + us):
            return None
        if key == "origin_time":
            axes = self._config.axes
            on_the_way = [k for k in range(len(axes)) if self._machine.origins.moves({k})]
            # absolute and incremental axes move one after the other
            us //= max(1, len({axes[k].type == "absolute" for k in on_the_way}))
        return us
