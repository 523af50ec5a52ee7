"""One served controller, cycle by cycle: inputs from the network, outputs to it, reports."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.cyclic.shared import Image, LinkState, drops_text
from rcx_harness.robot import EVENTS, Controller
from rcx_harness.robot.area import input_words
from rcx_harness.robot.listing import Tasks, listings, task_places
from rcx_harness.robot.positions import where
from rcx_harness.robot.shape import poses, shapes
from rcx_harness.serve.network_news import NetworkJournals, NetworkNews
from rcx_harness.serve.news import News
from rcx_harness.serve.recorder import Recorder
from rcx_harness.serve.status import Change, CommandNote, Connection, Note, Status
from rcx_harness.spec.plain import alarm_text, request_text, response_text
from rcx_harness.spec.wire import DEDICATED_AT, ENDS
from rcx_harness.trace import Cycle, Trace
from structured_text.errors import InputError

__all__ = ["LINK_EVENTS", "Images", "Station"]

#: Events of the network, in addition to those of the controller.
LINK_EVENTS = {
    "link_down": "pull the network cable",
    "link_up": "plug in the network cable",
}

# the parameters of Controller.inject that are not arguments of events
_NO_ARGUMENTS = {"self", "event"}
_KEPT = 20
_MOST_CHANGES = 2000
#: The path is sampled every 4 cycles (20 ms). A report has at most the samples of a second.
_WAY_CYCLES, _MOST_WAY = 4, 50
_SKIPS_MATTER_US = 200_000
_NO_INPUTS = bytes(4)
_DEDICATED = slice(DEDICATED_AT, DEDICATED_AT + 2)


class Images(NetworkJournals, Protocol):
    """The members of `rcx_harness.enip.cyclic.shared.SharedImages` that the station uses."""

    link: LinkState

    @property
    def to_master(self) -> Image:
        """Return assembly 100, the area that the controller sends to the master."""

    @property
    def to_robot(self) -> Image:
        """Return assembly 150, the area that the master sends to the controller."""


class Station:
    """A controller on its network; the caller gives the time.

    Args:
        images: The areas that are exchanged with the network.
        trace: Trace for each broken rule, and for each cycle in which areas or tasks have changed.

    Attributes:
        begin_us: Time 0 of the controller on the clock of the adapter's processes [us].
    """

    def __init__(
        self,
        controller: Controller,
        images: Images,
        trace: Trace | None = None,
        host: str = "",
    ) -> None:
        self.controller = controller
        self._host = host
        self._recorder: Recorder | None = None
        self._recorded = 0
        self._drawn = -1  # number of executed commands at the last report of the shapes
        self._listings = tuple(listings(controller))
        self._listed = False  # whether the listings have been sent in a report
        self._traced_tasks = Tasks(controller)
        self._images = images
        self._trace = trace
        self._cut = False
        self.now_us = self.begin_us = 0
        self._news = News()
        self._place: tuple[bool, bool, bool] | None = None  # last reported: powered, online, cut
        self._leds = ""
        self._active: tuple[str, ...] = ()
        self._skipped_told = 0
        self._network = NetworkNews(images, self._news)
        self._generation: int | None = None  # number of the owner in the last cycle
        self._last_run: bytes | None = None
        self._si: bytes | None = None
        self._so = bytes(controller.config.size)
        self._seen: tuple[bytes | None, bytes] = (None, b"")
        self._cycles = self._skipped = 0
        self._skipped_us = -_SKIPS_MATTER_US
        self._status_word = 0
        self._request: tuple[int, ...] = (0,) * 16
        self._commands: deque[CommandNote] = deque(maxlen=_KEPT)
        self._violations: deque[Note] = deque(maxlen=_KEPT)
        self._violation_count = 0
        self._changes: deque[Change] = deque(maxlen=_MOST_CHANGES)
        self._way: deque[tuple[int, ...]] = deque(maxlen=_MOST_WAY)
        self._last_place: tuple[int, ...] = ()

    def step(self, now_us: int, *, skipped: int = 0) -> None:
        """Run one controller cycle.

        `skipped` is the number of cycles that were skipped right before it.
        """
        if skipped:
            self._skipped += skipped
            self._skipped_us = now_us
        self.now_us = now_us
        self._cycles += 1
        self._si = self._take_inputs()
        self._so = self.controller.cycle(now_us, self._si)
        self._images.to_master.write(self._so)
        self._switch_link()
        self._network.look(now_us, self.begin_us)
        self._note_state()
        if self._cycles % _WAY_CYCLES == 0:
            self._note_way()
        self._watch()

    def _pulses(self) -> tuple[int, ...]:
        return tuple(int(value) for value in where(self.controller, "pulses"))

    def _note_way(self) -> None:
        """Sample the position, if an axis has moved."""
        place = self._pulses()
        if place != self._last_place:
            self._last_place = place
            self._way.append((self.now_us, *place))

    def happen(self, event: str, args: Mapping[str, int] | None = None) -> None:
        """Trigger one of EVENTS or LINK_EVENTS before the next cycle."""
        given = args or {}
        if event in LINK_EVENTS:
            if given:
                raise InputError(f"event {event!r} takes no arguments")
            self._cut = event == "link_down"
        elif event not in EVENTS:
            known = ", ".join([*EVENTS, *LINK_EVENTS])
            raise InputError(f"unknown event {event!r}", hint=f"use {known}")
        elif names := _NO_ARGUMENTS & given.keys():
            raise InputError(f"event {event!r} does not take {names.pop()}")
        else:
            self.controller.inject(event, **given)

    def obey(self, message: Mapping[str, Any]) -> None:
        """Execute a message of the page before the next cycle.

        `event` and `args` are the arguments of `happen`. `output` is the name of an output, and
        `do` is `hold`, `force` (to `value`) or `release`. `workpiece` is the number of an axis,
        from 1, with its `pulses` or None. `record` is a file for a recording, or None to end it.
        """
        if "output" in message:
            name, controller = message["output"], self.controller
            if message["do"] == "force":
                controller.force(name, message["value"])
            else:
                {"hold": controller.hold, "release": controller.release}[message["do"]](name)
        elif "workpiece" in message:
            self.controller.place_workpiece(message["workpiece"], message["pulses"])
        elif "record" in message:
            self._record(message["record"])
        else:
            self.happen(str(message.get("event")), message.get("args"))

    def _record(self, file: str | None) -> None:
        """End the current recording, and start a new one if a file is given."""
        if self._recorder is not None:
            self._note_recorded(last=True)
            self._recorder.close()
            self._recorder = None
        if file is not None:
            self._recorder = Recorder(self.controller, self._host, Path(file), self.now_us)
            self._note_recorded()

    def _note_recorded(self, *, last: bool = False) -> None:
        if self._recorder is not None:
            cycle = (self.now_us, max(0, self._cycles - 1), self._si or b"", self._so)
            self._recorder.note(*cycle, last=last)
            self._recorded = self._recorder.cycles

    def finish(self) -> None:
        """End trace and recording, if there are any, with the last cycle."""
        self._record(None)
        if self._trace is not None:
            self._note_cycle()
            self._trace.close()

    def report(self) -> Status:
        """Return the current state, with the changes since the last report."""
        machine = self.controller.machine
        network = self._images.status()
        self._note_skipped()
        self._network.note_drops(network, self.now_us)
        changes = tuple(self._changes)
        self._changes.clear()
        way = tuple(self._way)
        self._way.clear()
        return Status(
            t_us=self.now_us,
            cycles=self._cycles,
            skipped=self._skipped,
            connection=Connection(
                state=network.owner.name.lower().replace("_", " "),
                peer=network.peer,
                to_robot_us=network.o_to_t_api_us,
                to_master_us=network.t_to_o_api_us,
                received=network.received,
                sent=network.sent,
                others=network.input_only + network.listen_only,
                dropped=drops_text(network),
                untaken=self._network.untaken(network),
                refused=self._network.refused,
            ),
            si="" if self._si is None else self._si.hex(),
            so=self._so.hex(),
            module_led=self.controller.module_led.value,
            network_led=self.controller.network_led.value,
            powered=machine.powered,
            online=self.controller.online,
            link_cut=self._cut,
            emergency_stop=machine.hard_wired_stop,
            pendant=machine.pendant_authority,
            auto_switch=machine.auto_input and not machine.manual_lock,
            warning=self.controller.alarms.warning,
            main_power=machine.main_power,
            safety=machine.inputs_disabled,
            parallel_stop=machine.parallel_stop,
            held=tuple(self.controller.held),
            workpieces=tuple((k + 1, at) for k, at in sorted(self.controller.workpieces.items())),
            recording=self._recorder is not None,
            recorded=self._recorded,
            positions=self._pulses(),
            mm=where(self.controller, "mm"),
            way=way,
            poses=tuple(poses(self.controller)),
            shapes=self._shapes(),
            tasks=self._tasks(),
            listings=self._new_listings(),
            alarms=tuple(alarm_text(one.number) for one in self.controller.alarms.active),
            executed=self.controller.commands_executed,
            commands=tuple(self._commands),
            violation_count=self._violation_count,
            violations=tuple(self._violations),
            changes=changes,
            stalled=self._network.stalled(self.begin_us + self.now_us),
            events=self._news.take(self.now_us),
        )

    def _shapes(self) -> tuple[dict[str, Any], ...]:
        """Return the robots' geometry if a command was executed since the last report; else ()."""
        if self._drawn == self.controller.commands_executed:
            return ()
        self._drawn = self.controller.commands_executed
        return tuple(shapes(self.controller))

    def _tasks(self) -> tuple[dict[str, Any], ...]:
        """Return the line and state of each task.

        The result is empty if no robot program exists as source text.
        """
        return task_places(self.controller) if self._listings else ()

    def _new_listings(self) -> tuple[dict[str, Any], ...]:
        """Return the robot programs in the first report; else ()."""
        listed, self._listed = self._listed, True
        return () if listed else self._listings

    def _take_inputs(self) -> bytes | None:
        """Return the inputs from the owner of the connection; None if there is no connection.

        If the owner's connection is new, the controller must see one cycle without a connection,
        even if the loss and the new connection lie between two cycles. If the owner is idle, the
        option `idle_header` decides: `loss` treats it as a lost connection; otherwise the last
        inputs of RUN stay, or zeros if there were none.
        """
        network = self._images.status()
        generation, self._generation = self._generation, network.generation
        there = network.owner in (OwnerState.RUN, OwnerState.IDLE)
        # The generation counts the changes of the owner. If it has grown by 1, run and idle have
        # changed. If it has grown by more, the connection was lost and a new one opened between two
        # cycles.
        replaced = self._last_run is not None and network.generation - (generation or 0) > 1
        if not self.controller.online or not there or replaced:
            self._last_run = None
            return None
        if network.owner is OwnerState.RUN:
            self._last_run = self._images.to_robot.read()
            return self._last_run
        if self.controller.config.idle_header == "loss":
            self._last_run = None
        elif self._last_run is None:
            self._last_run = bytes(self.controller.config.size)
        return self._last_run

    def _switch_link(self) -> None:
        """Write the state of power and cable for the adapter's processes, if it has changed."""
        if not self.controller.online:
            link = LinkState.OFF
        else:
            link = LinkState.CUT if self._cut else LinkState.UP
        if self._images.link is not link:
            self._images.link = link

    def _note_state(self) -> None:
        """Report power, cable, LEDs and alarms that have changed."""
        controller = self.controller
        place = (controller.machine.powered, controller.online, self._cut)
        if place != self._place:
            before, self._place = self._place, place
            self._news.note(self.now_us, "connection", _place_text(before, place))
        leds = f"Module Status {controller.module_led.value}, "
        leds += f"Network Status {controller.network_led.value}"
        if leds != self._leds:
            self._leds = leds
            self._news.note(self.now_us, "leds", leds)
        active = tuple(one.number for one in controller.alarms.active)
        if active != self._active:
            before_active, self._active = self._active, active
            for number in active:
                if number not in before_active:
                    self._news.note(self.now_us, "alarms", f"alarm {alarm_text(number)}")
            for number in before_active:
                if number not in active:
                    text = f"no longer: alarm {alarm_text(number)}"
                    self._news.note(self.now_us, "alarms", text)

    def _note_skipped(self) -> None:
        """Report the number of skipped cycles."""
        if skipped := self._skipped - self._skipped_told:
            self._skipped_told = self._skipped
            cycles = "1 cycle" if skipped == 1 else f"{skipped} cycles"
            text = f"{cycles} of 5 ms skipped: this computer was busy"
            self._news.note(self.now_us, "skipped", text)

    def _watch(self) -> None:
        self._note_recorded()
        if self._recorder is not None and self._recorder.is_full:
            self._record(None)
        seen = (self._si, self._so)
        tasks = self._traced_tasks.changed()
        if seen != self._seen or tasks is not None:
            self._note_cycle(tasks)
        if seen != self._seen:
            before, self._seen = self._seen, seen
            self._follow_command()
            self._note_change(before)
        for violation in self.controller.drain_violations():
            self._violation_count += 1
            text = violation.text
            if violation.t_us - self._skipped_us < _SKIPS_MATTER_US:
                text += " (this computer was late just before; that may be the cause)"
            self._violations.append(Note(violation.t_us, text))
            self._news.note(violation.t_us, "violations", f"rule broken: {text}")
            text = f"robot, cycle {self._cycles - 1}: {violation.rule}: {text}"
            if self._trace is not None:
                self._trace.add(replace(violation, text=text))
            if self._recorder is not None:
                self._recorder.broken(replace(violation, text=text))

    def _note_cycle(self, tasks: tuple[dict[str, Any], ...] | None = None) -> None:
        if self._trace is not None:
            areas = (self._si or b"", self._so)
            self._trace.add(Cycle(self.now_us, self._cycles - 1, *areas, tasks=tasks))
            self._trace.flush()

    def _note_change(self, before: tuple[bytes | None, bytes]) -> None:
        old, new = (self._shown(*pair) for pair in (before, self._seen))
        if old != new or not before[1]:
            self._changes.append(Change(self.now_us, *new))

    @staticmethod
    def _shown(si: bytes | None, so: bytes) -> tuple[bool, str, str]:
        """Return the content of the chart: connection, word 0 and dedicated bytes of both areas."""
        inputs = _NO_INPUTS if si is None else si[:2] + si[_DEDICATED]
        return si is not None, inputs.hex(), (so[:2] + so[_DEDICATED]).hex()

    def _follow_command(self) -> None:
        """Report a remote command when its first status appears, and its result at its end."""
        before, self._status_word = self._status_word, int.from_bytes(self._so[:2], "little")
        status = self._status_word
        if status == before:
            return
        if status and not before and self._si is not None:
            self._request = input_words(self._si)
            self._commands.append(CommandNote(self.now_us, request_text(self._request)))
        if not self._commands or self._commands[-1].result:
            return
        latest = self._commands[-1]
        if status in ENDS:
            result = response_text(self._request[0], input_words(self._so))
        elif not status:
            result = "dropped by the master, or lost with the connection"
        else:
            return
        self._commands[-1] = CommandNote(latest.t_us, latest.request, result)
        self._news.note(self.now_us, "commands", f"command: {latest.request}: {result}")


def _place_text(before: tuple[bool, bool, bool] | None, place: tuple[bool, bool, bool]) -> str:
    """Return the state of power, network and cable in words."""
    powered, online, cut = place
    if not powered:
        return "the controller is off"
    if not online:
        return "the controller starts, or has no IP address of its own"
    if cut:
        return "the network cable is unplugged"
    if before is not None and before[2] and before[:2] == place[:2]:
        return "the network cable is plugged in again"
    return "no master has connected yet"
