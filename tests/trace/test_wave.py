from __future__ import annotations

import re
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path

import pytest

from rcx_harness import Cell, InputError, RobotConfig
from rcx_harness.trace import Cycle, Scan, Trace
from rcx_harness.trace.wave import Wave
from structured_text.language.types import ArrayType, ElementaryType, EnumType, StructType, Type

Build = Callable[..., Cell]
INT = ElementaryType("INT")


def record(raw_cell: Build, file: Path) -> None:
    cell = raw_cell(robot=RobotConfig(boot_time=0.0))
    wave = Wave(file)
    cell.trace.listen(wave.take)
    cell.run("100ms")
    cell["Main.Bits0"] = 0x01
    cell["Main.Data"] = 0x34
    cell["Main.Reserved"] = 1
    cell.run("100ms")
    wave.close()


def changes(text: str, scope: str, name: str) -> list[tuple[int, str]]:
    """Return times and values of one variable of a VCD file, after its initial value."""
    section = text[text.index(f"$scope module {scope} $end") :]
    found = re.search(rf"\$var \w+ \d+ (\S+) {re.escape(name)} ", section)
    assert found
    code, now, result = re.escape(found[1]), 0, []
    for line in text[text.index("$dumpvars") :].splitlines():
        if line.startswith("#"):
            now = int(line[1:])
        elif re.fullmatch(rf"[01]{code}|[brs]\S* {code}", line):
            result.append((now, line.split()[0].removesuffix(found[1])))
    return result[1:]


def test_both_sides_of_the_wire_are_recorded(raw_cell: Build, tmp_path: Path) -> None:
    """A wave file has the areas of the PLC and of the controller.

    The PLC writes SI(00) at 100 ms, and the controller reads it at 115 ms.
    """
    record(raw_cell, tmp_path / "w.vcd")
    text = (tmp_path / "w.vcd").read_text()
    assert "$timescale 1 us $end" in text
    assert changes(text, "plc", "SI00_EmergencyStop") == [(100_000, "1")]
    assert changes(text, "robot", "SI00_EmergencyStop") == [(115_000, "1")]
    assert changes(text, "plc", "SIW01") == [(100_000, "b110100")]
    assert changes(text, "rules", "broken")[0] == (100_000, "b1")


def test_the_same_run_gives_the_same_file(raw_cell: Build, tmp_path: Path) -> None:
    record(raw_cell, tmp_path / "a.vcd")
    record(raw_cell, tmp_path / "b.vcd")
    assert (tmp_path / "a.vcd").read_bytes() == (tmp_path / "b.vcd").read_bytes()


def test_an_unwritable_place_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        Wave(tmp_path / "file" / "w.vcd")


def test_watched_variables_are_in_the_scopes_of_their_paths(tmp_path: Path) -> None:
    """Watched variables are in scopes named by their paths.

    -7 in 16 bits is 1111111111111001. Texts in a wave file must not contain spaces.
    """
    item = StructType("ITEM", (("Speed", INT), ("State", EnumType("STATE", ("IDLE", "RUN")))))
    types: dict[str, Type] = {
        "Main.Items": ArrayType("ITEMS", ((1, 1),), item),
        "Main.On": ElementaryType("BOOL"),
        "Main.Mask": ElementaryType("WORD"),
        "Main.Ratio": ElementaryType("REAL"),
        "Main.Waited": ElementaryType("TIME"),
        "Main.Text": ElementaryType("STRING"),
        "Main.Items[1].Speed": INT,  # named twice
    }
    trace = Trace({}, watched=types)
    wave = Wave(tmp_path / "w.vcd", trace=trace)
    first = [{"Speed": 0, "State": "IDLE"}], False, 0, 0.0, timedelta(0), "", 0
    last = ([{"Speed": -7, "State": "RUN"}], True, 0x20, 1.5, timedelta(milliseconds=1500),
            "a b\u20ac", -7)  # fmt: skip
    for number, values in enumerate((first, last, last)):
        record = dict(zip(types, values, strict=True))
        wave.take(Scan(number * 10_000, number, bytes(48), bytes(48), record))
    wave.close()
    text = (tmp_path / "w.vcd").read_text(encoding="ascii")
    assert "$scope module variables $end" in text
    assert changes(text, "Main", "On")[-1:] == [(10_000, "1")]
    assert changes(text, "Main", "Mask")[-1:] == [(10_000, "b100000")]
    assert changes(text, "Items[1]", "Speed")[-1:] == [(10_000, "b1111111111111001")]
    assert changes(text, "Items[1]", "State") == [(10_000, "sRUN")]
    assert changes(text, "Main", "Ratio")[-1:] == [(10_000, "r1.5")]
    assert changes(text, "Main", "Waited")[-1:] == [(10_000, "r1500")]
    assert changes(text, "Main", "Text")[-1:] == [(10_000, r"sa\x20b\\u20ac")]


def test_positions_are_numbers_in_a_scope_of_each_controller(tmp_path: Path) -> None:
    trace = Trace({}, axes=[["Position X [mm]"], ["Robot 1 axis 1 [pulses]"]])
    wave = Wave(tmp_path / "w.vcd", 2, trace)
    wave.take(Cycle(0, 0, b"", bytes(48), 1, (0.5,)))
    wave.take(Cycle(0, 0, b"", bytes(48), 2, (-7,)))
    wave.take(Cycle(5_000, 1, b"", bytes(48), 1))
    wave.take(Cycle(5_000, 1, b"", bytes(48), 2, (9,)))
    wave.take(Cycle(10_000, 2, b"", bytes(48), 1, (-1.25,)))
    wave.close()
    text = (tmp_path / "w.vcd").read_text(encoding="ascii")
    assert changes(text, "positions", "Position_X_mm") == [(10_000, "r-1.25")]
    assert changes(text, "positions_2", "Robot_1_axis_1_pulses") == [(5_000, "r9")]
