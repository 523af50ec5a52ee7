"""`rcx export l5x` writes Add-On Instructions for Studio 5000 that behave as the blocks."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from example_runs import EXAMPLES
from exported import example_sources, library, written
from l5x_structure import faults
from mistakes import check
from plc_bench import ROOT
from rcx_harness.cell.sources import source_files
from structured_text.engines.base import Program
from structured_text.engines.load import build
from structured_text.export import TARGETS
from structured_text.export.output import write
from structured_text.export.parts import Sources
from structured_text.language.types import BlockType


@pytest.fixture(scope="module")
def root(whole: bool) -> ET.Element:
    """Return the root element of the exported sample."""
    return ET.fromstring(written("l5x", whole=whole).files[""])


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an L5X file with the first example and the parts of the library that it needs."""
    output = TARGETS["l5x"].write(example_sources("01_power_up"))
    (file,) = write(output, tmp_path_factory.mktemp("l5x") / "cell.L5X")
    return file


def _routine(root: ET.Element, aoi: str, name: str = "Logic") -> list[str]:
    path = f".//AddOnInstructionDefinition[@Name='{aoi}']/Routines/Routine[@Name='{name}']"
    found = root.find(path)
    assert found is not None
    return [(line.text or "").strip("\n") for line in found.iter("Line")]


def test_each_instruction_is_declared_before_it_is_used(root: ET.Element, sources: Sources) -> None:
    declared = [one.attrib["Name"] for one in root.iter("AddOnInstructionDefinition")]
    blocks = [part.name for part in sources.of("FUNCTION", "FUNCTION_BLOCK")]
    assert declared == ["RCX_TON", "RCX_R_TRIG", "RCX_FirstScan", *blocks]
    for place, aoi in enumerate(root.iter("AddOnInstructionDefinition")):
        used = aoi.findall("Dependencies/Dependency[@Type='AddOnInstructionDefinition']")
        assert {one.attrib["Name"] for one in used} <= set(declared[:place])


@pytest.mark.exhaustive
def test_one_import_brings_the_whole_library(tmp_path: Path) -> None:
    """One L5X file imports the whole library, with valid tags and values.

    Source: 1756-PM010, importing: an instruction is imported with all instructions that it refers
    to.
    """
    (file,) = write(TARGETS["l5x"].write(library()), tmp_path / "library.L5X")
    root = ET.parse(file).getroot()
    assert faults(root) == []
    assert root.attrib["TargetType"] == "AddOnInstructionDefinition"
    (target,) = root.iterfind(".//*[@Use='Target']")
    assert target.attrib["Name"] == root.attrib["TargetName"] == "RCX_Library"
    inside = [one.attrib["DataType"] for one in target.iter("LocalTag")]
    assert len(inside) == len(root.findall(".//AddOnInstructionDefinition")) - 1
    assert [str(error) for error in check(source_files([file], None).own)] == []


def test_the_file_has_the_structure_of_the_manual(root: ET.Element) -> None:
    """The file has the structure that Rockwell's manual 1756-RM084 describes.

    Source: 1756-RM084, structure of data types, Add-On Instructions and programs.
    """
    assert faults(root) == []


def test_an_instance_begins_with_the_values_of_its_instruction(root: ET.Element) -> None:
    """The data of each instance have the default values of its instruction.

    Source: 1756-RM084, decorated data: a member for each parameter that stores a value.
    """
    first: dict[str | None, dict[str | None, str | None]] = {}
    for aoi in root.iter("AddOnInstructionDefinition"):
        values = {one.get("Name"): one.find("*/DataValue") for one in aoi.iter("Parameter")}
        first[aoi.get("Name")] = {
            "EnableIn": "1",
            "EnableOut": "0",
            **{name: one.get("Value") for name, one in values.items() if one is not None},
        }
    instances = [one for one in root.iter("Structure") if one.get("DataType") in first]
    assert len(instances) > 20
    for one in instances:
        given = {member.get("Name"): member.get("Value") for member in one}
        assert given == first[one.get("DataType")], one.get("DataType")


def test_structured_text_has_no_ladder_instructions(root: ET.Element) -> None:
    """The export uses no instructions that exist only in ladder, such as FLL.

    Source: Studio 5000 help, File Fill; Runtime Controller Configuration and Status.
    """
    code = "\n".join(re.sub(r"\(\*.*?\*\)", "", line.text or "") for line in root.iter("Line"))
    assert "COP(" in code
    assert not re.search(r"\bFLL\(|\bS:FS\b", code)


