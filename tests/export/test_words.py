"""Each export uses only functions and blocks that are in the list of its tool."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest

from example_runs import EXAMPLES
from exported import example_sources, sample, written
from rcx_harness.cell.exports import export
from rcx_tools.docs.words import entry_sources
from structured_text.engines.base import Program
from structured_text.engines.load import build
from structured_text.errors import InputError
from structured_text.export import TARGETS
from structured_text.export.parts import Sources
from structured_text.export.words import FOLDER, unwritten, words
from structured_text.language import standard
from structured_text.language.scalars import ELEMENTARY

#: Functions and blocks of edition 2 of the standard. Those of later editions are rejected.
FUNCTIONS, BLOCKS = (
    {key: one for key, one in every.items() if standard.reserved(key)}
    for every in (dict[str, Any](standard.FUNCTIONS), dict[str, Any](standard.BLOCKS))
)

#: Maps each target to the list of names of its tool.
_LISTS = {
    **{one: one for one in ("twincat", "scl", "omron", "mitsubishi", "keyence")},
    "st": "iec",
    "plcopen": "iec",
    "l5x": "logix",
}
_VARIABLES = "b, c : BOOL; i, j : INT; w : WORD; x : REAL; t : TIME; a : STRING;"
_ARGUMENTS = {"BOOL": "b", "STRING": "a", "TIME": "t", "ANY_INT": "j", "ANY_NUM": "j"}


def _argument(kind: str, group: tuple[str, ...]) -> str:
    if kind != "T":
        return _ARGUMENTS[kind]
    found = {"INT": "i", "REAL": "x", "WORD": "w", "TIME": "t", "STRING": "a"}
    return next(name for one, name in found.items() if one in group)


def _function(key: str) -> str:
    signature = FUNCTIONS[key]
    given = [_argument(kind, signature.group) for _, kind in signature.pins]
    own = _argument("T", signature.group) if signature.group else "t"
    target = {"T": own, "BOOL": "b", "ANY_INT": "i", "STRING": "a", "TIME": "t"}[signature.result]
    return _block(key, "", f"{target} := {key}({', '.join(given)});")


def _block(name: str, variables: str, statements: str) -> str:
    return (
        f"FUNCTION_BLOCK FB_{name}\n  VAR\n    {_VARIABLES} {variables}\n  END_VAR\n"
        f"  {statements}\nEND_FUNCTION_BLOCK\n"
    )


def _instance(key: str) -> str:
    (first, *_) = (pin for pin in BLOCKS[key].variables if pin.section == "VAR_INPUT")
    return _block(key, f"One : {key};", f"One({first.name} := b);")


def _exported(target: str, folder: Path, text: str) -> tuple[Mapping[str, str], tuple[str, ...]]:
    source = folder / "All.st"
    source.write_text(text)
    output = export(target, program=[source], only_needed=True)
    return output.files, tuple(map(str, output.missing))


def _body(target: str, files: Mapping[str, str], name: str) -> str:
    """Return the exported statements of a block, or "" if the block is not exported."""
    if target in ("st", "scl", "plcopen", "l5x"):
        text = files[""]
    else:
        endings = (f"/{name}.st", f"/{name}.TcPOU")
        text = next((text for path, text in files.items() if path.endswith(endings)), "")
    if target == "st":
        found = re.search(
            rf"^FUNCTION(?:_BLOCK)? {name}\b(.*?)END_FUNCTION", text, re.DOTALL | re.M
        )
        return found[1] if found else ""
    if target == "scl":
        found = re.search(rf'N(?:_BLOCK)? "{name}".*?\nBEGIN\n(.*?)END_FUNCTION', text, re.DOTALL)
        return found[1] if found else ""
    if target == "plcopen":
        (pou,) = _root(text).iterfind(f".//{{*}}pou[@name='{name}']")
        return pou.findtext(".//{*}ST/{*}p") or ""
    if target == "l5x":
        path = f".//AddOnInstructionDefinition[@Name='{name}']/Routines/Routine[@Name='Logic']"
        lines = _root(text).iterfind(f"{path}/STContent/Line")
        return "\n".join((one.text or "").strip() for one in lines)
    if target == "twincat":
        return ET.fromstring(text.encode()).findtext("POU/Implementation/ST") or "" if text else ""
    return text.partition(" *)\n")[2]


@cache
def _root(text: str) -> ET.Element:
    return ET.fromstring(text)


def _called(body: str) -> set[str]:
    """Return the names of all called functions and blocks, without keywords and conversions."""
    plain = re.sub(r"'(?:\$.|[^$'])*'|\(\*.*?\*\)", " ", body, flags=re.DOTALL)
    names = re.findall(r'(?<![\w.#"])([A-Za-z_]\w*)\s*\(', plain)
    conversions = tuple(f"{one}_TO_" for one in ELEMENTARY)
    return {name for name in names if name not in _KEYWORDS and not name.startswith(conversions)}


_KEYWORDS = ("IF", "ELSIF", "WHILE", "UNTIL", "CASE", "NOT", "AND", "OR", "XOR", "MOD", "TO", "OF")


@cache
def _listed(target: str) -> set[str]:
    """Return the names of the functions and instructions in the list of the target's tool."""
    found = words(_LISTS[target])
    forms = (*found.functions.values(), *found.instructions.values())
    return {one.name for one in forms if not one.is_operator}


