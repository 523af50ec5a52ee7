"""`rcx export twincat` writes a project whose objects a parser for TwinCAT accepts."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from blark.parse import parse

from exported import by_position, imported, shapes, written
from structured_text.export.output import write
from structured_text.export.parts import Sources

#: One object of each kind; the exhaustive test parses every object, which takes minutes.
_QUICK_OBJECTS = ("RCX_PHASE", "RCX_CHANNEL", "RCX_WORDS", "FC_RcxAreaError", "FB_Sample")
_MSBUILD = "{http://schemas.microsoft.com/developer/msbuild/2003}"


@pytest.fixture(scope="module")
def folder(whole: bool, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the exported sample."""
    place = tmp_path_factory.mktemp("twincat")
    write(written("twincat", whole=whole), place)
    return place


def _objects(folder: Path) -> list[Path]:
    return sorted((folder / "RCX3").rglob("*.Tc*"))


def _errors(file: Path) -> list[str]:
    results = list(parse(file))
    assert results
    return [str(result.exception) for result in results if result.exception]


def test_blark_parses_the_objects(folder: Path) -> None:
    """The parser blark, which knows Beckhoff's dialect, accepts one object of each kind."""
    files = [file for file in _objects(folder) if file.stem in _QUICK_OBJECTS]
    assert len(files) == len(_QUICK_OBJECTS)
    for file in files:
        assert _errors(file) == [], file.name


@pytest.mark.exhaustive
def test_blark_parses_every_object(folder: Path) -> None:
    """The parser blark, which knows Beckhoff's dialect, accepts all exported objects."""
    for file in _objects(folder):
        assert _errors(file) == [], file.name


def test_the_library_is_imported_from_the_project(
    folder: Path, sources: Sources, tmp_path: Path
) -> None:
    """The imported project has the blocks of the sources, each in a file with its name.

    A CONFIGURATION is not exported.
    """
    for file in _objects(folder):
        (element,) = ET.parse(file).getroot()
        assert element.attrib["Name"] == file.stem
    parts = [part for part in sources.parts if part.kind != "CONFIGURATION"]
    wanted = shapes(dict.fromkeys(part.file for part in parts))
    assert shapes(imported(folder, tmp_path)) == by_position(wanted)


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


def test_identifiers_differ(whole: bool) -> None:
    files = written("twincat", whole=whole).files
    found = [re.findall(r'Id="\{([-0-9a-f]{36})\}"', text) for text in files.values()]
    identifiers = [one[0] for one in found if one]
    assert len(set(identifiers)) == len(files) - 1


def test_lines_end_as_on_windows(folder: Path) -> None:
    data = (folder / "RCX3/core/FB_RcxJob.TcPOU").read_bytes()
    assert data.count(b"\r\n") == data.count(b"\n") > 0
