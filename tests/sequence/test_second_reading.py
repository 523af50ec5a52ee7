"""Every sequence block runs at random beside another block, and follows independent rules.

The test plays the controller: it answers late or not at all, and changes its outputs by itself. In
each scan, the block and the data on the wire must follow the rules of tests/support.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from random import Random
from typing import Any

import pytest

from head_rules import OTHERS, SAFETY, InputRules
from plc_bench import compiled
from sequence_rules import RULES, missing
from sequence_work import View
from shown import differences
from structured_text.engines.base import Program

_PINS = ("Done", "Busy", "Active", "Error", "ErrorID")
_SCAN_MS, _MARGIN_MS = 20, 20
_SPACING_MS = 100 + _MARGIN_MS

#: The other block is called after the block under test. In odd runs it is FB_ProgramReset.
_RIVALS = {
    "FB_EmergencyStop": "FB_ServoOnFromEmergencyStop",
    "FB_ServoOnFromEmergencyStop": "FB_EmergencyStop",
    "FB_ProgramStop": "FB_ProgramContinue",
    "FB_ProgramContinue": "FB_ProgramStop",
    "FB_ProgramReset": "FB_AutoStart",
}

_PROGRAM = """PROGRAM Second
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, EmergencyStopOk, StopOk, CallBlock, CallRival : BOOL;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Block : {block};
    Rival : {rival};
    Status : FB_Status;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  IF CallBlock THEN
    Block(Robot := Robot);
  END_IF;
  IF CallRival THEN
    Rival(Robot := Robot);
  END_IF;
  Status(Robot := Robot, Enable := TRUE);
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms,
            EmergencyStopOk := EmergencyStopOk, StopOk := StopOk);
