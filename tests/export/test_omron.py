"""The library that is rebuilt from the files of `rcx export omron` behaves as the original."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import pytest

from example_runs import EXAMPLES
from exported import recorded, trace_of, written
from exported_dialect import WITH_INITIAL_VALUES, declared, untyped
from mistakes import check
from rcx_harness.cell.exports import export
from structured_text.engines.load import build
from structured_text.export.parts import Sources
from structured_text.language import syntax as s
from structured_text.language.printer import init_text

#: Elementary types of NJ and NX controllers. Source: Omron W501, page 6-32, and W506, 8-7.
_TYPES = {
    *("BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT", "UINT"),
    *("UDINT", "ULINT", "REAL", "LREAL", "TIME", "DATE", "TIME_OF_DAY", "DATE_AND_TIME"),
}
_ARRAY = re.compile(r"ARRAY\[(\d[\d., ]+)\] OF (.+)")
_SECTIONS = {"Input": "VAR_INPUT", "Output": "VAR_OUTPUT", "In/Out": "VAR_IN_OUT"}
#: Names of the library that are instructions in Sysmac Studio, and their new names.
_RENAMED = {name: f"{name}_X" for name in ("Clear", "Next", "Out", "Reset")}


@pytest.fixture(scope="module")
def files(whole: bool) -> Mapping[str, str]:
    """Return the path and the text of each exported file."""
    return written("omron", whole=whole).files


def _lines(text: str) -> list[list[str]]:
    return [line.split("\t") for line in text.splitlines()]


class _Again:
    """Structured Text that is rebuilt from the exported files. Each array type gets a name."""

    def __init__(self, files: Mapping[str, str]) -> None:
        self._files = files
        self._arrays: dict[str, str] = {}

    def text(self) -> str:
        texts = []
        for path in self._files:
            name = Path(path).stem.split(".")[0]
            if path.endswith(".st"):
                texts.append(self._pou(name, path.removesuffix(".st")))
            elif path.endswith((".structure.txt", ".enumeration.txt")):
                texts.append(self._type(name, path, _lines(self._files[path])))
        arrays = (f"TYPE {name} : {spec}; END_TYPE" for spec, name in self._arrays.items())
        return "\n".join([*arrays, *texts])

    def _spec(self, text: str) -> str:
        found = _ARRAY.fullmatch(text)
        if found:
            spec = f"ARRAY [{found[1]}] OF {self._spec(found[2])}"
            return self._arrays.setdefault(spec, f"ARRAY_{len(self._arrays)}")
        return "STRING" if text == "STRING[81]" else text

    def _type(self, name: str, path: str, lines: list[list[str]]) -> str:
        if path.endswith(".enumeration.txt"):
            assert [line[1] for line in lines] == [str(k) for k in range(len(lines))]
            return f"TYPE {name} : ({', '.join(line[0] for line in lines)}); END_TYPE"
        fields = " ".join(f"{line[0]} : {self._spec(line[1])};" for line in lines)
        return f"TYPE {name} : STRUCT {fields} END_STRUCT; END_TYPE"

    def _pou(self, name: str, path: str) -> str:
        body = self._files[f"{path}.st"]
        kind = re.search(rf"(\w+) {name}", body)
        assert kind is not None
        result, parts = "", []
        for line in _lines(self._files.get(f"{path}.inout.txt", "")):
            if line[1] == "Return":
                result = f" : {self._spec(line[2])}"
            else:
                parts.append(f"{_SECTIONS[line[1]]} {self._variable(line[0], line[2], line[4])}")
        for line in _lines(self._files.get(f"{path}.internals.txt", "")):
            constant = " CONSTANT" if line[4] else ""
            parts.append(f"VAR{constant} {self._variable(line[0], line[1], line[2])}")
        return "\n".join([f"{kind[1]} {name}{result}", *parts, body, f"END_{kind[1]}"])

    def _variable(self, name: str, kind: str, initial: str) -> str:
        value = f" := {initial}" if initial else ""
        return f"{name} : {self._spec(kind)}{value};\nEND_VAR"


def test_an_example_runs_with_the_rebuilt_library(files: Mapping[str, str], tmp_path: Path) -> None:
    """An example runs with the rebuilt library, and gives the recorded trace."""
    again = tmp_path / "again.st"
    again.write_text(_Again(files).text(), encoding="utf-8")
    assert [str(error) for error in check([again])] == []
    example = EXAMPLES[0]
    program = [again, example.folder / "Config.st"]
    assert trace_of(example, program, tmp_path) == recorded(example)


def test_the_rebuilt_program_has_the_initial_values_of_the_sources(tmp_path: Path) -> None:
    """Initial values of structures, arrays and named types are the same in the rebuilt program."""
    source, again = tmp_path / "Mine.st", tmp_path / "again.st"
    source.write_text(WITH_INITIAL_VALUES)
    again.write_text(_Again(export("omron", program=[source], only_needed=True).files).text())
    original, back = (build([file], "builtin").program for file in (source, again))
    for scan in range(3):
        sums = []
        for program in (original, back):
            program.scan(scan * 100_000)
            sums.append(program.read("Main.Sum"))
        assert sums[0] == sums[1] != 0
    for path in (
        "It.Total",
        "It.Kept.Low",
        "It.All.Text",
        "It.All.Wait",
        "It.Shown.Top",
        "Old.Tint",
    ):
        assert original.read(f"Main.{path}") == back.read(f"Main.{path}"), path


def test_every_variable_is_in_its_table(sources: Sources, files: Mapping[str, str]) -> None:
    for part in sources.of("FUNCTION", "FUNCTION_BLOCK", "PROGRAM"):
        path = f"{part.folder}/{part.name}"
        rows = {
            line[0]: (line[2], line[4], line[7])
            for line in _lines(files.get(f"{path}.inout.txt", ""))
            if line[1] != "Return"
        } | {
            line[0]: (line[1], line[2], line[5])
            for line in _lines(files.get(f"{path}.internals.txt", ""))
        }
        for name, _, one, note in declared(part):
            kind, initial, said = rows.pop(_RENAMED.get(name, name))
            assert said == note, (part.name, name)
            default = "" if one.initial is None else untyped(init_text(one.initial))
            assert initial.rpartition("#")[2] == default.rpartition("#")[2], (part.name, name)
            if isinstance(one.spec, s.NamedSpec) and one.spec.name.text in _TYPES:
                assert kind == one.spec.name.text, (part.name, name)
        assert rows == {}, part.name


def test_types_are_known_to_the_tool_or_made(files: Mapping[str, str], whole: bool) -> None:
    """Each type in the tables is a type of Sysmac Studio or is exported.

    Source: Omron W501, page 6-32, and W506, 8-7.
    """
    made = {Path(path).stem.split(".")[0] for path in files} | {"TON", "R_TRIG", "STRING[81]"}
    cells = [
        line[2] if path.endswith(".inout.txt") else line[1]
        for path, text in files.items()
        if path.endswith((".inout.txt", ".internals.txt", ".structure.txt"))
        for line in _lines(text)
    ]
    assert len(cells) > (2000 if whole else 200)
    for kind in set(cells):
        found = _ARRAY.fullmatch(kind)
        assert (found[2] if found else kind) in _TYPES | made


def test_text_functions_get_arguments_of_their_types(files: Mapping[str, str]) -> None:
    """Arguments of text functions get their types, and names of instructions are changed.

    Source: Omron W501, 6-3-12: a name of an instruction is refused.
    """
    assert "Letter := MID(Text, 1, INT_TO_UINT(Position));" in files["core/FC_RcxCharCode.st"]
    assert "Place := UINT_TO_INT(FIND('PQR" in files["core/FC_RcxCharCode.st"]
    assert "Reset_X(Robot := Robot," in files["sequence/FB_PowerUp.st"]
    assert "Reset_X\tFB_ProgramReset\t" in files["sequence/FB_PowerUp.internals.txt"]
    assert "RCX_SPEED_MODE#SPEED_DIRECT: Data[1] :=" in files["command/movement/FB_MovePtp.st"]
    assert "Reset is Reset_X" in files["README.txt"]
