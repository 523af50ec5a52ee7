"""FB_Jog and FB_ContinuousPosition agree with an independent implementation of their rules.

This implementation, the "second reading", is in tests/support. FB_RemoteCommand runs in the same
program. The test simulates a controller that answers at random and is sometimes not connected. The
outputs of both blocks and the sent words are compared in each scan.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from random import Random
from typing import Any

import pytest

from command_rules import CommandRule
from head_rules import OTHERS, HeadRules
from level_rules import LEVELS, ContinuousRule, JogRule, LevelView
from plc_bench import compiled
from shown import differences
from structured_text.engines.base import Program

_SCAN_MS, _MARGIN_MS = 40, 20
_SHOWN = ("Valid", "Busy", "Error", "ErrorID", "AlarmGroup", "AlarmCategory")
_SHOWN_BY_RIVAL = ("Done", "Busy", "Active", *_SHOWN[2:])
_SCANS = 1500
_LIMITS_MS = (0, 120, 320, 800)
#: Number of scans in a phase. Within a phase, the probabilities of faults and of other commands are
#: constant.
_PHASE_SCANS = 60
_CALM, _RIVAL = (1.0, 0.3, 0.0), (1.0, 0.2, 0.0)
_FOLLOWS = {
    0x0000: (0x0000, 0x0000, 0x0100, 0x0100, 0x0100, 0x0200, 0x4000),
    0x0100: (*[0x0100] * 12, 0x0200, 0x4000, 0x0000),
    0x0200: (0x0200,),
    0x4000: (0x4000,),
}
_PROGRAM = """PROGRAM Second
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, EmergencyStopOk, StopOk, CallBlock, CallRival : BOOL;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Block : {};
    Rival : FB_RemoteCommand;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  IF CallRival THEN
    Rival(Robot := Robot);
  END_IF;
  IF CallBlock THEN
    Block(Robot := Robot);
  END_IF;
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms,
            EmergencyStopOk := EmergencyStopOk, StopOk := StopOk);