@pytest.mark.parametrize("target", TARGETS)
def test_each_standard_name_is_listed_or_refused(target: str, tmp_path: Path) -> None:
    """Each standard function or block is in the tool's list, or is rejected with its line."""
    texts = {
        **{key: _function(key) for key in FUNCTIONS},
        **{key: _instance(key) for key in BLOCKS},
    }
    files, left_out = _exported(target, tmp_path, "".join(texts.values()))
    refused = {line.split()[2].removeprefix("FB_").rstrip(":"): line for line in left_out}
    found = words(_LISTS[target])
    for place, key in enumerate(texts):
        known = key in found.functions or key in found.blocks
        body = _body(target, files, f"FB_{key}") if known else ""
        if key in refused:
            assert not known, key
            at = 6 * place + (5 if key in FUNCTIONS else 3)
            said = f"{tmp_path / 'All.st'}:{at}: FUNCTION_BLOCK FB_{key}: {key} is not on the list "
            assert re.fullmatch(rf"{re.escape(said)}for .+; .+", refused[key]), refused[key]
        else:
            assert known, key
            assert body.strip(), key
            instances = {"One", *(one.name for one in found.blocks.values())}
            assert _called(body) <= _listed(target) | instances, key


@pytest.mark.parametrize("target", TARGETS)
def test_later_functions_and_blocks_are_refused_by_name(target: str, tmp_path: Path) -> None:
    """Functions and blocks of later editions are rejected with file and line.

    Nothing is written.
    """
    texts = (
        ("ATAN2", 5, _block("A", "", "x := ATAN2(x, x);")),
        ("TON_TIME", 3, _block("B", "One : TON_TIME;", "One(IN := b);")),
    )
    for key, line, text in texts:
        with pytest.raises(InputError, match=rf"All.st:{line}:\d+: .* edition \({key}\); use "):
            _exported(target, tmp_path, text)


@pytest.mark.parametrize("name", sorted(file.stem for file in FOLDER.glob("*.toml")))
def test_every_entry_of_a_list_has_a_source(name: str) -> None:
    """Each entry of a list has a source, and is a name with parameters or an operator."""
    found = words(name)
    sources = entry_sources(name)
    assert len(sources) >= len(found.functions) + len(found.blocks) + 3
    for entry, source in sources.items():
        assert len(source) > 10, entry
    for key, form in found.functions.items():
        assert form.parameters or re.fullmatch(r"\W+|AND|OR|XOR|MOD|\.LEN", form.name), key
    for key, form in found.blocks.items():
        assert len(form.parameters) == len(BLOCKS[key].variables), key


