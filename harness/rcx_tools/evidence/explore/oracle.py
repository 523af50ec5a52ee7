"""The rules that every scan of an exploration is judged by, from the manual and the design alone.

The oracle sees what a user sees: what was read, how the blocks were called, what was written, and
the blocks' outputs. It knows nothing of tickets, phases or timers inside.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from rcx_harness.spec.wire import ABNORMAL_END, ENDS, NORMAL_END, RUN
from rcx_tools.evidence.explore.model import SKIPPED, UP, Block, Choice, Model, Wire, response

__all__ = ["Oracle", "Pins"]

_CPU_OK = 0x0002
_SI00, _SI06 = 0x0001, 0x0040
_SAFETY = _SI00 | _SI06
#: Inputs that start something, and what must be ON for it: chapter 5, 2, SI(01), and 3.2.
_NEEDS = ((0x0002, _SI00), (0x9400, _SAFETY))
_CONTINUOUS = (0x0505, 0x0506)
_INTERVAL_US = 100_000

# One byte of flags.
_HELD_E, _HELD_S, _BACK_E, _BACK_S, _QUIT, _STOPPED, _UP, _RAN = (1 << bit for bit in range(8))
# Flags of a block.
_WAS, _ASKED, _MISSED, _OUT = 1, 2, 4, 8

_HEAD = 7


class Pins(NamedTuple):
    """What a block shows."""

    done: bool
    """Done, or Valid of a level block."""
    busy: bool
    error: bool
    error_id: int
    active: bool

    @property
    def shown(self) -> int:
        """How many of Done, Busy and Error are true."""
        return int(self.done) + int(self.busy) + int(self.error)


class Oracle:
    """Judges scan after scan; what it remembers is a few bytes, part of the explored state."""

    def __init__(self, model: Model, root: Any) -> None:
        self.blocks = model.blocks
        self._held = [getattr(root, block.name.upper()) for block in model.blocks]
        self._out = root.OUTPUTAREA
        self.interval = -(-_INTERVAL_US // (model.tick_ms * 1000))
        self.words: list[bytes] = [bytes(32)]
        self._index: dict[bytes, int] = {bytes(32): 0}
        self.by_code = {block.code: k for k, block in enumerate(self.blocks) if block.code}

    def initial(self) -> bytes:
        """What there is to remember before the first scan."""
        return bytes(_HEAD + 2 * len(self.blocks))

    def wire(self, memory: bytes) -> Wire:
        """What was written last."""
        words = self.words[memory[0] | memory[1] << 8]
        return Wire(words[0] | words[1] << 8, words[2] | words[3] << 8, memory[2] | memory[3] << 8)

    def pins(self) -> list[Pins]:
        """The outputs of all blocks."""
        return [
            Pins(o.VALID, o.BUSY, o.ERROR, o.ERRORID, False)
            if block.is_level
            else Pins(o.DONE, o.BUSY, o.ERROR, o.ERRORID, o.ACTIVE)
            for block, o in zip(self.blocks, self._held, strict=True)
        ]

    def first_word(self, k: int) -> int:
        """Response[1] of a command block."""
        return int(self._held[k].RESPONSE[0])

    def judge(
        self, memory: bytes, choice: Choice, before: Sequence[Pins]
    ) -> tuple[bytes, list[str]]:
        """Judge the scan that has just run.

        Args:
            memory: What was remembered after the scan before.
            choice: What the environment did.
            before: The blocks' outputs before the scan.

        Returns:
            What to remember, and the broken rules in words.
        """
        return _Scan(self, memory, choice, before).judge()

    def written(self) -> tuple[int, int]:
        """The index of the 16 words on the wire, and the dedicated inputs."""
        area = bytes(self._out[:34])
        words = area[:32]
        index = self._index.get(words)
        if index is None:
            index = self._index[words] = len(self.words)
            self.words.append(words)
        return index, area[32] | area[33] << 8


class _Scan:
    """One scan to be judged."""

    def __init__(
        self, oracle: Oracle, memory: bytes, choice: Choice, before: Sequence[Pins]
    ) -> None:
        self.oracle, self.choice, self.before = oracle, choice, before
        self.blocks = oracle.blocks
        self.now = oracle.pins()
        self.was = oracle.wire(memory)
        self.old_words = memory[0] | memory[1] << 8
        self.since = min(memory[4] + choice.ticks, oracle.interval)
        self.clear = min(memory[5] + choice.ticks, oracle.interval)
        self.flags = memory[6]
        self.own = list(memory[_HEAD:])
        self.broken: list[str] = []
        self.connected = choice.situation.connected
        self.status = choice.situation.status if self.connected else 0
        self.so = choice.situation.so if self.connected else 0
        self.cpu_ok = self.connected and bool(self.so & _CPU_OK)
        self.judged = self.connected and bool(self.flags & _UP)
        self.words, self.bits = oracle.written()
        words = oracle.words[self.words]
        self.code = words[0] | words[1] << 8

    def judge(self) -> tuple[bytes, list[str]]:
        self._starts()
        for k, block in enumerate(self.blocks):
            if self.choice.does[k] != SKIPPED:
                self._contract(k, block)
        self._turns()
        self._command()
        self._dedicated()
        self._holds()
        self._jog()
        self.flags = self.flags & ~_UP | (_UP if self.connected else 0)
        head = (
            self.words & 255, self.words >> 8, self.bits & 255, self.bits >> 8,
            self.since, self.clear, self.flags,
        )  # fmt: skip
        return bytes((*head, *self.own)), self.broken

    def say(self, rule: str, text: str) -> None:
        self.broken.append(f"{rule}: {text}")

    def _starts(self) -> None:
        """Which blocks were asked to work: by an edge after the last loss of the link."""
        self.edges = [
            do == UP and not self.own[2 * k] & _WAS for k, do in enumerate(self.choice.does)
        ]
        for k, block in enumerate(self.blocks):
            flags, do = self.own[2 * k], self.choice.does[k]
            lost = not self.connected or (block.code and not self.cpu_ok)
            if lost and do != SKIPPED:
                flags &= ~_ASKED
            if do == SKIPPED:
                if self.before[k].busy:
                    flags |= _MISSED
            else:
                if self.edges[k] and (block.is_level or not self.before[k].busy):
                    flags = (flags | _ASKED) & ~(_MISSED | _OUT)
                elif do != UP and block.kind == "level":
                    flags &= ~_ASKED
                flags = flags & ~_WAS | (_WAS if do == UP else 0)
            self.own[2 * k] = flags

    def _contract(self, k: int, block: Block) -> None:
        """PLCopen: design section 3."""
        was, now, up = self.before[k], self.now[k], self.choice.does[k] == UP
        if bool(now.error) != (now.error_id != 0):
            self.say("contract", f"{block.name}: Error without ErrorID, or the reverse")
        if now.shown > 1 or (now.active and not now.busy):
            self.say("contract", f"{block.name}: {now}")
        if block.is_level:
            if bool(now.shown) != up:
                self.say("contract", f"{block.name}: {now} with Enable {up}")
            return
        if was.busy:
            if not now.shown:
                self.say("contract", f"{block.name}: Busy fell without an end")
            elif not now.busy:
                self._ended(k, block)
        elif now.busy:
            if not self.started(k):
                self.say("contract", f"{block.name}: Busy without a rising edge of Execute")
        elif self.started(k):
            self.say("contract", f"{block.name}: no Busy in the call of the rising edge")
        elif now[:4] != ((False, False, False, 0) if not up else was[:4]):
            self.say("contract", f"{block.name}: {was} became {now} with Execute {up}")
        if now.busy and was.busy and self._must_end(k, block):
            self.say("answer", f"{block.name} does not end with the status 0x{self.status:04X}")

    def started(self, k: int) -> bool:
        """Was the block asked to work in this scan?"""
        return self.edges[k] and not self.before[k].busy

    def _must_end(self, k: int, block: Block) -> bool:
        """The response is taken in the scan in which the end status is seen (design 2)."""
        return (
            block.kind == "command"
            and self._is_out(k)
            and self.status in ENDS
            and not self.own[2 * k] & _MISSED
        )

    def _is_out(self, k: int) -> bool:
        """Was the command of this very start on the wire? Another start's may still be."""
        out = self.was.code == self.blocks[k].code and bool(self.own[2 * k] & _OUT)
        return out and self.judged

    def _ended(self, k: int, block: Block) -> None:
        """What an end must rest on."""
        now = self.now[k]
        missed = self.own[2 * k] & _MISSED
        if now.error_id == 0x8001 and self.connected:
            self.say("answer", f"{block.name}: 16#8001 with a connection")
        if now.error_id == 0x8013 and not missed:
            self.say("turn", f"{block.name} has lost its turn, though it was called in each scan")
        if not now.error and not self.connected and block.kind not in ("emergency", "stop", "job"):
            self.say("answer", f"{block.name}: Done without a connection")
        if block.kind == "command":
            out = self._is_out(k)
            ends = {0x0000: NORMAL_END, 0x8020: ABNORMAL_END}.get(now.error_id)
            if ends is not None and not (out and self.status == ends):
                text = f"end {now.error_id:04X}, status {self.status:04X}"
                self.say("answer", f"{block.name}: {text}")
            if ends is not None and self.oracle.first_word(k) != response(ends):
                self.say("answer", f"{block.name}: not the response of the end status")
        elif block.answer[0] and not now.error:
            mask, value = block.answer
            if self.so & mask != value:
                self.say("answer", f"{block.name}: Done, dedicated outputs {self.so:04X}")
            if block.bits and not self.was.bits & 1 << block.bits[-1]:
                self.say("answer", f"{block.name}: Done, but its input was not on the wire")

    def _turns(self) -> None:
        """First come, first served; one holder at a time (design 2)."""
        for channel in ("command", "sequence"):
            ours = [
                k
                for k, block in enumerate(self.blocks)
                if block.channel == channel and not block.is_level
            ]
            if not ours:
                continue
            called = [k for k in ours if self.choice.does[k] != SKIPPED]
            if sum(self.now[k].active for k in called) > 1:
                self.say("turn", f"two blocks are Active on the {channel} channel")
            ranks = {k: self.own[2 * k + 1] for k in ours}
            for k in called:
                if self.now[k].active and not self.before[k].active:
                    for other in called:
                        ahead = 0 < ranks[other] < ranks[k]
                        if ahead and self.now[other].busy and not self.now[other].active:
                            one, two = self.blocks[k].name, self.blocks[other].name
                            self.say("turn", f"{one} was served before {two}")
            for k in ours:
                if not self.now[k].busy or self.own[2 * k] & _MISSED:
                    ranks[k] = 0
                elif k in called and self.started(k):
                    ranks[k] = max(ranks.values()) + 1
            order = sorted((rank, k) for k, rank in ranks.items() if rank)
            for k in ours:
                self.own[2 * k + 1] = 0
            for place, (_, k) in enumerate(order, start=1):
                self.own[2 * k + 1] = place

    def _command(self) -> None:
        """The handshake: guide, chapters 1 and 2."""
        was, code = self.was.code, self.code
        if code and not self.cpu_ok:
            self.say("link", f"the code {code:04X} is out without link or CPU_OK")
        if was and self.judged:
            lost = not self.cpu_ok or (self.flags & _RAN and self.status == 0)
            endless = was & 0x0FFF in _CONTINUOUS and self.was.first & 1 and self.status == RUN
            ended = self.status in ENDS
            may = ended or lost or (endless and code == 0)
            if (code != was or self.words != self.old_words) and not may:
                text = f"code {was:04X} to {code:04X}, or data, status {self.status:04X}"
                self.say("held", text)
            if ended and code:
                self.say("reset", f"the code {code:04X} stays after the status {self.status:04X}")
            if code not in (was, 0):
                self.say("reset", f"code {was:04X} to {code:04X} without 0x0000 between them")
        if (self.connected and not self.flags & _UP) or not self.cpu_ok:
            self.clear = 0
        if code and not was:
            self._goes_out(code)
        self.flags &= ~_RAN if code != was or not code else 255
        if code and was and self.status:
            self.flags |= _RAN

    def _goes_out(self, code: int) -> None:
        if self.oracle.words[self.words][2:] != self.oracle.words[self.old_words][2:]:
            self.say("data first", f"data and the code {code:04X} went out together")
        if not self.judged:
            self.say("data first", f"the data of {code:04X} were not there with a connection")
        if self.status:
            self.say("ready", f"the code {code:04X} went out with the status {self.status:04X}")
        if self.clear < self.oracle.interval:
            self.say("recovered", f"the code {code:04X} went out too soon after the recovery")
        k = self.oracle.by_code.get(code)
        if k is None or not self.own[2 * k] & _ASKED:
            self.say("unasked", f"the code {code:04X} went out, but nobody asked for it")
            return
        self.own[2 * k] = self.own[2 * k] & ~_ASKED | _OUT
        if self.blocks[k].kind == "jog" and not self.was.bits & _SI06:
            self.say("jog", "a jog went out while SI(06) was OFF")
        if self.flags & _STOPPED:
            self.say("jog", f"the code {code:04X} went out before SI(06) was back")

    def _dedicated(self) -> None:
        """At least 100 ms between changes, one at a time: chapter 5, 3; design 2."""
        was, bits = self.was.bits, self.bits
        changed = was ^ bits
        if bits & _SAFETY and not self.connected:
            self.say("safety", "SI(00) or SI(06) is ON without a link")
        if bits & _SI00 and not self.choice.emergency_ok:
            self.say("safety", "SI(00) is ON while EmergencyStopOk is FALSE")
        if bits & _SI06 and not self.choice.stop_ok:
            self.say("safety", "SI(06) is ON while StopOk is FALSE")
        if self.connected and not self.flags & _UP:
            self.since = 0
        paced = changed & ~(was & _SAFETY)
        if paced and self.connected:
            if changed & (changed - 1):
                self.say("interval", f"inputs {was:04X} to {bits:04X} in one scan")
            elif self.since < self.oracle.interval:
                self.say("interval", f"inputs {was:04X} to {bits:04X} too soon")
        if changed:
            self.since = 0
        rises = bits & ~was & ~_SAFETY
        for starts, levels in _NEEDS:
            if rises & starts and bits & levels != levels:
                self.say("start", f"inputs {rises:04X} went ON with {bits & _SAFETY:04X}")
        bit = 0
        while rises >> bit:
            if rises >> bit & 1 and not any(
                bit in block.bits and self.own[2 * k] & _ASKED and self._works(k)
                for k, block in enumerate(self.blocks)
            ):
                self.say("unasked", f"SI bit {bit} went ON, but nobody asked for it")
            bit += 1

    def _works(self, k: int) -> bool:
        return bool(self.now[k].busy or self.before[k].busy)

    def _holds(self) -> None:
        """FB_EmergencyStop and FB_ProgramStop hold their input OFF until they are released."""
        for k, block in enumerate(self.blocks):
            does, called = self.choice.does[k], self.choice.does[k] != SKIPPED
            which = block.kind.removeprefix("release ")
            held, back = {"emergency": (_HELD_E, _BACK_E), "stop": (_HELD_S, _BACK_S)}.get(
                which, (0, 0)
            )
            if not held or not called:
                continue
            if which == block.kind:
                if does == UP or self._works(k):
                    self.flags = self.flags & ~back | held
            elif self.started(k):
                keeps = any(
                    one.kind == which and (self.own[2 * j] & _WAS or self._works(j))
                    for j, one in enumerate(self.blocks)
                )
                if self.flags & held and not keeps:
                    self.flags = self.flags & ~held | back
            elif self.before[k].busy and self.now[k].error and self.flags & back:
                self.flags = self.flags & ~back | held
        for held, back, bit in ((_HELD_E, _BACK_E, _SI00), (_HELD_S, _BACK_S, _SI06)):
            if self.flags & held and self.bits & bit:
                self.say("hold", f"SI bit {bit:04X} is ON, though a block holds it OFF")
            if self.bits & bit:
                self.flags &= ~back

    def _jog(self) -> None:
        """A jog without its Enable has SI(06) OFF (guide 4.2.6); no code before it is ON."""
        k = self.oracle.by_code.get(self.code, -1)
        if k >= 0 and self.blocks[k].kind == "jog":
            if self.choice.does[k] != UP:
                self.flags |= _QUIT
            if self.flags & _QUIT:
                self.flags |= _STOPPED
                if self.bits & _SI06:
                    self.say("jog", "a jog is out without its Enable, and SI(06) is ON")
        else:
            self.flags &= ~_QUIT
        if (
            self.flags & _STOPPED
            and not self.flags & _QUIT
            and (self.bits & _SI06 or not self.choice.stop_ok or not self.connected)
        ):
            self.flags &= ~_STOPPED
