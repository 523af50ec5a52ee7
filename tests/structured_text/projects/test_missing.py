"""A missing library gives one message, and its interfaces are inferred from their use."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.errors import COMMAND
from structured_text.language.load import analyse
from structured_text.language.source import source_text
from structured_text.projects.missing import by_library, libraries_of, simple_type
from structured_text.projects.sources import SourceFiles, source_files
from structured_text.projects.stubs.write import infer_stubs
from twincat_projects import written_project

_FORMAT = "FB" + "_FormatString"
_TIME = "FB" + "_LocalSystemTime"


def _program(variables: str, statements: str) -> str:
    return f"PROGRAM MAIN\nVAR\n{variables}\nEND_VAR\n---\n{statements}\n"


def _said(files: SourceFiles) -> list[str]:
    _, errors = analyse(files.all)
    return [one.message for one in by_library(errors, files.missing, files.declared)]


def test_a_library_that_is_not_read_is_one_message(tmp_path: Path) -> None:
    """The program uses two names of the missing library Tc2_Utilities in three places.

    This gives one message, and the program's own error is reported, too.

    Source: Beckhoff Information System, PLC Library Tc2_Utilities: both blocks.
    """
    variables = f"  a, b : {_FORMAT};\n  c : {_FORMAT};\n  d : {_TIME};\n  n : INT;"
    uses = {"Tc2_Utilities": "Tc2_Utilities"}
    objects = {"MAIN.TcPOU": _program(variables, "a();\nd(bEnable := TRUE);\nn := m;")}
    files = source_files(written_project(tmp_path / "P", objects, libraries=uses), None)
    _, errors = analyse(files.all)
    grouped = by_library(errors, files.missing, files.declared)
    assert [one.message for one in grouped] == [
        f"the library Tc2_Utilities is not read: 3 places miss {_FORMAT} (2), {_TIME} (1)",
        "m is not declared",
    ]
    assert (Path(grouped[0].file or "").name, grouped[0].line) == ("MAIN.TcPOU", 3)
    assert f"{COMMAND} check --stubs DIR" in grouped[0].hint


@pytest.mark.parametrize(
    ("libraries", "said"),
    [
        ({"Valves": "Valves"}, "the library Valves is not read: 1 place misses Valve (1)"),
        (
            {"Valves": "V", "Pumps": "P", "Tc2_Utilities": "U"},
            "none of the libraries Valves or Pumps is read: 1 place misses Valve (1)",
        ),
        ({}, "there is no type Valve"),
    ],
)
def test_an_unknown_name_may_be_of_an_unknown_library(
    libraries: dict[str, str], said: str, tmp_path: Path
) -> None:
    """An unknown name may be from a missing library if the project refers to libraries.

    Otherwise the message assumes a misspelled name.

    Source: docs/how-to/projects.md.
    """
    objects = {"MAIN.TcPOU": _program("  a : Valve;", ";")}
    project = written_project(tmp_path / "P", objects, libraries=libraries)
    assert _said(source_files(project, None)) == [said]


def test_a_namespace_names_its_library(tmp_path: Path) -> None:
    """The message about a missing name gives the library of its namespace.

    Source: Beckhoff Information System, TwinCAT 3 PLC: library reference, Namespace.
    """
    objects = {"MAIN.TcPOU": _program("  a, b : Vlv.Valve;\n  c : Vlv.Pump;", ";")}
    libraries = {"Valves and Pumps": "Vlv", "Others": "O"}
    project = written_project(tmp_path / "P", objects, libraries=libraries)
    said = "the library Valves and Pumps is not read: 2 places miss Vlv (2)"
    assert _said(source_files(project, None)) == [said]


def test_a_name_that_the_project_declares_is_not_missing(tmp_path: Path) -> None:
    """A name whose declaration has an error is not treated as missing.

    Source: docs/how-to/projects.md.
    """
    objects = {
        "Valve.TcDUT": "TYPE Valve : STRUCT\n  a : ;\nEND_STRUCT END_TYPE",
        "MAIN.TcPOU": _program("  a : Valve;", ";"),
    }
    project = written_project(tmp_path / "P", objects, libraries={"Valves": "V"})
    assert not any("the library" in text for text in _said(source_files(project, None)))


def test_the_libraries_of_some_names_are_known() -> None:
    """`libraries_of` returns the libraries that contain a well-known name.

    Source: Beckhoff Information System and CODESYS help: the contents of the libraries.
    """
    assert libraries_of("MC_Power") == ["Tc2_MC2", "SM3_Basic"]
    assert libraries_of("AXIS_REF") == ["Tc2_MC2"]
    assert libraries_of("BLINK") == ["Util"]
    assert libraries_of(f"Tc2_Utilities.{_FORMAT}") == ["Tc2_Utilities"]
    assert libraries_of("TON") == []
    assert simple_type("T_MaxString") == "STRING(255)"
    assert simple_type("Valve") == ""


def test_an_export_of_codesys_names_its_libraries(tmp_path: Path) -> None:
    """The libraries of a CODESYS export are known by name.

    There are no notes about them, because CODESYS adds many.

    Source: an export of CODESYS: the element Libraries of an application.
    """
    file = tmp_path / "a.xml"
    file.write_text(
        '<project><pou name="P" pouType="program"><interface><localVars><variable name="a"><type>'
        '<derived name="Vlv.Valve"/></type></variable></localVars></interface><body><ST>;</ST>'
        '</body></pou><addData><data name="libraries"><Libraries>'
        '<Library Name="#Valves" Namespace="Vlv" DefaultResolution="My Valves, * (Someone)"/>'
        '<Library Name="#IecSfc" Namespace="Vlv2" SystemLibrary="true"/>'
        "</Libraries></data></addData></project>",
        encoding="utf-8",
    )
    files = source_files(file, None)
    assert files.notes == ()
    assert [(one.name, one.namespace) for one in files.missing] == [("My Valves", "Vlv")]
    assert _said(files) == ["the library My Valves is not read: 1 place misses Vlv (1)"]


def test_many_unread_libraries_are_counted(tmp_path: Path) -> None:
    """If no library is read, the message gives their number instead of their names.

    Source: docs/how-to/projects.md.
    """
    libraries = {f"Lib{number}": f"L{number}" for number in range(12)}
    objects = {"MAIN.TcPOU": _program("  a : Valve;", ";")}
    files = source_files(written_project(tmp_path / "P", objects, libraries=libraries), None)
    said = "none of the 12 libraries that the project refers to is read: 1 place misses Valve (1)"
    assert _said(files) == [said]


def test_the_use_of_a_variable_of_a_missing_type_is_not_another_error(tmp_path: Path) -> None:
    """A variable with a missing type gives one error.

    Its calls, methods and members give no further errors.

    Source: docs/how-to/projects.md.
    """
    objects = {
        "GVL.TcGVL": "VAR_GLOBAL\n  v : Valve;\nEND_VAR",
        "MAIN.TcPOU": _program(
            "  a : Valve;\n  n : INT;",
            "a();\na.Open();\nn := a.Count;\nGVL.v();\nGVL.v.Open();\nn := GVL.v.Count;",
        ),
    }
    project = written_project(tmp_path / "P", objects, libraries={"Valves": "V"})
    said = "the library Valves is not read: 2 places miss Valve (2)"
    assert _said(source_files(project, None)) == [said]


# --- stubs ------------------------------------------------------------------------------------


def _stubs(folder: Path, objects: dict[str, str], libraries: dict[str, str]) -> dict[str, str]:
    """Infer the interfaces, check the project with them, and return their texts without headers."""
    project = written_project(folder / "P", objects, libraries=libraries)
    files = source_files(project, None)
    found = infer_stubs(files.all, files.missing, files.declared)
    assert [str(one) for one in found.errors] == []
    (folder / "stubs").mkdir()
    for name, text in found.texts.items():
        (folder / "stubs" / name).write_text(text, encoding="utf-8")
    _, errors = analyse(source_files([project, folder / "stubs"], None).all)
    assert [str(one) for one in errors] == []
    return {name: text.partition("*)\n")[2] for name, text in found.texts.items()}


def test_a_block_has_the_pins_that_the_program_uses(tmp_path: Path) -> None:
    """The inferred block has the pins that the program uses.

    Types come from arguments and from targets of outputs.

    Source: docs/how-to/projects.md.
    """
    variables = "  v : Valve;\n  n : INT;\n  k : DINT;\n  r : REAL;\n  t : TIME;\n  s : STRING(10);"
    statements = (
        "v(Open := n > 3, Level := n, Delay := t, Name := s, Position => r);\nv(Level := k);\n"
        "IF v.Ready AND NOT v.Fault THEN n := v.Count; END_IF\nv.Reset := TRUE;"
    )
    objects = {"MAIN.TcPOU": _program(variables, statements)}
    assert _stubs(tmp_path, objects, {"Valves": "Valves"}) == {
        "Valve.st": """\
