"""Rockwell L5X: structures as data types, functions and blocks as Add-On Instructions.

What Studio 5000 Logix Designer imports as a component: a PROGRAM with all it needs, or, without
one, an instruction that needs the whole library. docs/export.md says what is translated how.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.load import checked
from rcx_harness.engine.frontend.project import Project
from rcx_harness.engine.types import StructType
from rcx_harness.export.l5x_blocks import standard_blocks
from rcx_harness.export.l5x_body import translated
from rcx_harness.export.l5x_model import Aoi, Data, NotCarriedError, Tag
from rcx_harness.export.l5x_xml import aoi_element, data_type, document, program_element
from rcx_harness.export.output import NOTICE, Output
from rcx_harness.export.parts import Part, Sources
from rcx_harness.export.words import unwritten, words

__all__ = ["LIBRARY", "to_l5x"]

#: The instruction that stands for the library in a file without a program.
LIBRARY = "RCX_Library"

_ASIDE = re.compile(r"'(?:\$.|[^$'])*'|\(\*.*?\*\)")
_CALLED = re.compile(r"(?<![\w.])([A-Za-z_]\w*)\s*\(")
_KEYWORDS = (
    "IF",
    "ELSIF",
    "WHILE",
    "UNTIL",
    "CASE",
    "NOT",
    "AND",
    "OR",
    "XOR",
    "MOD",
    "OF",
    "THEN",
)

_ABOUT = (
    "RCX_Library: brings all instructions of the library with it when it is imported. It does "
    "nothing, and can be deleted then."
)


def to_l5x(sources: Sources) -> Output:
    """The sources as one L5X file; `left_out` names what has no counterpart."""
    project = checked([part.file for part in sources.parts])
    left_out: list[str] = []
    types = _types(sources, project, left_out)
    aois = {aoi.name: aoi for aoi in standard_blocks()}
    programs: list[Aoi] = []
    barred = unwritten(sources.parts, words("logix"))
    for part in sources.of("FUNCTION", "FUNCTION_BLOCK", "PROGRAM"):
        try:
            if part.name.upper() in barred:
                raise NotCarriedError(barred[part.name.upper()])
            made = translated(part, project.pous[part.name.upper()], project.pous)
            _check_needed(made, aois, types)
            _check_words(made, aois)
        except NotCarriedError as error:
            left_out.append(f"{part.kind} {part.name}: {error}")
            continue
        if part.kind != "PROGRAM":
            aois[made.name] = made
        elif programs:
            left_out.append(f"PROGRAM {part.name}: a file holds one program; export it by itself")
        else:
            programs.append(made)
    for part in sources.of("CONFIGURATION"):
        left_out.append(f"CONFIGURATION {part.name}: make a periodic task and put the program in")
    text = _document(types.values(), aois, programs)
    head, _, rest = text.partition("\n")
    return Output({"": f"{head}\n<!--\n{NOTICE}\n-->\n{rest}"}, tuple(left_out), newline="\r\n")


def _document(types: Iterable[str], aois: dict[str, Aoi], programs: list[Aoi]) -> str:
    elements = [aoi_element(aoi, aois) for aoi in aois.values()]
    if programs:
        program = program_element(programs[0], aois)
        return document("Program", programs[0].name, types, elements, program)
    instances = [Tag(f"{name}_1", Data(name), "Local", is_block=True) for name in aois]
    needed = dict.fromkeys(aois)
    library = Aoi(LIBRARY, _ABOUT, locals=instances, logic=["(* nothing to do *)"], blocks=needed)
    elements.append(aoi_element(library, aois, target=True))
    return document("AddOnInstructionDefinition", LIBRARY, types, elements)


def _types(sources: Sources, project: Project, left_out: list[str]) -> dict[str, str]:
    """The structures; other types are written out where they are used."""
    found: dict[str, str] = {}
    for part in sources.of("TYPE"):
        kind = project.types[part.name.upper()]
        if isinstance(kind, StructType):
            try:
                _check_plain(part)
                found[kind.name] = data_type(kind, part.header, part.notes)
            except NotCarriedError as error:
                left_out.append(f"TYPE {part.name}: {error}")
    return found


def _check_plain(part: Part) -> None:
    node = part.node
    assert isinstance(node, s.TypeDecl)
    fields = node.spec.fields if isinstance(node.spec, s.StructSpec) else ()
    if node.initial is not None or any(field.initial is not None for field in fields):
        raise NotCarriedError("a data type has no initial values here")


def _check_needed(made: Aoi, aois: dict[str, Aoi], types: dict[str, str]) -> None:
    for name in (*made.types, *made.blocks):
        if name not in types and name not in aois:
            raise NotCarriedError(f"needs {name}, which is not carried")


def _check_words(made: Aoi, aois: dict[str, Aoi]) -> None:
    """Whatever its lines call must be on the list of what Structured Text of Logix has."""
    listed = words("logix")
    functions = {one.name for one in listed.functions.values() if not one.is_operator}
    known = {*_KEYWORDS, *functions, *listed.instructions, *aois}
    for line in (*made.logic, *made.prescan):
        for name in _CALLED.findall(_ASIDE.sub(" ", line)):
            if name not in known:
                raise NotCarriedError(f"{listed.tool} has no {name}: {line.strip()}")
