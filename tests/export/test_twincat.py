"""`rcx export twincat`: objects that a parser of TwinCAT's files takes, all in the project."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from blark.parse import parse

from example_runs import EXAMPLES
from exported import by_position, shapes
from plc_bench import ROOT
from rcx_harness.cell.exports import export
from structured_text.export.output import write
from structured_text.output.exported import RECORD
from structured_text.projects.needed import needed as engine_needed

LIB = sorted((ROOT / "plc/lib").rglob("*.st"))
CELL = sorted(EXAMPLES[0].folder.glob("*.st"))

#: One object of each kind; the exhaustive test parses every object, which takes minutes.
_SOME = ("RCX_PHASE", "RCX_CHANNEL", "RCX_WORDS", "FC_RcxAreaError", "FB_RcxJob", "FB_ReadArea")
_MSBUILD = "{http://schemas.microsoft.com/developer/msbuild/2003}"


@pytest.fixture(scope="module")
def folder(needed: bool, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The library and the first example."""
    place = tmp_path_factory.mktemp("twincat")
    write(export("twincat", program=[EXAMPLES[0].folder], only_needed=needed), place)
    return place


def _objects(folder: Path) -> list[Path]:
    return sorted((folder / "RCX3").rglob("*.Tc*"))


def _errors(file: Path) -> list[str]:
    results = list(parse(file))
    assert results
    return [str(result.exception) for result in results if result.exception]


def test_blark_parses_the_objects(folder: Path) -> None:
    """Read by a parser of Beckhoff's dialect and file formats, blark."""
    files = [file for file in _objects(folder) if file.stem in (*_SOME, "PowerUp")]
    assert len(files) == len(_SOME) + 1
    for file in files:
        assert _errors(file) == [], file.name


@pytest.mark.exhaustive
def test_blark_parses_every_object(folder: Path) -> None:
    """Read by a parser of Beckhoff's dialect and file formats, blark."""
    for file in _objects(folder):
        assert _errors(file) == [], file.name


@pytest.mark.parametrize(
    ("old", "new"), [("END_VAR", "END_VARS"), (" := ", " := NOT := "), ("END_IF", "END_IFS")]
)
def test_blark_refuses_what_is_wrong(folder: Path, tmp_path: Path, old: str, new: str) -> None:
    wrong = tmp_path / "wrong.TcPOU"
    text = (folder / "RCX3/core/FC_RcxAreaError.TcPOU").read_text()
    assert old in text
    wrong.write_text(text.replace(old, new))
    assert _errors(wrong)


def test_put_together_again_the_objects_are_the_library(
    folder: Path, needed: bool, tmp_path: Path
) -> None:
    sources = []
    for file in sorted((folder / "RCX3").rglob("*.Tc*")):
        (element,) = ET.parse(file).getroot()
        assert element.attrib["Name"] == file.stem
        text = element.findtext("Declaration") or ""
        if element.tag == "POU":
            kind = re.search(r"^(FUNCTION_BLOCK|FUNCTION|PROGRAM)\b", text, re.MULTILINE)
            assert kind
            text += f"{element.findtext('Implementation/ST')}\nEND_{kind[1]}\n"
        source = tmp_path / f"{file.stem}.st"
        source.write_text(text.replace("END_STRUCT\n", "END_STRUCT;\n"))
        sources.append(source)
    library = engine_needed(CELL, LIB) if needed else LIB
    wanted = shapes([*library, *(one for one in CELL if one.stem != "Config")])
    assert shapes(sources) == by_position(wanted)


def test_the_project_names_every_object_its_folders_and_the_standard_library(folder: Path) -> None:
    root = ET.parse(folder / "RCX3.plcproj").getroot()
    named = {one.attrib["Include"].replace("\\", "/") for one in root.iter(f"{_MSBUILD}Compile")}
    files = [file.relative_to(folder) for file in (folder / "RCX3").rglob("*.Tc*")]
    assert named == {file.as_posix() for file in files}
    folders = {one.attrib["Include"].replace("\\", "/") for one in root.iter(f"{_MSBUILD}Folder")}
    above = {one for file in files for one in file.parents} - {Path()}
    assert folders == {one.as_posix() for one in above}
    (library,) = root.iter(f"{_MSBUILD}PlaceholderReference")
    assert library.attrib["Include"] == "Tc2_Standard"


def test_identifiers_differ_and_are_the_same_every_time(folder: Path, needed: bool) -> None:
    output = export("twincat", program=[EXAMPLES[0].folder], only_needed=needed)
    written = {
        file.relative_to(folder).as_posix(): file.read_text()
        for file in folder.rglob("*")
        if file.is_file() and file.name != RECORD
    }
    assert output.files == written
    found = [re.findall(r'Id="\{([-0-9a-f]{36})\}"', text) for text in output.files.values()]
    identifiers = [one[0] for one in found if one]
    assert len(set(identifiers)) == len(output.files) - 1


def test_what_is_not_carried_is_named() -> None:
    output = export("twincat", program=[EXAMPLES[0].folder], only_needed=True)
    assert [line.partition(":")[0] for line in output.left_out] == ["CONFIGURATION Config0"]
    assert not any("Config0" in path for path in output.files)


def test_lines_end_as_on_windows(folder: Path) -> None:
    data = (folder / "RCX3/core/FB_RcxJob.TcPOU").read_bytes()
    assert data.count(b"\r\n") == data.count(b"\n") > 0