def test_the_standard_list_has_all_functions_of_the_compiler() -> None:
    """The list for the standard has all functions of the compiler.

    Source: IEC 61131-3, edition 2, tables 22 to 37.
    """
    assert set(words("iec").functions) == set(FUNCTIONS)
    assert set(words("iec").blocks) == set(BLOCKS)


@pytest.mark.parametrize("name", [file.stem for file in sorted(FOLDER.glob("*.toml"))])
def test_the_library_uses_only_names_on_each_list(name: str, sources: Sources) -> None:
    assert unwritten(sources.parts, words(name)) == {}


@pytest.mark.exhaustive(but=["03_general_io", "06_teach_points"])
@pytest.mark.parametrize("name", [example.name for example in EXAMPLES])
def test_each_example_uses_only_names_on_each_list(name: str) -> None:
    parts = example_sources(name).parts
    located = name.startswith("09")  # Logix has no located variables, which example 09 needs
    for listed in set(_LISTS.values()) - ({"logix"} if located else set()):
        assert unwritten(parts, words(listed)) == {}, listed


@pytest.mark.parametrize("target", TARGETS)
def test_calls_of_the_library_are_on_the_list(target: str) -> None:
    """All calls in the exported library are in the tool's list."""
    sources, files = sample(), written(target).files
    own = {part.name for part in sources.parts} | {"RCX_TON", "RCX_R_TRIG", "RCX_FirstScan"}
    parts = sources.of("FUNCTION", "FUNCTION_BLOCK")
    bodies = {part.name: _body(target, files, part.name) for part in parts}
    assert sum(map(bool, bodies.values())) > 10
    instances = set(
        re.findall(r"(\w+)\s*:\s*\"?(?:FB_\w+|TON|R_TRIG)", " ".join(p.head for p in parts))
    )
    for name, body in bodies.items():
        called = {one.removesuffix("_X") for one in _called(body)}
        assert called <= _listed(target) | own | instances, name