def test_blocks_are_initialised_when_the_controller_starts(cell: Path) -> None:
    """When the controller starts, the Prescan routine clears all tags of a block except inputs.

    Without this routine, tags would keep their values without power.

    Source: 1756-PM010, Prescan routine.
    """
    root = ET.fromstring(cell.read_text())
    for aoi in root.iter("AddOnInstructionDefinition"):
        name = aoi.attrib["Name"]
        if name.startswith("FC_"):
            assert aoi.attrib["ExecutePrescan"] == "false", "a function has no memory"
            continue
        assert aoi.attrib["ExecutePrescan"] == "true"
        cleared = "\n".join(_routine(root, name, "Prescan"))
        for tag in (*aoi.iter("Parameter"), *aoi.iter("LocalTag")):
            kept = tag.attrib.get("Usage") in ("Input", "InOut")
            system = tag.attrib["Name"] == "EnableOut"
            inside = tag.attrib["DataType"].startswith(("FB_", "FC_", "RCX_TON", "RCX_R_TRIG"))
            temporary = tag.attrib["Name"].startswith(("Temp_", "Zero_"))
            if not (kept or system or inside or temporary):
                assert tag.attrib["Name"] in cleared, f"{name}.{tag.attrib['Name']}"
            block = tag.attrib["DataType"] if tag.tag == "LocalTag" else ""
            if block.startswith(("FB_", "RCX_TON", "RCX_R_TRIG")):
                pins = root.iterfind(f".//*[@Name='{block}']/Parameters/Parameter[@Usage='Input']")
                for pin in (f"{tag.attrib['Name']}.{one.attrib['Name']}" for one in pins):
                    assert f"{pin} := " in cleared or pin.endswith(".EnableIn"), f"{name}.{pin}"


def test_a_program_initialises_only_tags_that_it_writes(cell: Path) -> None:
    """In the first scan, a program clears the tags that it writes, not its inputs.

    Inputs are, for example, the input area and the push buttons.
    """
    root = ET.fromstring(cell.read_text())
    routine = root.find(".//Program[@Name='PowerUp']/Routines/Routine[@Name='Main']")
    assert routine is not None
    lines = [(line.text or "").strip() for line in routine.iter("Line")]
    first = lines[: lines.index("END_IF;")]
    assert first[:2] == ["RCX_FirstScan(RCX_FirstScan_1);", "IF RCX_FirstScan_1.Q THEN"]
    assert "Stage := 0(*STAGE_IDLE*);" in first
    assert "COP(Zero_RCX_REF, Robot, 1);" in first
    assert "COP(Zero_SINT_512[0], OutputArea[0], 512);" in first
    assert not [line for line in first if "InputArea" in line or "Connected" in line]


def test_pins_have_the_types_and_defaults_of_the_sources(cell: Path) -> None:
    root = ET.fromstring(cell.read_text())
    pins = {
        one.attrib["Name"]: one
        for one in root.iterfind(".//AddOnInstructionDefinition[@Name='FB_MovePtp']//Parameter")
    }

    def pin(name: str, *attributes: str) -> tuple[str | None, ...]:
        return tuple(pins[name].get(one) for one in ("DataType", "Usage", *attributes))

    assert list(pins)[:4] == ["EnableIn", "EnableOut", "Robot", "Execute"]
    assert pin("Robot", "Required") == ("RCX_REF", "InOut", "true")
    assert pin("Execute", "Required", "Visible") == ("BOOL", "Input", "false", "true")
    assert pin("Pulses", "Dimensions") == ("DINT", "InOut", "7"), "elements 1 to 6, as in ST"
    assert pin("ErrorID") == ("DINT", "Output")
    timeout = pins["Timeout"].find("DefaultData/DataValue")
    assert timeout is not None
    assert timeout.attrib["Value"] == "60000", "T#60s in milliseconds"
    said = pins["SpeedMode"].findtext("Description") or ""
    assert "0 SPEED_PROGRAM, 1 SPEED_DIRECT, 2 SPEED_PERCENT" in said


def test_bools_of_structures_are_bits_of_hidden_bytes(cell: Path) -> None:
    """The nine BOOL members of RCX_SI are bits of two hidden SINT members.

    Source: 1756-RM084, data types: a BOOL member is a BIT of a hidden SINT.
    """
    root = ET.fromstring(cell.read_text())
    members = root.findall(".//DataType[@Name='RCX_SI']/Members/Member")
    hidden = [one.attrib["Name"] for one in members if one.attrib["Hidden"] == "true"]
    bits = [one for one in members if one.attrib["DataType"] == "BIT"]
    assert len(hidden) == 2, "nine bits"
    places = [(one.attrib["Target"], int(one.attrib["BitNumber"])) for one in bits]
    assert places == [*((hidden[0], bit) for bit in range(8)), (hidden[1], 0)]


