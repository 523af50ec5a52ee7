from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness import Cell, InputError, RobotConfig
from rcx_harness.trace.wave import Wave

Build = Callable[..., Cell]


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
    """Times and values of one variable of a VCD file, after its initial value."""
    section = text[text.index(f"$scope module {scope} $end") :]
    found = re.search(rf"\$var \w+ \d+ (\S+) {name} ", section)
    assert found
    code, now, result = re.escape(found[1]), 0, []
    for line in text[text.index("$dumpvars") :].splitlines():
        if line.startswith("#"):
            now = int(line[1:])
        elif re.fullmatch(rf"[01]{code}|b\w+ {code}", line):
            result.append((now, line.split()[0].removesuffix(found[1])))
    return result[1:]


def test_both_sides_of_the_wire_are_recorded(raw_cell: Build, tmp_path: Path) -> None:
    """The PLC writes SI(00) at 100 ms, the controller sees it at 115 ms."""
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


def test_a_place_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        Wave(tmp_path / "file" / "w.vcd")
