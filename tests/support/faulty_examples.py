"""Users' programs, complete with their files, and typical faults in them.

A campaign finds each of these faults.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from plc_bench import ROOT

_Changes = tuple[tuple[str, str], ...]

#: A hand-written work cycle. It stores whether a part is in the hand, and can run slower.
_PICKER: _Changes = (
    (
        "    Stopping   : BOOL;\n",
        "    Stopping   : BOOL;\n    Holds : BOOL;\n    Speed : REAL := 50.0;\n",
    ),
    ("Speed := 50.0", "Speed := Speed"),
    ("    Target := 20;\n", "    Target := 20;\n    Holds := TRUE;\n"),
    ("  ELSIF Hand.Done THEN\n", "  ELSIF Hand.Done THEN\n    Holds := FALSE;\n"),
    (
        "  WriteArea(",
        "  IF NOT CellSafe OR NOT Connected OR Robot.SO.SO00_EmergencyStop THEN\n"
        "    Holds := FALSE;\n  END_IF;\n  WriteArea(",
    ),
)
_PICKER_DEMANDS = """length = "6s"
[operator]
buttons = ["Main.Start", "Main.Stop", "Main.Reset"]
switches = ["Main.CellSafe"]
values = { "Main.Speed" = [5.0, 20.0, 50.0] }
[faults]
leave_out = ["plc_stop", "plc_power_off"]
[[always]]
name = "vented hand"
that = "NOT (Main.Holds AND (NOT Main.CellSafe OR Main.Robot.SO.SO00_EmergencyStop))"
[[always]]
name = "no time-out"
that = "Main.Fault <> WORD#16#8011"
[[always]]
name = "Start starts it"
that = "Main.Stage <> PICK_POWER_UP OR BEFORE(Main.Stage) = PICK_POWER_UP OR Main.Start"
[recover]
set = { "Main.CellSafe" = true, "Main.Speed" = 50.0 }
steps = [
  { until = "Main.Stage <> PICK_POWER_UP", within = "20s" },
  { press = "Main.Reset", wait = "100ms" },
  { press = "Main.Start" },
]
when = "Main.Placed > BEFORE(Main.Placed)"
within = "30s"
"""
#: Two hand-written cycles that share a tray.
_DUO_DEMANDS = '''length = "6s"
[operator]
buttons = ["Main.Start1", "Main.Start2", "Main.Stop", "Main.Reset1", "Main.Reset2"]
switches = ["Main.CellSafe"]
[faults]
leave_out = ["plc_stop", "plc_power_off"]
[[always]]
name = "one at the tray"
that = "NOT (Main.Carry1.Stage = DUO_TO_TRAY AND Main.Carry2.Stage = DUO_TO_TRAY)"
[recover]
set = { "Main.CellSafe" = true }
steps = [
  { until = "Main.Carry1.Stage <> DUO_POWER_UP", within = "20s" },
  { until = "Main.Carry2.Stage <> DUO_POWER_UP", within = "20s" },
  { press = ["Main.Reset1", "Main.Reset2"], wait = "100ms" },
  { press = ["Main.Start1", "Main.Start2"] },
]
when = """Main.Carry1.Placed > BEFORE(Main.Carry1.Placed)
  AND Main.Carry2.Placed > BEFORE(Main.Carry2.Placed)"""
within = "40s"
'''


@dataclass(frozen=True)
class Faulty:
    """A fault in an example.

    Attributes:
        name: The kind of fault.
        example: Folder of the example.
        changes: The fault, as pairs of a text of the program and its replacement.
        kind: The kind of failure that a campaign reports for the fault.
        seed: A seed with which a campaign finds the fault.
    """

    name: str
    example: str
    changes: _Changes
    kind: str
    seed: int


def _faulty(name: str, example: str, kind: str, seed: int, *changes: tuple[str, str]) -> Faulty:
    return Faulty(name, example, changes, kind, seed)


_04, _12 = "04_pick_and_place", "12_two_robots"
FAULTY = (
    _faulty(
        *("lost part", _04, "always vented hand", 68),
        ("  IF NOT CellSafe OR", "  IF MovePtp.Busy AND NOT CellSafe OR"),
    ),
    _faulty(
        *("latch", _04, "always Start starts it", 36),
        ("Stage = PICK_IDLE AND StartEdge.Q", "Stage = PICK_IDLE AND Wanted"),
        (
            "  IF Stage = PICK_FAULT THEN",
            "  Wanted := StartEdge.Q OR (Wanted AND Stage <> PICK_POWER_UP);\n"
            "  IF Stage = PICK_FAULT THEN",
        ),
        ("    Holds : BOOL;\n", "    Holds : BOOL;\n    Wanted : BOOL;\n"),
    ),
    _faulty(
        *("link loss", _04, "recovery", 6),
        (
            "    IF ResetEdge.Q AND CellSafe THEN",
            "    IF ResetEdge.Q AND CellSafe AND Fault <> WORD#16#8001 THEN",
        ),
    ),
    _faulty("time limit", _04, "always no time-out", 3, ("T#10s", "T#3s")),
    _faulty(
        *("race", _12, "always one at the tray", 5),
        ("  Carry1(", "  Free1 := NOT Carry2.AtTray;\n  Free2 := NOT Carry1.AtTray;\n  Carry1("),
        ("TrayFree := NOT Carry2.AtTray", "TrayFree := Free1"),
        ("TrayFree := NOT Carry1.AtTray", "TrayFree := Free2"),
        ("    Stop       : BOOL;", "    Free1 : BOOL;\n    Free2 : BOOL;\n    Stop       : BOOL;"),
    ),
    _faulty(
        *("latch of Stop", _12, "recovery", 0),
        ("(Stopping OR Stop) AND NOT StartEdge.Q", "Stopping OR Stop"),
    ),
    _faulty(
        *("link loss while it waits", _12, "recovery", 15),
        ("    IF Stage = DUO_WAIT AND NOT", "    IF FALSE AND NOT"),
    ),
)


def changed_example(folder: Path, example: str, changes: _Changes = ()) -> None:
    """Write an example with changed texts into a folder, with its requirements as campaign.toml.

    The programs are cycles written by hand, without FB_WorkCycle and FB_Interlock.

    Raises:
        ValueError: a text to be replaced is missing.
    """
    source = ROOT / "tests/data/by_hand" / example
    left = [*(_PICKER if example == _04 else ()), *changes]
    texts = {file.name: file.read_text(encoding="utf-8") for file in source.glob("*.st")}
    for before, after in left:
        name = next((name for name, text in texts.items() if before in text), None)
        if name is None:
            raise ValueError(f"{example}: {before!r} is not there")
        texts[name] = texts[name].replace(before, after, 1)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    demands = _PICKER_DEMANDS if example == _04 else _DUO_DEMANDS
    (folder / "campaign.toml").write_text(demands, encoding="utf-8")
    for file in source.glob("robot*.toml"):
        (folder / file.name).write_bytes(file.read_bytes())
