"""A second, independent model of the rules on the wire in plain Python, without timers.

In `scan`, each class does the work of one scan as the manual and the head of its block demand.
Times are in milliseconds of PLC time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

SAFETY = ("SI00_EmergencyStop", "SI06_Stop")
OTHERS = (
    *("SI01_ServoOn", "SI10_SequenceControl", "SI12_AutoStart", "SI14_ReturnToOriginIncr"),
    *("SI15_ProgramReset", "SI16_AlarmReset", "SI17_ReturnToOriginAbs"),
)
#: Safety inputs that must be ON before an input is set (chapter 5, 2, SI(01), and 3.2). A
#: return-to-origin is a movement and needs both.
NEEDS = {
    "SI01_ServoOn": SAFETY[:1],
    "SI12_AutoStart": SAFETY,
    "SI14_ReturnToOriginIncr": SAFETY,
    "SI17_ReturnToOriginAbs": SAFETY,
}
_JOGS = (0x0020, 0x0021, 0x0022)
_CONTINUOUS = (0x0505, 0x0506)


@dataclass
class Since:
    """The time for which a condition has held, evaluated once per scan."""

    start: int | None = None

    def look(self, now: int, so: bool, long: int) -> bool:
        """Return whether the condition `so` has held in every scan for at least the time `long`."""
        if not so:
            self.start = None
        elif self.start is None:
            self.start = now
            return False
        return self.start is not None and now - self.start >= long


@dataclass
class Channel:
    """The tickets of a channel, as in RCX_CHANNEL: the job with ticket `serving` may use it."""

    next_ticket: int = 0
    serving: int = 0
    lowest: int = 0
    orphan: bool = False
    holder: int = 0

    @classmethod
    def of(cls, found: Mapping[str, object]) -> Channel:
        """Return the channel with the values that the fields of RCX_CHANNEL have in a program."""
        return cls(
            int(str(found["NextTicket"])),
            int(str(found["Serving"])),
            int(str(found["Lowest"])),
            found["Orphan"] is True,
            int(str(found["Holder"])),
        )

    @property
    def taken(self) -> bool:
        """Return whether a job uses the channel."""
        return self.serving != self.next_ticket

    @property
    def gone(self) -> bool:
        """Return whether the job that uses the channel was not called in this scan."""
        return self.serving != self.lowest

    def see(self, ticket: int) -> None:
        """Note that the job with this ticket was called in this scan."""
        ahead = [(one - self.serving) % 65536 for one in (ticket, self.lowest)]
        self.lowest = (self.serving + min(ahead)) % 65536

    def give_back(self) -> None:
        """Release the channel for the next ticket."""
        self.serving, self.holder = (self.serving + 1) % 65536, 0

    def pass_on(self) -> None:
        """Give the channel to the first ticket that was called in this scan, or to no job."""
        self.serving, self.holder, self.orphan = self.lowest, 0, False


@dataclass
class InputRules:
    """The rules for dedicated inputs: the caution in chapter 5, 3, and the head of the block.

    One input changes at a time: withdrawals first, then by number. Only a switch-off of SI(00) or
    SI(06) is sent at once. Without a link, or while SI(00) or SI(06) is OFF, the inputs that need
    them stay OFF. A start of the link counts as a change.
    """

    applied: dict[str, bool] = field(
        default_factory=lambda: dict.fromkeys((*SAFETY, *OTHERS), False)
    )
    settled: bool = False
    _changed_at: int = 0
    _safety_at: int = 0
    _was_up: bool = False

    def scan(
        self, now: int, wanted: Mapping[str, bool], connected: bool, interval: int, settling: int
    ) -> None:
        """Calculate one scan with these requests."""
        wanted = {name: on and connected for name, on in wanted.items()}
        settled = now - self._safety_at >= settling
        may_change = now - self._changed_at >= interval
        changes = [name for name in SAFETY if self.applied[name] and not wanted[name]]
        came_up = connected and not self._was_up
        self._was_up = connected
        if may_change and not changes and not came_up:
            withdrawn = [name for name in OTHERS if self.applied[name] and not wanted[name]]
            raised = [
                name
                for name in (*SAFETY, *OTHERS)
                if wanted[name] > self.applied[name]
                and all(self.applied[level] for level in NEEDS.get(name, ()))
            ]
            changes = [*withdrawn, *raised][:1]
        for name in changes:
            self.applied[name] = not self.applied[name]
        if came_up or changes:
            self._changed_at = now
        if came_up or set(changes) & set(SAFETY):
            self._safety_at, settled = now, False
        self.settled = settled and all(self.applied[name] == wanted[name] for name in SAFETY)


@dataclass
class HandshakeRules:
    """The remote-command handshake: guide, chapters 1 and 2, and 4.7.4 for continuous output."""

    phase: str = "PHASE_STATUS_RESET"
    running: bool = False
    _up: Since = field(default_factory=Since)
    _lost: bool = False
    _owner: int = 0
    _asked: int = 0

    def scan(
        self,
        now: int,
        *,
        there: bool,
        status: int,
        asked: bool,
        hold: bool,
        code: int,
        first: int,
        same: bool,
        channel: Channel,
        interval: int,
    ) -> None:
        """Calculate one scan.

        Args:
            now: Time of the scan.
            there: Whether the link is up while CPU_OK is ON.
            status: Status as read in this scan.
            asked: Whether the job that uses the channel requests its command.
            hold: Whether a new command must wait.
            code: Command code, with the robot number.
            first: First data word of the command.
            same: Whether the data words of the command are already on the wire.
            channel: The command channel. This call may give it to the next job.
            interval: Longest time until the controller sees a change.
        """
        seen = self._up.look(now, there and not self._lost, interval)
        self._lost = False
        gone = channel.orphan or channel.gone
        if not seen:
            self.phase = "PHASE_STATUS_RESET"
        elif self.phase == "PHASE_COMMAND_RUN":
            endless = code & 0x0FFF in _CONTINUOUS and first & 1 == 1
            if status in (0x0200, 0x4000) or (endless and status == 0x0100 and gone):
                self.phase = "PHASE_STATUS_RESET"
            elif status:
                self.running = True
            elif self.running:
                self._lost, self.phase = True, "PHASE_STATUS_RESET"
        elif status:
            self.phase = "PHASE_STATUS_RESET"
        elif hold or not asked:
            self.phase = "PHASE_READY"
        elif (
            self.phase == "PHASE_COMMAND_DATA"
            and (self._owner, self._asked) == (channel.serving, code)
            and same
        ):
            self.phase, self.running = "PHASE_COMMAND_RUN", False
        else:
            self.phase, self._owner, self._asked = "PHASE_COMMAND_DATA", channel.serving, code
        if self.phase == "PHASE_COMMAND_RUN":
            channel.orphan = gone
        elif channel.gone:
            channel.pass_on()
        channel.lowest = channel.next_ticket


@dataclass
class HeadRules:
    """The rules for all data to the robot: the words, and the dedicated inputs as bits.

    SI(06) OFF stops a jog if it should end, or if its block is no longer called (guide 4.2.6). Then
    commands wait until SI(06) is ON again, or the application keeps it OFF. While no command has
    its
    data on the wire, words 2 to 15 belong to the robot program.
    """

    handshake: HandshakeRules = field(default_factory=HandshakeRules)
    inputs: InputRules = field(default_factory=InputRules)
    words: list[int] = field(default_factory=lambda: [0] * 16)
    jog_stop: bool = False
    _jog_hold: bool = False

    def scan(
        self,
        now: int,
        *,
        connected: bool,
        cpu_ok: bool,
        status: int,
        asked: bool,
        code: int,
        data: list[int],
        general: list[int],
        stop_jog: bool,
        ok: tuple[bool, bool],
        holds: tuple[bool, bool],
        requests: Mapping[str, bool],
        channel: Channel,
        interval: int,
        margin: int,
    ) -> None:
        """Calculate one scan. `ok` and `holds` each have a value for SI(00) and one for SI(06)."""
        spacing = max(interval, 100) + margin
        may = [good and not held for good, held in zip(ok, holds, strict=True)]
        back = self.inputs.applied["SI06_Stop"] and self.inputs.settled
        self._jog_hold = (self._jog_hold or self.jog_stop) and may[1] and not back
        self.handshake.scan(
            now,
            there=connected and cpu_ok,
            status=status,
            asked=asked,
            hold=self._jog_hold,
            code=code,
            first=data[0],
            same=self.words[1:] == data,
            channel=channel,
            interval=spacing,
        )
        out = self.handshake.phase == "PHASE_COMMAND_RUN"
        self.jog_stop = out and code & 0x0FFF in _JOGS and (channel.orphan or stop_jog)
        wanted = {**requests, SAFETY[0]: may[0], SAFETY[1]: may[1] and not self.jog_stop}
        self.inputs.scan(now, wanted, connected, spacing, spacing + margin)
        if out or self.handshake.phase == "PHASE_COMMAND_DATA":
            self.words = [code if out else 0, *data]
        else:
            self.words = [0, 0, *general[1:]]

    @property
    def bits(self) -> int:
        """Return the dedicated inputs, bytes n + 32 and n + 33, as a word: bit 10 is SI(12)."""
        return bits_of(self.inputs.applied)


def bits_of(inputs: Mapping[str, bool]) -> int:
    """Return dedicated inputs as a word: bit 10 is SI(12).

    Source: manual chapter 5, 2, bit input.
    """
    return sum(on << (int(name[2]) * 8 + int(name[3])) for name, on in inputs.items())