def test_after_a_restart_the_program_is_in_its_initial_state(cell: Path) -> None:
    """After a restart in the middle of its work, the program is in the state of a new controller.

    A controller prescans every instruction, including those after a FALSE condition. The built-in
    engine prescans an instruction at its first call, so some blocks are prescanned later.

    Source: 1756-PM010, Prescan routine; chapter 5, 3.1: nothing starts by itself.
    """
    files = list(source_files([cell, EXAMPLES[0].folder / "Config.st"], None).all)
    worked, new = (build(files, "builtin").program for _ in range(2))
    worked.write("Main.CellSafe", True)
    worked.write("Main.Start", True)
    for scan in range(100):
        _drive(worked)
        worked.scan(scan * 10_000)
    assert worked.read("Main.ServoOn.Busy")
    assert worked.read("Main.Robot.SI.SI01_ServoOn")
    worked.write("Main.Start", False)
    worked.write("Main.CellSafe", False)
    for path, _ in worked.walk():
        if path.endswith("RcxPrescanned"):
            worked.write(path, False)
    _drive(worked)
    worked.scan(1_000_000)
    _drive(new)
    new.scan(0)
    to_come = tuple(
        path.removesuffix("RcxPrescanned")
        for path, _ in new.walk()
        if path.endswith("RcxPrescanned") and not worked.read(path)
    )
    assert "Main.ServoOn.Job." in to_come
    other = [
        path
        for path, kind in new.walk()
        if not re.search(r"\.Timer|\.Temp_|\.FC_\w+_1", path)
        and not path.startswith(to_come)
        and not isinstance(kind, BlockType)
        and worked.read(path) != new.read(path)
    ]
    assert other == []


def _drive(program: Program) -> None:
    """Simulate a robot with CPU_OK and MP RDY ON, whose servos never turn ON."""
    program.write("Main.Connected", True)
    program.write_bytes("Main.InputArea", bytes([0x12]), 32)


_TAGS = {"FirstScan": "RCX_FirstScan", "NoRobot": "RCX_REF", "Robot": "RCX_REF",
         "RobotIn": "SINT 512", "RobotOut": "SINT 512", "RobotEntry": "INT",
         "ReadArea": "FB_ReadArea", "WriteArea": "FB_WriteArea", "ServoOn": "FB_ServoOn",
         "MovePtp": "FB_MovePtp", "MovePulses": "DINT 7", "MoveMm": "REAL 7", "StartButton": "BOOL",
         "CellSafe": "BOOL"}  # fmt: skip


@pytest.mark.exhaustive
def test_the_calls_in_the_docs_are_correct(cell: Path, tmp_path: Path) -> None:
    """The calls in docs/how-to/export.md have the right arguments and pins.

    The calls of GSV and CPS are not checked.
    """
    page = (ROOT / "docs/how-to/export.md").read_text(encoding="utf-8")
    shown = page.partition("```\nRCX_FirstScan(")[2].partition("```")[0]
    lines = [line.partition("//")[0].rstrip() for line in f"RCX_FirstScan({shown}".splitlines()]
    kept = [line for line in lines if not line.startswith(("GSV(", "CPS("))]
    assert len(lines) - len(kept) == 3
    tree = ET.fromstring(cell.read_text())
    program = tree.find(".//Program")
    assert program is not None
    tags, routine = program.find("Tags"), program.find(".//STContent")
    assert tags is not None
    assert routine is not None
    instances = {tag.get("DataType"): tag for tag in tags if tag.find("Data/Structure") is not None}
    tags[:], routine[:] = [], []
    for name, kind in _TAGS.items():
        data, _, size = kind.partition(" ")
        names = {"Name": name, "TagType": "Base", "DataType": data}
        names |= {"Dimensions": size} if size else {}
        tag = ET.SubElement(tags, "Tag", names | {"Constant": "false"})
        tag.extend(instances.get(data, []))
    for number, line in enumerate(kept):
        ET.SubElement(routine, "Line", Number=str(number)).text = line
    file = tmp_path / "docs.L5X"
    file.write_text(ET.tostring(tree, encoding="unicode"))
    assert [str(error) for error in check(source_files([file], None).own)] == []
