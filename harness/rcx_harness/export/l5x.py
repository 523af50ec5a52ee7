"""Rockwell L5X: structures as data types, functions and blocks as Add-On Instructions.

What Studio 5000 Logix Designer imports as a component: a PROGRAM with all it needs, or, without
one, an instruction that needs the whole library. docs/export.md says what is translated how.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.project import Project
from rcx_harness.engine.types import BlockType, StructType
from rcx_harness.export.l5x_blocks import standard_blocks
from rcx_harness.export.l5x_body import translated
from rcx_harness.export.l5x_model import Aoi, Data, NotCarriedError, Tag
from rcx_harness.export.l5x_xml import aoi_element, data_type, document, program_element
from rcx_harness.export.losses import lost_configuration, missing, sections
from rcx_harness.export.output import NOTICE, Missing, Output
from rcx_harness.export.parts import Part, Sources

__all__ = ["LIBRARY", "to_l5x"]

#: The instruction that stands for the library in a file without a program.
LIBRARY = "RCX_Library"

_ABOUT = (
    "RCX_Library: brings all instructions of the library with it when it is imported. It does "
    "nothing, and can be deleted then."
)


def to_l5x(sources: Sources) -> Output:
    """The sources as one L5X file; `missing` names what has no counterpart."""
    project = sources.project
    lost: list[Missing] = []
    types = _types(sources, project, lost)
    aois = {aoi.name: aoi for aoi in standard_blocks()}
    programs: list[Aoi] = []
    for part in sources.of("FUNCTION", "FUNCTION_BLOCK", "PROGRAM"):
        try:
            made = translated(part, project.pous[part.name.upper()], project.pous)
            _check_needed(made, aois, types)
        except NotCarriedError as error:
            lost.append(missing(part, str(error)))
            continue
        if part.kind != "PROGRAM":
            aois[made.name] = made
        elif programs:
            lost.append(missing(part, "a file holds one program; export it by itself"))
            continue
        else:
            programs.append(made)
        lost += _begins_anew(part, project)
    for part in sources.of("CONFIGURATION"):
        lost.append(lost_configuration(part, "make a periodic task and put the program in"))
    text = _document(types.values(), aois, programs)
    head, _, rest = text.partition("\n")
    return Output({"": f"{head}\n<!--\n{NOTICE}\n-->\n{rest}"}, tuple(lost), newline="\r\n")


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


def _types(sources: Sources, project: Project, lost: list[Missing]) -> dict[str, str]:
    """The structures; other types are written out where they are used."""
    found: dict[str, str] = {}
    for part in sources.of("TYPE"):
        kind = project.types[part.name.upper()]
        if isinstance(kind, StructType):
            try:
                found[kind.name] = data_type(kind, part.header, part.notes)
            except NotCarriedError as error:
                lost.append(missing(part, str(error)))
    return found


def _begins_anew(part: Part, project: Project) -> Iterator[Missing]:
    """Blocks in VAR RETAIN: their Prescan routines clear them when the controller starts."""
    assert isinstance(part.node, s.Pou)
    for section, _, name in sections(part.node):
        kind = project.pous[part.name.upper()].symbols[name.key].type
        if section.qualifier == "RETAIN" and isinstance(kind, BlockType):
            why = "RETAIN: it begins anew when power was off"
            yield missing(part, why, of=f"{section.kind} {name.text}", at=name.at)


def _check_needed(made: Aoi, aois: dict[str, Aoi], types: dict[str, str]) -> None:
    for name in (*made.types, *made.blocks):
        if name not in types and name not in aois:
            raise NotCarriedError(f"needs {name}, which is not carried")