END_PROGRAM
"""

#: Probability per scan that an output changes by itself; lower in calm phases.
_ALONE = {
    "SO00": (0.004, 0.2),
    "SO01": (0.3, 0.004),
    "SO02": (0.02, 0.01),
    "SO03": (0.006, 0.02),
    "SO04": (0.3, 0.01),
    "SO10": (0.2, 0.01),
    "SO11": (0.01, 0.02),
    "SO12": (0.1, 0.1),
    "SO13": (0.005, 0.03),
    "SO14": (0.005, 0.02),
    "SO15": (0.1, 0.1),
}
#: Effects of inputs: input and state, then output and state, then the probability.
_ANSWERS = (
    ("SI00", False, "SO00", True, 0.4),
    ("SI00", False, "SO02", False, 0.4),
    ("SI01", True, "SO02", True, 0.3),
    ("SI06", False, "SO13", False, 0.4),
    ("SI12", True, "SO13", True, 0.3),
    ("SI14", True, "SO11", True, 0.15),
    ("SI17", True, "SO11", True, 0.15),
    ("SI15", True, "SO14", True, 0.3),
    ("SI16", True, "SO03", False, 0.3),
)
#: Probabilities above this limit do not depend on the phase.
_RARE = 0.1
_LIMITS_MS = (0, 160, 300, 600, 1500)
#: Scans of a phase, in which the probabilities of disturbances, answers and other commands are
#: constant.
_PHASE_SCANS = 100
_CALM, _SURE, _RIVAL = (1.0, 0.3, 0.03), (1.0, 1.0, 0.1), (1.0, 1.0, 0.0)


def _rival(block: str, seed: int) -> str:
    return "FB_ProgramReset" if seed % 2 else _RIVALS.get(block, "FB_ProgramReset")


@cache
def _compiled(block: str, rival: str) -> Program:
    return compiled(_PROGRAM.format(block=block, rival=rival), "builtin")


class _Beside:
    """The program with two blocks, and the independent rules for both."""

    def __init__(self, block: str, seed: int) -> None:
        self.chance = Random(f"{block} {seed}")
        self.program = _compiled(block, _rival(block, seed))
        self.view, self.inputs = View(), InputRules()
        self.pins = {"EmergencyStopOk": True, "StopOk": True, "Connected": True}
        self.calls = {"Block": True, "Rival": True}
        self.rules = {"Block": RULES[block](), "Rival": RULES[_rival(block, seed)]()}
        self.so = {"SO01", "SO04", "SO10"}
        self._spell(0)
        self.names = {"Block": block, "Rival": _rival(block, seed)}
        self._look = {
            part: self.program.reader([f"Main.{part}.{name}" for name in _PINS])
            for part in self.rules
        }
        self._look_stage = self.program.reader(["Main.Status.Stage"])
        self.missing = ""
        self._staged = [part for part, rule in self.rules.items() if hasattr(rule, "parts")]

    def put(self, name: str, value: Any) -> None:
        self.program.write(f"Main.{name}", value)

    def often(self, rate: float) -> bool:
        return self.chance.random() < rate

    def _spell(self, scan: int) -> None:
        if scan % _PHASE_SCANS == 0:
            self._calm, self._sure, self._rival = map(self.chance.choice, (_CALM, _SURE, _RIVAL))

    def draw(self, scan: int) -> None:
        """Choose the actions of user, cell and controller before this scan at random."""
        self._spell(scan)
        for part, rule in self.rules.items():
            lively = self._rival if part == "Rival" and not rule.execute else 1.0
            if self.often(lively * (0.12 if rule.execute and not rule.busy else 0.04)):
                rule.execute = not rule.execute
                self.put(f"{part}.Execute", rule.execute)
            if self.often(0.05):
                rule.timeout = self.chance.choice(_LIMITS_MS)
                self.put(f"{part}.Timeout", f"T#{rule.timeout}ms")
            self.calls[part] = self.often(0.5 if not self.calls[part] else 0.997)
            self.put(f"Call{part}", self.calls[part])
        block = self.rules["Block"]
        if hasattr(block, "axes") and self.often(0.1):
            block.axes = self.chance.choice(("ORIGIN_INCREMENTAL", "ORIGIN_ABSOLUTE"))
            self.put("Block.Axes", block.axes)
        if hasattr(block, "program") and self.often(0.1):
            block.program = self.often(0.7)
            self.put("Block.StartProgram", block.program)
        for pin, on in self.pins.items():
            self.pins[pin] = self.often(1 - 0.01 * self._calm if on else 0.15)
            self.put(pin, self.pins[pin])
        for name, (rises, falls) in _ALONE.items():
            rate = falls if name in self.so else rises
            if self.often(rate * self._calm if rate < _RARE else rate):
                self.so ^= {name}
        for cause, state, name, on, rate in _ANSWERS:
            if (cause in self.view.si) is state and self.often(rate * self._sure):
                self.so = self.so | {name} if on else self.so - {name}

    def scan(self, now: int) -> None:
        """Run one scan of the blocks and of their rules."""
        bits = sum(1 << (8 * int(name[2]) + int(name[3])) for name in self.so)
        self.program.write_bytes("Main.InputArea", bytes(32) + bits.to_bytes(2, "little"))
        self.program.scan(now * 1000)
        view = self.view
        view.elapsed, view.now, view.connected = now - view.now, now, self.pins["Connected"]
        view.so = frozenset(self.so) if view.connected else frozenset()
        view.asked, view.kept = set(), {"SI00": False, "SI06": False}
        for part, rule in self.rules.items():
            if self.calls[part]:
                rule.scan(view)
        self.missing = missing(view)
        for name, pin in (("SI00", "EmergencyStopOk"), ("SI06", "StopOk")):
            view.held[name] = view.held[name] or view.kept[name]
            view.ok[name] = self.pins[pin] and not view.held[name]
        wanted = {name: name[:4] in view.asked for name in OTHERS}
        wanted |= {name: view.ok[name[:4]] for name in SAFETY}
        self.inputs.scan(now, wanted, view.connected, _SPACING_MS, _SPACING_MS + _MARGIN_MS)
        view.si = frozenset(name[:4] for name, on in self.inputs.applied.items() if on)
        view.settled = self.inputs.settled
        view.turns.pass_on()

    def compare(self) -> None:
        """Compare the outputs of the blocks, and the written dedicated inputs."""
        for part, rule in self.rules.items():
            expected = (rule.done, rule.busy, rule.active, bool(rule.number), rule.number)
            self._same(f"{part} {self.names[part]}", _PINS, self._look[part](), expected)
        for part in self._staged:
            stage = self.program.read(f"Main.{part}.Stage")
            expected_stage = f"POWER_UP_{self.rules[part].stage}"
            self._same(f"{part} {self.names[part]}", ("Stage",), (stage,), (expected_stage,))
        self._same("FB_Status", ("Stage",), self._look_stage(), (f"POWER_UP_{self.missing}",))
        area = int.from_bytes(self.program.read_bytes("Main.OutputArea")[32:34], "little")
        names = [f"SI{byte}{bit}" for byte in range(2) for bit in range(8)]
        bits = [bool(area >> k & 1) for k in range(16)]
        self._same("dedicated inputs", names, bits, [name in self.view.si for name in names])

    def _same(
        self, where: str, names: Sequence[str], got: Sequence[Any], expected: Sequence[Any]
    ) -> None:
        if wrong := differences(names, got, expected):
            on = ", ".join((*sorted(self.view.so), *sorted(self.view.si))) or "nothing"
            time = f"scan {self.view.now // _SCAN_MS} ({self.view.now} ms)"
            raise AssertionError(f"{where}, {time}: {wrong}; ON: {on}")


#: Blocks with more states get more runs.
_RUNS = {"FB_PowerUp": 5, "FB_ProgramContinue": 4, "FB_ServoOnFromEmergencyStop": 4}
_CASES = [(block, seed) for block in sorted(RULES) for seed in range(_RUNS.get(block, 2))]


@pytest.mark.exhaustive(
    but=[
        *("FB_AutoStart-0", "FB_EmergencyStop-0", "FB_PowerUp-0", "FB_ProgramContinue-0"),
        *("FB_ReturnToOrigin-0", "FB_ServoOnFromEmergencyStop-0"),
    ]
)
@pytest.mark.parametrize(("block", "seed"), _CASES)
def test_every_scan_follows_the_rules(block: str, seed: int) -> None:
    """Source: manual chapter 5, 2 and 3.1 to 3.3; design of the library, 2 and 3."""
    beside = _Beside(block, seed)
    start = beside.program.snapshot()
    try:
        for name in ("EmergencyStopOk", "StopOk", "Connected"):
            beside.put(name, True)
        for part in beside.rules:
            beside.put(f"{part}.Timeout", "T#0s")
        if block == "FB_ReturnToOrigin":
            beside.put("Block.Confirm", "T#60ms")
        for scan in range(1500):
            beside.draw(scan)
            beside.scan(_SCAN_MS * scan)
            beside.compare()
    finally:
        beside.program.restore(start)
