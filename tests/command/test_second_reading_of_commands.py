"""Command blocks with random inputs agree with an independent implementation of their rules.

This implementation, the "second reading", is in tests/support. FB_RemoteCommand runs in the same
program. The test simulates a controller that answers at random and is sometimes not connected. The
outputs of both blocks and the sent words are compared in each scan.
"""

from __future__ import annotations

from itertools import islice
from random import Random
from typing import Any

import pytest

from block_pins import Reading
from command_bench import BLOCKS, CommandBench, bench_of
from command_rules import CommandRule, RobotView
from head_rules import HandshakeRules, Since
from shown import differences
from tiers import sampled

_SCAN_MS, _SPACING_MS = 40, 120
_SCANS = 300
_SHOWN = ("Done", "Busy", "Active", "Error", "ErrorID", "AlarmGroup", "AlarmCategory")
_LIMITS_MS = (0, 80, 200, 480)
#: Code and first data word of the other block's commands. The second command is a continuous
#: output, which does not end by itself. The last code is illegal.
_TELEGRAMS = ((0x0501, 0x0000), (0x1506, 0x0001), (0x1505, 0x0000), (0x0000, 0x0000))
#: For each status, the statuses that may follow while a code is sent. A repeated entry is more
#: likely.
_FOLLOWS = {
    0x0000: (0x0000, 0x0000, 0x0100, 0x0100, 0x0200, 0x4000),
    0x0100: (0x0100, 0x0100, 0x0100, 0x0200, 0x4000, 0x0000),
    0x0200: (0x0200,),
    0x4000: (0x4000,),
}


class _Beside:
    """The bench with two blocks, and the second reading of the rules for each of them."""

    def __init__(self, bench: CommandBench, name: str) -> None:
        self.chance = Random(name)
        self.bench, self.reading = bench, Reading(BLOCKS[name])
        self.path = {"block": bench.instance, "rival": "Rival"}
        self.rules = {"block": CommandRule(), "rival": CommandRule()}
        self.calls = {"block": True, "rival": True}
        self.codes = {"block": 0, "rival": 0}
        self.head = HandshakeRules(phase="PHASE_READY", _up=Since(start=-_SPACING_MS))
        self.view = RobotView()
        self.code = self.first = self.status = 0
        self.up = {"link": True, "cpu": True}
        self.data: list[int] | None = None
        self.refusals = list(islice(self.reading.refused(self.chance), 12))
        self._look = {
            part: bench.program.reader([f"Main.{path}.{name}" for name in _SHOWN])
            for part, path in self.path.items()
        }

    def often(self, rate: float) -> bool:
        return self.chance.random() < rate

    def _put(self, part: str, pin: str, value: Any) -> None:
        self.bench[f"{self.path[part]}.{pin}"] = value

    def draw(self) -> None:
        """Choose the next actions of user, network and controller at random."""
        for part, rule in self.rules.items():
            if not rule.busy and not rule.execute and self.often(0.3):
                self._prepare(part, rule)
            elif rule.execute and self.often(0.15):
                rule.execute = False
                self._put(part, "Execute", False)
            self.calls[part] = self.often(0.98 if self.calls[part] else 0.4)
        if self.rules["block"].busy and not self.rules["block"].execute and self.often(0.1):
            self.rules["block"].execute = True  # an edge is ignored while the block is busy
            self._put("block", "Execute", True)
        self.bench["Chosen"] = self.bench.chosen if self.calls["block"] else 0
        self.bench["CallRival"] = self.calls["rival"]
        for name, on in self.up.items():
            self.up[name] = self.often(0.985 if on else 0.3)
        self.bench["Connected"] = self.up["link"]
        if self.head.phase == "PHASE_COMMAND_RUN":
            self.status = self.chance.choice(_FOLLOWS[self.status])
        elif self.status or self.often(0.02):
            self.status = self.chance.choice((0, 0, 0, 0x0200, 0x4000))

    def _prepare(self, part: str, rule: CommandRule) -> None:
        """Set random inputs of a block, and give Execute a rising edge."""
        rule.execute, rule.timeout = True, self.chance.choice(_LIMITS_MS)
        self._put(part, "Timeout", f"T#{rule.timeout}ms")
        if part == "rival":
            self.codes[part], self.rival_first = self.chance.choice(_TELEGRAMS)
            rule.refused = 0 if self.codes[part] else 0x8021
            self._put(part, "Code", self.codes[part])
            self._put(part, "Data[1]", self.rival_first)
        else:
            pins, rule.refused = self.reading.draw(self.chance), 0
            if self.refusals and self.often(0.1):
                pins, rule.refused = self.chance.choice(self.refusals)
            self.bench.set(pins)
            self.codes[part] = self.reading.code(pins) if not rule.refused else 0
        self._put(part, "Execute", True)

    def scan(self, now: int) -> None:
        """Run one scan of the program, and apply the rules of the second reading to it."""
        alarm = (self.chance.randrange(1, 99), self.chance.randrange(1, 999))
        self.bench.answer(self.status, alarm)
        self.bench.outputs(SO01=self.up["cpu"])
        self.bench.program.write_bytes("Main.InputArea", bytes(self.bench.so))
        self.bench.program.scan(now * 1000)
        view, link = self.view, self.up["link"]
        view.last, view.now = view.now, now
        view.connected, view.cpu_ok = link, link and self.up["cpu"]
        view.status, view.alarm = (self.status, alarm) if link else (0, (0, 0))
        view.out, view.running = self.head.phase == "PHASE_COMMAND_RUN", self.head.running
        view.asking = None
        for part in ("rival", "block"):  # in the order in which the program calls the two blocks
            if self.calls[part]:
                self.rules[part].scan(view)
                if view.asking is self.rules[part]:
                    self.code = self.codes[part]
                    self.first = self.rival_first if part == "rival" else 0
        self.head.scan(
            now,
            there=view.connected and view.cpu_ok,
            status=view.status,
            asked=view.asking is not None,
            hold=False,
            code=self.code,
            first=self.first,
            same=True,
            channel=view.channel,
            interval=_SPACING_MS,
        )

    def compare(self) -> None:
        """Compare the outputs of both blocks and the sent words with the second reading."""
        for part, rule in self.rules.items():
            expected = (rule.done, rule.busy, rule.active, rule.number != 0, rule.number)
            wrong = differences(_SHOWN, self._look[part](), (*expected, *rule.alarm))
            assert not wrong, f"{self.path[part]}: {wrong}\n{rule}\n{self.view}"
        words, phase = self.bench.words, self.head.phase
        assert words[0] == (self.code if phase == "PHASE_COMMAND_RUN" else 0), self.view
        if phase == "PHASE_COMMAND_DATA":
            self.data = words[1:]
            assert words[1] & 1 == self.first or self.first == 0
        expected_data = self.data if phase == "PHASE_COMMAND_RUN" else [0] * 15
        assert phase == "PHASE_COMMAND_DATA" or words[1:] == expected_data, self.view


@pytest.mark.parametrize("name", sampled(BLOCKS, 4))
def test_every_scan_is_the_one_that_the_rules_ask_for(name: str) -> None:
    """Each scan agrees with the second reading.

    Source: remote command guide, chapters 1 and 2; design of the library, 2 and 3.
    """
    bench = bench_of(name, "builtin")
    start = bench.now_us // 1000 + _SPACING_MS
    beside = _Beside(bench, name)
    for scan in range(_SCANS):
        beside.draw()
        beside.scan(start + _SCAN_MS * scan)
        beside.compare()