END_PROGRAM
"""


@cache
def _compiled(block: str) -> Program:
    return compiled(_PROGRAM.format(block), "builtin")


class _Beside:
    """The program with two blocks, and the second reading of the rules for each of them."""

    def __init__(self, block: str, seed: int) -> None:
        self.chance = Random(f"{block} {seed}")
        self.program = _compiled(block)
        self.rule, self.rival = LEVELS[block](), CommandRule()
        self.head, self.view = HeadRules(), LevelView()
        self.rival_code, self.rival_data = 0x0501, [0] * 15
        self.code, self.data = 0, [0] * 15
        self.status = 0
        self.were_ok = (False, False)
        self.response = [0] * 15
        self.on = dict.fromkeys(("Connected", "EmergencyStopOk", "StopOk", "SO01"), True)
        self.on["SO00"] = False
        self.calls = {"Block": True, "Rival": True}
        self._look = self._reader("Block", _SHOWN)
        self._look_rival = self._reader("Rival", _SHOWN_BY_RIVAL)
        more = {
            "FB_Jog": ["Pulses", "PositionMm", "Stopping"],
            "FB_ContinuousPosition": ["Pulses", "PositionMm", "HandSystem", "Arm1", "Arm2"],
        }
        self._look_more = self._reader("Block", more[block])

    def _reader(self, part: str, names: Sequence[str]) -> Any:
        return self.program.reader([f"Main.{part}.{name}" for name in names])

    def put(self, name: str, value: Any) -> None:
        self.program.write(f"Main.{name}", value)

    def often(self, rate: float) -> bool:
        return self.chance.random() < rate

    def draw(self, scan: int) -> None:
        """Choose the next actions of user, cell and controller at random."""
        if scan % _PHASE_SCANS == 0:
            self.calm, self.busy = self.chance.choice(_CALM), self.chance.choice(_RIVAL)
            self.silent = self.often(0.3)
        rule, rival = self.rule, self.rival
        if self.often(0.08 if rule.enable else 0.2):
            rule.enable = not rule.enable
            self.put("Block.Enable", rule.enable)
        if self.often(0.1):
            self._change_inputs()
        if self.often(0.2 if rival.execute else 0.1 * self.busy):
            rival.execute = not rival.execute
            if rival.execute and not rival.busy:
                self.rival_code = self.chance.choice((0x0501, 0x1506, 0x2021))
                self.rival_data = [self.chance.randrange(65536) for _ in range(15)]
                rival.timeout = self._limit("Rival")
                self.put("Rival.Code", self.rival_code)
                self.put("Rival.Data", self.rival_data)
            self.put("Rival.Execute", rival.execute)
        for part, called in self.calls.items():
            self.calls[part] = self.often(1 - 0.01 * self.calm if called else 0.4)
            self.put(f"Call{part}", self.calls[part])
        for name, on in self.on.items():
            usual = on is not (name == "SO00")
            self.on[name] = on ^ self.often(0.015 * self.calm if usual else 0.3)
            if not name.startswith("SO"):
                self.put(name, self.on[name])
        self._answer()

    def _change_inputs(self) -> None:
        rule, chance = self.rule, self.chance
        rule.timeout = self._limit("Block")
        rule.robot = chance.choice((0, 0, 0, 1, 2, 3, 4, 4, -1, 5))
        self.put("Block.RobotNumber", rule.robot)
        if isinstance(rule, JogRule):
            rule.frame, rule.axis = (
                chance.randrange(3),
                chance.choice((1, 2, 3, 4, 5, 6, 6, 6, 0, 7)),
            )
            rule.minus, rule.output = self.often(0.5), chance.randrange(3)
            frames = ("JOG_PULSES", "JOG_CARTESIAN", "JOG_TOOL")
            outputs = ("POSITION_NONE", "POSITION_PULSES", "POSITION_MM")
            self.put("Block.Frame", frames[rule.frame])
            self.put("Block.Axis", rule.axis)
            self.put("Block.Direction", "DIRECTION_MINUS" if rule.minus else "DIRECTION_PLUS")
            self.put("Block.PositionOutput", outputs[rule.output])
        elif isinstance(rule, ContinuousRule):
            rule.unit_mm = self.often(0.5)
            self.put("Block.Unit", "UNIT_MM" if rule.unit_mm else "UNIT_PULSES")

    def _limit(self, part: str) -> int:
        limit = self.chance.choice(_LIMITS_MS)
        self.put(f"{part}.Timeout", f"T#{limit}ms")
        return limit

    def _answer(self) -> None:
        """Choose the controller's status. If SI(06) is OFF, a running jog ends with an alarm."""
        stopped = not self.head.inputs.applied["SI06_Stop"]
        if self.silent and self.often(0.95):
            return
        if self.head.handshake.phase != "PHASE_COMMAND_RUN":
            asked = self.status or self.often(0.01 * self.calm)
            self.status = self.chance.choice((0, 0, 0, 0x0200, 0x4000)) if asked else 0
        elif stopped and self.code & 0x0FFF in (0x20, 0x21, 0x22) and self.often(0.3):
            self.status = 0x4000
        else:
            self.status = self.chance.choice(_FOLLOWS[self.status])
        if self.often(0.5):
            self.response = [self.chance.randrange(65536) for _ in range(15)]

    def scan(self, now: int) -> None:
        """Run one scan of the program, and apply the rules of the second reading to it."""
        on, view, head = self.on, self.view, self.head
        bits = on["SO01"] << 1 | on["SO00"] | 0x0110
        words = [self.status, *self.response, bits]
        area = b"".join(word.to_bytes(2, "little") for word in words)
        self.program.write_bytes("Main.InputArea", area)
        self.program.scan(now * 1000)
        link = on["Connected"]
        view.last, view.now = view.now, now
        view.connected, view.cpu_ok = link, link and on["SO01"]
        view.status = self.status if link else 0
        view.response = self.response if link else [0] * 15
        view.alarm = (view.response[0], view.response[1])
        view.out = head.handshake.phase == "PHASE_COMMAND_RUN"
        view.running = head.handshake.running
        view.released = head.inputs.applied["SI06_Stop"] and head.inputs.settled
        view.stopped = (link and on["SO00"]) or not self.were_ok[0]
        view.stop_ok = self.were_ok[1] and not head.jog_stop
        view.asking, view.stop_jog = None, False
        if self.calls["Rival"]:
            self.rival.scan(view)
            if view.asking is self.rival:
                self.code, self.data = self.rival_code, self.rival_data
        asked = view.asking
        if self.calls["Block"]:
            self.rule.scan(view)
            if view.asking is self.rule.job:
                self.code, self.data = self.rule.code, self.rule.data
        asked = view.asking or asked
        self.were_ok = (on["EmergencyStopOk"], on["StopOk"])
        head.scan(
            now,
            connected=link,
            cpu_ok=view.cpu_ok,
            status=view.status,
            asked=asked is not None,
            code=self.code,
            data=self.data,
            general=[0] * 15,
            stop_jog=view.stop_jog,
            ok=self.were_ok,
            holds=(False, False),
            requests=dict.fromkeys(OTHERS, False),
            channel=view.channel,
            interval=100,
            margin=_MARGIN_MS,
        )

    def __str__(self) -> str:
        return f"{self.rule}, {self.rival}, {self.view}"

    def compare(self) -> None:
        """Compare the outputs of both blocks and the sent words with the second reading."""
        rule, rival = self.rule, self.rival
        shown = (rule.valid, rule.busy, rule.number != 0, rule.number, *rule.alarm)
        wrong = differences(_SHOWN, self._look(), shown)
        assert not wrong, f"Block: {wrong}\n{self}"
        flags = (rival.done, rival.busy, rival.active, rival.number != 0)
        expected = (*flags, rival.number, *rival.alarm)
        wrong = differences(_SHOWN_BY_RIVAL, self._look_rival(), expected)
        assert not wrong, f"Rival: {wrong}\n{self}"
        pulses, millimetres, *more = self._look_more()
        assert pulses == rule.pulses, str(self)
        assert millimetres == pytest.approx(rule.millimetres, rel=1e-6), str(self)
        if isinstance(rule, JogRule):
            assert more == [rule.stopping], str(self)
        elif isinstance(rule, ContinuousRule):
            hand = ("HAND_NONE", "HAND_RIGHT", "HAND_LEFT")[rule.hand]
            assert more == [hand, *rule.arms], str(self)
        area = self.program.read_bytes("Main.OutputArea")
        words = [int.from_bytes(area[k : k + 2], "little") for k in range(0, 34, 2)]
        assert words == [*self.head.words, self.head.bits], str(self)


@pytest.mark.exhaustive(but=["FB_Jog-0"])
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("block", sorted(LEVELS))
def test_every_scan_is_the_one_that_the_rules_ask_for(block: str, seed: int) -> None:
    """Each scan agrees with the second reading.

    Source: guide, chapters 1 and 2, 4.2.6 and 4.7.4.
    """
    beside = _Beside(block, seed)
    start = beside.program.snapshot()
    try:
        for part in ("Block", "Rival"):
            beside.put(f"{part}.Timeout", "T#0s")
        for scan in range(_SCANS):
            beside.draw(scan)
            beside.scan(_SCAN_MS * scan)
            beside.compare()
    finally:
        beside.program.restore(start)
