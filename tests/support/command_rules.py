"""A second, independent model of a block that sends a remote command at a rising edge.

One call of `scan` is one call of the block. The model follows the remote command guide, chapters 1
and 2, and the heads of the blocks, and has no timers; see head_rules for the outputs. Times are in
milliseconds of PLC time.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from head_rules import Channel

_TICKETS = 1 << 16


@dataclass
class RobotView:
    """The robot as a command block sees it, and the block's requests.

    Attributes:
        now: Time of this scan.
        last: Time of the previous scan.
        connected: Whether the link is up.
        cpu_ok: Whether SO(01) is ON.
        status: The remote status.
        alarm: The first two words of the response.
        out: Whether a code has been on the wire since the last scan.
        running: Whether the status has answered the code on the wire.
        channel: The command channel: which job may send next.
        asking: The block that requests its command in this scan.
    """

    now: int = 0
    last: int = 0
    connected: bool = True
    cpu_ok: bool = True
    status: int = 0
    alarm: tuple[int, int] = (0, 0)
    out: bool = False
    running: bool = False
    channel: Channel = field(default_factory=Channel)
    asking: CommandRule | None = None


@dataclass
class CommandRule:
    """The model of a block. The pins are attributes.

    Attributes:
        refused: ErrorID for illegal inputs; 0 if the inputs are legal.
        ended: Whether the last call ended the job.
    """

    execute: bool = False
    timeout: int = 0
    refused: int = 0
    done: bool = False
    busy: bool = False
    active: bool = False
    number: int = 0
    alarm: tuple[int, int] = (0, 0)
    ended: bool = False
    _was: bool = False
    _armed: bool = False
    _ticket: int | None = None
    _called: int = 0
    _limit: int = 0
    _since: int | None = None

    def scan(self, view: RobotView) -> None:
        """Calculate one call of the block."""
        started = self.execute and not self._was and not self.busy
        self._was, self.ended = self.execute, False
        skipped = self.busy and self._called != view.last
        self._called = view.now
        if started:
            self._ticket, self._limit = None, self.timeout
            self._armed, self.busy, self._since = False, True, None
        if started or not (self.busy or self.execute):
            self.done, self.number, self.alarm = False, 0, (0, 0)
        if self.busy:
            self._work(view, started, skipped)

    def _work(self, view: RobotView, started: bool, skipped: bool) -> None:
        channel = view.channel
        if skipped:
            self.active = False
        elif self._ticket is None and not self.refused:
            self._ticket = channel.next_ticket
            channel.next_ticket = (channel.next_ticket + 1) % _TICKETS
        if self._ticket == channel.serving and not skipped:
            if not self.active:
                self._since = view.now
            self.active = True
            self._armed = self._armed or not view.out
        if not (self.active or channel.orphan):
            self._since = None
        elif self._since is None:
            self._since = view.now
        if not started:
            number = self._ends(view, skipped)
            if number is not None:
                self._end(view, number)
                return
        if self._ticket is not None:
            channel.see(self._ticket)
        offline = not view.connected or not view.cpu_ok or self.refused
        if self.active and self._armed and not offline and not view.out:
            view.asking = self

    def _ends(self, view: RobotView, skipped: bool) -> int | None:
        """Return the ErrorID if the job ends in this scan (0 for Done), or None if it continues."""
        late = self._limit > 0 and self._since is not None
        late = late and view.now - (self._since or 0) >= self._limit
        fallen = view.status == 0 and view.running
        answer = {0x0200: 0, 0x4000: 0x8020}.get(view.status, 0x8014 if fallen else None)
        mine = self.active and self._armed and view.out
        ends = (
            (skipped, 0x8013),
            (not view.connected, 0x8001),
            (not view.cpu_ok, 0x8002),
            (self.refused != 0, self.refused),
            (mine and answer is not None, answer),
            (late and not self.active, 0x8012),
            (late, 0x8011 if view.out else 0x8015),
        )
        return next((number for over, number in ends if over), None)

    def _end(self, view: RobotView, number: int) -> None:
        channel = view.channel
        if self.active:
            answered = view.status in (0x0200, 0x4000) or (view.status == 0 and view.running)
            there = view.connected and view.cpu_ok  # otherwise the code is withdrawn in this scan
            if view.out and there and not (self._armed and answered):
                channel.orphan = True
            else:
                channel.give_back()
        self.busy = self.active = False
        self.ended, self.number, self.done = True, number, not number
        self.alarm = view.alarm if number == 0x8020 else (0, 0)
