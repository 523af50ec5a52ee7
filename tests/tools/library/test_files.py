"""Each file of plc/lib has one POU of its name, with its test and its manual section."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from plc_bench import LIBRARY, ROOT
from rcx_harness import spec
from rcx_tools.docs.pages import headers
from rcx_tools.library import library
from structured_text.language.load import load
from structured_text.language.types import BlockType, StructType
from structured_text.output.toml_files import load_toml

_POU = re.compile(r"^(?:FUNCTION_BLOCK|FUNCTION|PROGRAM|TYPE\s+)\s*(\w+)", re.MULTILINE)


def _code(file: Path) -> str:
    """Return the source without its comments."""
    return re.sub(r"\(\*.*?\*\)", "", file.read_text(encoding="utf-8"), flags=re.DOTALL)


def _robot() -> dict[str, StructType]:
    project = load([*LIBRARY, ROOT / "tests/data/library/Bench.st"])
    main = project.instances["Main"]
    robot = next(variable.type for variable in main.variables if variable.name == "Robot")
    assert isinstance(robot, StructType)
    return {name: kind for name, kind in robot.fields if isinstance(kind, StructType)}


def test_a_file_holds_the_pou_of_its_name_and_no_other() -> None:
    for file in LIBRARY:
        assert _POU.findall(_code(file)) == [file.stem]
        text = file.read_text(encoding="utf-8")
        assert len(text.splitlines()) <= (175 if "Generated from" in text else 150), file


def test_a_head_names_the_block_its_purpose_and_an_existing_test() -> None:
    for entry in headers():
        assert entry.name == entry.file.stem
        assert entry.purpose, entry.name
        assert all((ROOT / test).exists() for test in entry.tests), entry.name
        if entry.file.parent.name != "types":
            assert entry.tests, entry.name


def test_every_error_id_of_the_blocks_is_in_the_table_and_every_entry_is_used() -> None:
    used = {
        int(number, 16)
        for file in LIBRARY
        for number in re.findall(r"WORD#16#(8(?!000)[0-9A-F]{3})\b", _code(file))
    }
    listed = [error["id"] for error in load_toml(spec.folder() / "errors.toml")["error"]]
    assert sorted(used) == listed


def test_each_error_id_has_its_name_beside_it() -> None:
    table = load_toml(spec.folder() / "errors.toml")["error"]
    names = {f"{error['id']:04X}": error["name"] for error in table}
    lines = [(file, line) for file in LIBRARY for line in file.read_text("utf-8").splitlines()]
    for file, line in lines:
        numbers = re.findall(r"\bWORD#16#(8[0-9A-F]{3})\b", line)
        wanted = [names[number] for number in numbers if number in names]
        beside = [text for comment in re.findall(r"\(\* (.*?) \*\)", line)
                  for text in comment.split(", ")]  # fmt: skip
        assert not wanted or beside == wanted, (file, line)


@pytest.mark.exhaustive
@pytest.mark.parametrize("direction", ["output", "input"])
def test_the_structures_of_the_dedicated_bits_have_the_fields_of_the_table(direction: str) -> None:
    """Source: manual chapter 5, 2."""
    struct = _robot()["SO" if direction == "output" else "SI"]
    table = getattr(spec.signals(), direction)
    assert [name for name, _ in struct.fields] == [signal.name for signal in table]


def test_edge_triggered_blocks_have_the_pins_of_the_contract_with_working_defaults() -> None:
    """Source: PLCopen, edge-triggered function blocks."""
    project = load([*LIBRARY, ROOT / "tests/data/library/Bench.st"])
    outputs = ["Done", "Busy", "Active", "Error", "ErrorID"]
    found = []
    for block in project.blocks.values():
        assert isinstance(block, BlockType)
        pins = [variable.name for variable in block.variables if variable.section == "VAR_OUTPUT"]
        if "Done" in pins and not block.name.startswith("FB_Rcx"):
            assert pins[:5] == outputs
            found.append(block.name)
    written = {block.name for block in library().blocks.values() if not block.handwritten}
    assert written <= set(found)
    assert sorted(set(found) - written) == [
        *("FB_AlarmReset", "FB_AutoStart", "FB_EmergencyStop", "FB_MoveTable", "FB_PickPlace"),
        *("FB_PointBackup", "FB_PointRestore", "FB_PowerUp"),
        *("FB_ProgramCall", "FB_ProgramCallInWords", "FB_ProgramContinue"),
        *("FB_ProgramReset", "FB_ProgramStop", "FB_RemoteCommand", "FB_ReturnToOrigin"),
        *("FB_ServoOn", "FB_ServoOnFromEmergencyStop"),
    ]