FUNCTION_BLOCK Valve
VAR_INPUT
  Open : BOOL;
  Level : DINT;
  Delay : TIME;
  Name : STRING(255);
  Reset : BOOL;
END_VAR
VAR_OUTPUT
  Position : REAL;
  Ready : BOOL;
  Fault : BOOL;
  Count : INT;
END_VAR
END_FUNCTION_BLOCK
"""
    }


def test_structures_enumerations_functions_and_lists_are_told_apart(tmp_path: Path) -> None:
    """The use of unknown names shows their kinds: structure, enumeration, function or list.

    Source: docs/how-to/projects.md.
    """
    variables = "  p : ST_Point;\n  q : ARRAY[1..2] OF ST_Point;\n  m : E_Mode;\n  x : LREAL;"
    variables += "\n  n : INT;\n  name : T_MaxString;"
    statements = (
        "p.x := x;\nq[1].y := 2.5;\nn := p.Number;\nm := E_Mode.Slow;\n"
        "IF m = E_Mode.Off THEN x := Distance(p, q[2], Limit := x); END_IF\n"
        "x := GVL_Limits.Highest;\nn := MAX_VALVES;\nname := 'a';"
    )
    objects = {"MAIN.TcPOU": _program(variables, statements)}
    texts = _stubs(tmp_path, objects, {"Valves": "Valves"})
    assert texts["ST_Point.st"].split() == [
        *("TYPE", "ST_Point", ":", "STRUCT", "x", ":", "LREAL;", "y", ":", "LREAL;"),
        *("Number", ":", "INT;", "END_STRUCT;", "END_TYPE"),
    ]
    assert texts["E_Mode.st"] == "TYPE E_Mode : (Slow, Off); END_TYPE\n"
    assert texts["Distance.st"].splitlines()[:5] == [
        "FUNCTION Distance : LREAL",
        "VAR_INPUT",
        "  P1 : ST_Point;",
        "  P2 : ST_Point;",
        "  Limit : LREAL;",
    ]
    assert "  Highest : LREAL;" in texts["GVL_Limits.st"].splitlines()
    assert texts["T_MaxString.st"] == "TYPE T_MaxString : STRING(255); END_TYPE\n"
    assert "  MAX_VALVES : INT := " in texts["Missing_Constants.st"]


def test_a_base_block_has_what_the_derived_block_takes_from_it(tmp_path: Path) -> None:
    """The inferred base block gets the methods and variables that the derived block uses.

    Source: docs/how-to/projects.md.
    """
    suite = (
        "FUNCTION_BLOCK Suite EXTENDS Base IMPLEMENTS I_Suite\nVAR\n  n : INT;\nEND_VAR\n---\n"
        "Begin('first');\nCheck(n, 3, Text := 'equal');\nIF Finished(Strict := TRUE) THEN\n"
        "  n := bCount;\nEND_IF\nSUPER^();\n"
    )
    main = _program("  s : Suite;\n  i : I_Suite;", "s();\ni := s;\nIF i.Ready() THEN s(); END_IF")
    objects = {"Suite.TcPOU": suite, "MAIN.TcPOU": main}
    project = written_project(tmp_path / "P", objects, libraries={"Valves": "Valves"})
    files = source_files(project, None)
    texts = infer_stubs(files.all, files.missing, files.declared).texts
    lines = texts["Base.st"].splitlines()[2:]
    assert lines[0] == "FUNCTION_BLOCK Base"
    assert "METHOD Finished : BOOL" in lines
    assert "METHOD Begin" in lines
    start = lines.index("METHOD Check")
    assert lines[start + 2 : start + 5] == ["  P1 : INT;", "  P2 : DINT;", "  Text : STRING(255);"]
    assert "  bCount : INT;" in lines
    assert texts["I_Suite.st"].splitlines()[2:4] == ["INTERFACE I_Suite", "METHOD Ready : BOOL"]


def test_members_arrays_and_pointers_of_a_library_have_types(tmp_path: Path) -> None:
    """`Vlv.Mode.Slow` is an enumeration value.

    Elements and pointers have the types that the use shows.

    Source: docs/how-to/projects.md.
    """
    variables = "  v : Vlv.Valve;\n  m : Vlv.E_Mode;\n  n : INT;\n  x : REAL;"
    statements = (
        "m := Vlv.E_Mode.Slow;\nv(Mode := Vlv.E_Mode.Fast);\nn := v.Rows[2];\nx := v.Place^;\n"
        "CASE m OF\n  Vlv.E_Mode.Slow: n := 1;\nEND_CASE"
    )
    objects = {"MAIN.TcPOU": _program(variables, statements)}
    texts = _stubs(tmp_path, objects, {"Valves": "Vlv"})
    lines = texts["Valve.st"].splitlines()
    assert "  Rows : ARRAY [0..255] OF INT;" in lines
    assert "  Place : POINTER TO REAL;" in lines
    assert "  Mode : E_Mode;" in lines
    assert texts["E_Mode.st"] == "TYPE E_Mode : (Slow, Fast); END_TYPE\n"


def test_a_namespace_of_a_library_is_declared(tmp_path: Path) -> None:
    """The inferred interfaces include the namespace of the library.

    Source: docs/how-to/projects.md.
    """
    variables = "  v : Vlv.Valve;\n  n : INT;"
    objects = {"MAIN.TcPOU": _program(variables, "v(Open := TRUE);\nn := v.Count;")}
    texts = _stubs(tmp_path, objects, {"Valves": "Vlv"})
    assert sorted(texts) == ["Valve.st", "Vlv.st"]


def test_an_input_that_gets_values_of_several_types_is_an_any(tmp_path: Path) -> None:
    """An input with values of several types gets a type that takes them all, else ANY.

    For INT and REAL the type is LREAL.

    Source: docs/how-to/projects.md.
    """
    variables = "  r : REAL; i : INT; s : STRING; a : ARRAY[1..2] OF BYTE; v : Valve; ok : BOOL;"
    statements = (
        "ok := Send(r); ok := Send(s); ok := Send(a);\nok := Wide(r); ok := Wide(i);\n"
        "v(Item := s, Open := ok); v(Item := i);"
    )
    objects = {"MAIN.TcPOU": _program(variables, statements)}
    texts = _stubs(tmp_path, objects, {"Valves": "Vlv"})
    assert "P1 : ANY;" in texts["Send.st"]
    assert "P1 : LREAL;" in texts["Wide.st"]
    assert "Item : ANY;" in texts["Valve.st"]
    assert "Open : BOOL;" in texts["Valve.st"]


def test_arguments_of_declarations_and_constants_of_lists_are_inferred(tmp_path: Path) -> None:
    """Arguments of FB_Init, and constants of lists, are inferred from declarations.

    The block is in the VAR_INST of a method.

    Source: CODESYS help, method FB_Init: its parameters, and VAR_INST.
    """
    start = "FB" + "_init"
    objects = {
        "Filter.TcPOU": "FUNCTION_BLOCK Filter\nVAR\n  top : LREAL := Vlv.Limits.Top;\n"
        "END_VAR\n---\nMETHOD Run\nVAR_INST\n  v : Vlv.Valve(0, 'a');\nEND_VAR\n"
        "v.Open := TRUE;\nEND_METHOD\ntop := top + 1.0;\n",
        "MAIN.TcPOU": _program("  f : Filter;", "f();"),
    }
    texts = _stubs(tmp_path, objects, {"Valves": "Vlv"})
    assert f"METHOD {start} : BOOL" in texts["Valve.st"]
    assert "Argument1 : DINT;\n  Argument2 : STRING(255);" in texts["Valve.st"]
    assert "Open : BOOL;" in texts["Valve.st"]
    assert "Top : LREAL;" in texts["Limits.st"]


def test_members_and_fields_are_inferred_from_initial_values_of_arrays(tmp_path: Path) -> None:
    """The initial values of an array show the fields of an unknown structure.

    Source: CODESYS help, array initialisation; docs/how-to/projects.md.
    """
    variables = (
        "  kinds : ARRAY[0..1] OF Kind := [Kind.None, Kind.Some];\n"
        "  table : ARRAY[0..1] OF Entry := [(Name := 'a', Number := 1), (Name := 'b')];"
    )
    objects = {"MAIN.TcPOU": _program(variables, ";")}
    texts = _stubs(tmp_path, objects, {"Valves": "Vlv"})
    assert "TYPE Kind : (None, Some); END_TYPE" in texts["Kind.st"]
    assert "  Name : STRING(255);\n  Number : DINT;" in texts["Entry.st"]


def test_nothing_is_inferred_if_nothing_is_missing(tmp_path: Path) -> None:
    """A mistake of the user is not treated as a missing library.

    Source: docs/how-to/projects.md.
    """
    objects = {"MAIN.TcPOU": _program("  n : INT;", "n := Sped;\nm := 1;")}
    files = source_files(written_project(tmp_path / "P", objects), None)
    found = infer_stubs(files.all, files.missing, files.declared)
    assert found.texts == {}
    assert len(found.errors) == 2


def test_stubs_are_sources_that_can_be_read(tmp_path: Path) -> None:
    """The written stubs are sources that can be compiled.

    Their header is a comment that names the command.

    Source: docs/how-to/projects.md.
    """
    objects = {"MAIN.TcPOU": _program("  v : Valve;", "v();")}
    project = written_project(tmp_path / "P", objects, libraries={"Valves": "V"})
    files = source_files(project, None)
    (text,) = infer_stubs(files.all, files.missing, files.declared).texts.values()
    file = tmp_path / "Valve.st"
    file.write_text(text, encoding="utf-8")
    assert source_text(file).startswith("(* An interface without statements")
    assert f"`{COMMAND} check --stubs`" in text
