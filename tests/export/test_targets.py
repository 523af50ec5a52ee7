"""Exported examples run as the originals, and each target has the whole library."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from example_runs import EXAMPLES
from exported import EXPORTED, example_sources, library, recorded, sample, trace_of, written
from plc_bench import ROOT
from rcx_tools.docs.examples import Example, examples
from structured_text.export import TARGETS
from structured_text.export.output import write

#: Targets whose exports can be read, with the name of the file or folder.
_READ = {"st": "one.st", "plcopen": "one.xml", "twincat": "plc", "scl": "one.scl", "l5x": "one.L5X"}
#: Examples of the quick run: power-up, general-purpose I/O, and texts with arrays of structures.
_QUICK = ("01_power_up", "03_general_io", "06_teach_points")
#: Examples for targets that rewrite statements. Example 09 is missing because it has located
#: variables.
_ALL = [one for one in EXAMPLES if one.name[:2] != "09"]
_CASES = [(target, one.name) for target in _READ for one in (_ALL if target == "l5x" else EXPORTED)]

_LIB = ROOT / "plc/lib"
#: In SCL, a program is exported as a block, and an OB calls this block.
_OB = """\
DATA_BLOCK "Main"
{{ S7_Optimized_Access := 'TRUE' }}
VERSION : 0.1
NON_RETAIN
"{program}"
BEGIN
END_DATA_BLOCK

ORGANIZATION_BLOCK "Cycle"
BEGIN
	"Main"();
END_ORGANIZATION_BLOCK
"""


def _files(target: str, example: Example, folder: Path) -> list[Path]:
    """Export an example, and return the files to run it. A task that is not exported is added."""
    output = TARGETS[target].write(example_sources(example.name))
    write(replace(output, recorded=True), folder / _READ[target])
    files = [folder / _READ[target]]
    if target in ("twincat", "l5x"):
        files.append(example.folder / "Config.st")
    elif target == "scl":
        (program,) = re.findall(r"PROGRAM (\w+): written as FUNCTION_BLOCK", "".join(output.notes))
        own, task = folder / "cycle.scl", folder / "Task.st"
        own.write_text(_OB.format(program=program), encoding="utf-8")
        text = (example.folder / "Config.st").read_text(encoding="utf-8")
        text = re.sub(r"PROGRAM Main (WITH \w+) : \w+;", r"PROGRAM Cycle \1 : Cycle;", text)
        task.write_text(text, encoding="utf-8")
        files += [own, task]
    return files


@pytest.mark.exhaustive(but=[f"{target}-{name}" for target in _READ for name in _QUICK])
@pytest.mark.parametrize(("target", "name"), _CASES, ids=lambda one: one)
def test_an_exported_example_gives_the_recorded_trace(
    target: str, name: str, tmp_path: Path
) -> None:
    """The engine runs the exported example without the library, and the trace is the recorded one.

    Source: docs/how-to/export.md.
    """
    example = examples()[name]
    files = _files(target, example, tmp_path)
    assert trace_of(example, files, tmp_path) == recorded(example)


@pytest.mark.exhaustive(but=["l5x"])
@pytest.mark.parametrize("target", TARGETS)
def test_an_export_is_the_same_every_time(target: str) -> None:
    """Two exports are equal, including the identifiers of TwinCAT and the dates of L5X.

    Source: docs/how-to/export.md: a second export does not change a file.
    """
    assert TARGETS[target].write(sample()) == written(target)


@pytest.mark.exhaustive
@pytest.mark.parametrize("target", TARGETS)
def test_the_library_is_exported_completely(target: str) -> None:
    """Every part of the library is exported.

    If a tool has no BYTE, blocks for words replace others.
    """
    assert {one.name for one in library().parts} == {file.stem for file in _LIB.rglob("*.st")}
    output = TARGETS[target].write(library())
    assert all(one.replaced for one in output.missing), output.missing
    words = target in ("mitsubishi", "keyence")
    names = {one.what.split()[1] for one in output.missing}
    assert names == (_BYTES if words else set())
    for name in names - {"RCX_IMAGE"}:
        assert any(f"/{_IN_WORDS.get(name, name + 'InWords')}.st" in path for path in output.files)


_BYTES = {
    *("RCX_IMAGE", "FB_ReadArea", "FB_WriteArea", "FB_RealTimeValue", "FB_ProgramCall"),
    *(f"FB_{way}{what}" for way in ("Read", "Write") for what in ("Bit", "Port", "Word")),
    *("FB_ReadDoubleWord", "FB_WriteDoubleWord"),
}
_IN_WORDS = {one: f"{one}Words" for one in ("FB_ReadArea", "FB_WriteArea")}


@pytest.mark.parametrize("target", TARGETS)
def test_a_part_that_is_not_carried_is_named(target: str) -> None:
    """Only the task and blocks with an array of BYTE are left out.

    In the tool, the user makes the task and calls the blocks for words.

    Source: docs/how-to/export.md.
    """
    why = {one.what.split()[1]: one.why for one in written(target).missing}
    lost = set(why)
    bytes_only = {"RCX_IMAGE", "FB_ReadArea", "FB_WriteArea", "PowerUp"}
    wanted = {"Config0"} if target not in ("st", "plcopen") else set()
    wanted |= bytes_only if target in ("mitsubishi", "keyence") else set()
    assert lost == wanted
    for name in lost & bytes_only:
        assert why[name] == "has an array of BYTE; take the block for words"
    assert not lost & {Path(path).name.partition(".")[0] for path in written(target).files}