@pytest.mark.parametrize(
    ("target", "statement", "wanted"),
    [
        ("scl", "i := SEL(b, i, j);", "#i := SEL(G := #b, IN0 := #i, IN1 := #j);"),
        ("scl", "i := LIMIT(0, j, 9);", "#i := LIMIT(MN := 0, IN := #j, MX := 9);"),
        ("scl", "i := LIMIT(MX := 9, MN := 0, IN := j);", "LIMIT(MN := 0, IN := #j, MX := 9)"),
        ("scl", "i := MAX(i, j, 3);", "#i := MAX(IN1 := #i, IN2 := #j, IN3 := 3);"),
        ("scl", "i := MUX(j, 5, 6, 7);", "#i := MUX(K := #j, IN0 := 5, IN1 := 6, IN2 := 7);"),
        ("scl", "a := LEFT(a, 3);", "#a := LEFT(IN := #a, L := 3);"),
        ("scl", "a := MID(a, 3, j);", "#a := MID(IN := #a, L := 3, P := #j);"),
        ("scl", "a := CONCAT(a, '1', '2');", "CONCAT(IN1 := CONCAT(IN1 := #a, IN2 := '1'), IN2 "),
        ("scl", "a := REPLACE(a, 'x', 1, 2);", "REPLACE(IN1 := #a, IN2 := 'x', L := 1, P := 2)"),
        ("scl", "i := FIND(IN2 := 'x', IN1 := a);", "#i := FIND(IN1 := #a, IN2 := 'x');"),
        ("scl", "i := LEN(a);", "#i := LEN(#a);"),
        ("scl", "w := ROL(w, 3);", "#w := ROL(IN := #w, N := 3);"),
        ("scl", "i := ADD(i, j, 3) * 2;", "#i := ((#i) + (#j) + (3)) * 2;"),
        ("scl", "b := GT(i, j, 3);", "#b := (((#i) > (#j)) AND ((#j) > (3)));"),
        ("scl", "w := AND(w, SHL(w, 2)) OR w;", "#w := ((#w) AND (SHL(IN := #w, N := 2))) OR #w;"),
        ("scl", "i := MOVE(j + 1);", "#i := (#j + 1);"),
        ("scl", "x := EXPT(x, j);", "#x := ((#x) ** (#j));"),
        ("scl", "b := b & c;", "#b := #b AND #c;"),
        ("scl", "t := ADD_TIME(t, T#1s);", "#t := ((#t) + (T#1s));"),
        ("twincat", "i := LEN(IN := a);", "i := LEN(a);"),
        ("twincat", "a := MID(P := 2, L := 1, IN := a);", "a := MID(a, 1, 2);"),
        ("twincat", "i := MAX(i, j, 3);", "i := MAX(MAX(i, j), 3);"),
        ("twincat", "i := SEL(G := b, IN0 := i, IN1 := j);", "i := SEL(b, i, j);"),
        ("twincat", "i := MUL(i, j);", "i := ((i) * (j));"),
        ("omron", "i := LIMIT(MN := 0, IN := j, MX := 9);", "i := LIMIT(0, j, 9);"),
        ("omron", "a := CONCAT(a, a);", "a := CONCAT(a, a);"),
        ("omron", "w := SHL(w, j);", "w := SHL(w, INT_TO_USINT(j));"),
        ("mitsubishi", "i := MAX(i, j, 3);", "i_X := MAX(MAX(i_X, j_X), 3);"),
        ("keyence", "a := LEFT(IN := a, L := 2);", "a := LEFT(a, 2);"),
        ("plcopen", "i := LIMIT(MX := 9, MN := 0, IN := j);", "i := LIMIT(0, j, 9);"),
        ("l5x", "i := ADD(i, j, 3);", "i := (i + j) + 3;"),
        ("l5x", "b := XOR(b, c, TRUE);", "b := (b XOR c) XOR 1;"),
    ],
)
def test_a_standard_function_is_written_in_the_form_of_the_list(
    target: str, statement: str, wanted: str, tmp_path: Path
) -> None:
    """A standard function is exported in the form of the tool.

    The expected forms were copied by hand from the vendors' lists. The sources are in
    `export/words`.
    """
    files, left_out = _exported(target, tmp_path, _block("MINE", "", statement))
    assert left_out == ()
    assert wanted in _body(target, files, "FB_MINE")


@pytest.mark.parametrize(
    ("target", "kind", "statement", "wanted"),
    [
        ("scl", "SR", "One(S1 := b, R := c, Q1 => b);", "#One(S1 := #b, R := #c, Q1 => #b);"),
        ("scl", "RS", "One(b, c);", "#One(S := #b, R1 := #c);"),
        ("scl", "TON", "One(IN := b, PT := T#1s);\n  b := One.Q;", "#b := #One.Q;"),
        ("scl", "CTU", "One(CU := b, PV := 3);\n  i := One.CV;", "#One(CU := #b, PV := 3);"),
        ("twincat", "SR", "One(S1 := b, R := c);\n  b := One.S1;", "One(SET1 := b, RESET := c);"),
        ("twincat", "SR", "One(S1 := b, R := c);\n  b := One.S1;", "b := One.SET1;"),
        ("twincat", "RS", "One(b, c);", "One(SET := b, RESET1 := c);"),
        ("omron", "SR", "One(S1 := b, R := c);", "One(Set1 := b, Reset := c);"),
        ("omron", "CTU", "One(CU := b, R := c, PV := 3);", "One(CU := b, Reset := c, PV := 3);"),
        ("omron", "CTD", "One(CD := b, LD := c, PV := 3);", "One(CD := b, Load := c, PV := 3);"),
        ("omron", "TON", "One(IN := SEL(b, b, c), PT := t);", "One(IN := SEL(b, b, c), PT := t);"),
        ("mitsubishi", "R_TRIG", "One(CLK := b);\n  b := One.CLK;", "One(_CLK := b_X);"),
        ("mitsubishi", "R_TRIG", "One(CLK := b);\n  b := One.CLK;", "b_X := One._CLK;"),
    ],
)
def test_a_standard_block_has_the_pins_of_the_list(
    target: str, kind: str, statement: str, wanted: str, tmp_path: Path
) -> None:
    """A standard block is exported with the pin names of the tool.

    Source: Tc2_Standard, W502 and the SCL help, as in `export/words`.
    """
    files, left_out = _exported(target, tmp_path, _block("MINE", f"One : {kind};", statement))
    assert left_out == ()
    assert wanted in _body(target, files, "FB_MINE")


@pytest.mark.parametrize(
    ("kind", "declared"),
    [
        *(("CTU", "CTU_INT"), ("CTD", "CTD_INT"), ("CTUD", "CTUD_INT"), ("CTU_DINT", "CTU_DINT")),
        *(("TON", "TON_TIME"), ("TOF", "TOF_TIME"), ("TP", "TP_TIME"), ("R_TRIG", "R_TRIG")),
        *(("F_TRIG", "F_TRIG"), ("SR", '"RCX_SR"'), ("RS", '"RCX_RS"')),
    ],
)
def test_scl_has_the_types_of_instances(kind: str, declared: str, tmp_path: Path) -> None:
    """In SCL, the type of a counter or timer contains the type of its value."""
    files, _ = _exported("scl", tmp_path, _instance(kind))
    assert f"      One : {declared};" in files[""]


def test_the_flip_flops_written_for_scl_are_those_of_the_standard(tmp_path: Path) -> None:
    """The exported SR and RS behave as the standard blocks for all orders of inputs.

    Source: IEC 61131-3, edition 2, tables 34.1 and 34.2.
    """
    files, _ = _exported("scl", tmp_path, _instance("SR") + _instance("RS"))
    blocks = re.findall(r'FUNCTION_BLOCK "RCX_[SR]+"\n.*?END_FUNCTION_BLOCK', files[""], re.DOTALL)
    assert len(blocks) == 2
    plain = re.sub(r"\{.*?\}\nVERSION : 0.1|//.*|BEGIN|#|\"", "", "\n".join(blocks))
    source = tmp_path / "flip.st"
    source.write_text(
        f"{plain}\nPROGRAM Both\n  VAR\n    b, c : BOOL;\n    s : SR; r : RS;\n"
        "    s2 : RCX_SR; r2 : RCX_RS;\n  END_VAR\n  s(S1 := b, R := c);\n  r(S := b, R1 := c);\n"
        "  s2(S1 := b, R := c);\n  r2(S := b, R1 := c);\nEND_PROGRAM\n"
    )
    program = build([source], "builtin").program
    seen = set()
    for scan, (b, c) in enumerate(
        [*product((False, True), repeat=2)] * 2 + [(True, False), (0, 0)]
    ):
        seen.add(_scanned(program, scan, bool(b), bool(c)))
    assert len(seen) > 2


def _scanned(program: Program, scan: int, b: bool, c: bool) -> tuple[object, object]:
    program.write("Main.b", b)
    program.write("Main.c", c)
    program.scan(scan * 10_000)
    found = [program.read(f"Main.{one}.Q1") for one in ("s", "s2", "r", "r2")]
    assert found[0] == found[1]
    assert found[2] == found[3]
    return found[0], found[2]


def test_in_scl_calls_of_user_functions_name_their_arguments(tmp_path: Path) -> None:
    """In SCL, a call of a user's function with more than one parameter names its arguments."""
    own = (
        "FUNCTION FC_Of : INT\n  VAR_INPUT\n    First, Second : INT;\n  END_VAR\n"
        "  FC_Of := First - Second;\nEND_FUNCTION\n"
    )
    files, _ = _exported("scl", tmp_path, own + _block("MINE", "", "i := FC_Of(i, ABS(j));"))
    wanted = '#i := "FC_Of"(First := #i, Second := ABS(#j));'
    assert wanted in _body("scl", files, "FB_MINE")
