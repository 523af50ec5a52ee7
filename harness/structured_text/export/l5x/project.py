"""Export for Rockwell L5X: structures as data types, functions and blocks as Add-On Instructions.

The file is a component that Studio 5000 Logix Designer imports. It contains a PROGRAM with all
types, functions and blocks that the program needs. Without a program, it contains an instruction
that needs the whole library. docs/how-to/export.md describes the translation.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from structured_text.errors import BLOCKS
from structured_text.export.l5x.blocks import standard_blocks
from structured_text.export.l5x.body import translated
from structured_text.export.l5x.model import Aoi, Data, Images, NotCarriedError, Tag, data_of
from structured_text.export.l5x.xml import aoi_element, data_type, document, program_element
from structured_text.export.losses import lost_configuration, missing, reaching_out
from structured_text.export.output import Missing, Output
from structured_text.export.parts import Part, Sources
from structured_text.export.words import unwritten, words
from structured_text.language import syntax as s
from structured_text.language.lexer import KEYWORDS
from structured_text.language.project import Project
from structured_text.language.types import BlockType, StructType
from structured_text.language.walk import declared

__all__ = ["LIBRARY", "to_l5x"]

#: The instruction that represents the library in a file without a program.
LIBRARY = f"{BLOCKS}Library"

_ASIDE = re.compile(r"'(?:\$.|[^$'])*'|\(\*.*?\*\)")
_CALLED = re.compile(r"(?<![\w.])([A-Za-z_]\w*)\s*\(")

_ABOUT = (
    f"{LIBRARY}: brings all instructions of the library with it when it is imported. It does "
    "nothing, and can be deleted then."
)


def to_l5x(sources: Sources) -> Output:
    """Write the sources as one L5X file; `missing` lists the declarations without a counterpart."""
    project = sources.project
    lost: list[Missing] = []
    arrays = {sources.names.byte_image: "SINT", sources.names.word_image: "INT"}
    images = {name.upper(): element for name, element in arrays.items() if name}
    types = _types(sources, images, lost)
    aois = {aoi.name: aoi for aoi in standard_blocks()}
    programs: list[Aoi] = []
    reasons = {
        part.name.upper(): reaching_out(part.node, "Studio 5000 Logix Designer")
        for part in sources.parts
        if isinstance(part.node, s.Pou)
    }
    barred = unwritten(sources.parts, words("logix"), reasons)
    for part in sources.of("FUNCTION", "FUNCTION_BLOCK", "PROGRAM"):
        if part.name.upper() in barred:
            lost.append(barred[part.name.upper()])
            continue
        try:
            made = translated(part, project.pous[part.name.upper()], project.pous, images)
            _check_needed(made, aois, types)
            _check_words(made, aois)
        except NotCarriedError as error:
            lost.append(missing(part, str(error), at=error.at))
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
        lost.append(lost_configuration(part, "make a periodic task and add the program to it"))
    text = _document(types.values(), aois, programs, sources.names.project)
    head, _, rest = text.partition("\n")
    return Output({"": f"{head}\n<!--\n{sources.notice}\n-->\n{rest}"}, tuple(lost), newline="\r\n")


def _document(
    types: Iterable[str], aois: dict[str, Aoi], programs: list[Aoi], controller: str
) -> str:
    elements = [aoi_element(aoi, aois) for aoi in aois.values()]
    if programs:
        program = program_element(programs[0], aois)
        return document(
            "Program", programs[0].name, types, elements, program, controller=controller
        )
    instances = [Tag(f"{name}_1", Data(name), "Local", is_block=True) for name in aois]
    needed = dict.fromkeys(aois)
    library = Aoi(LIBRARY, _ABOUT, locals=instances, logic=["(* nothing to do *)"], blocks=needed)
    elements.append(aoi_element(library, aois, target=True))
    return document("AddOnInstructionDefinition", LIBRARY, types, elements, controller=controller)


def _types(sources: Sources, images: Images, lost: list[Missing]) -> dict[str, str]:
    """Return the data types for the structures.

    Other types are written out where they are used.
    """
    found: dict[str, str] = {}
    gone: set[str] = set()
    for part in sources.of("TYPE"):
        kind = sources.project.types[part.name.upper()]
        if isinstance(kind, StructType):
            try:
                for _, inner in kind.fields:
                    if data_of(inner, images).type in gone:
                        raise NotCarriedError(
                            f"needs {data_of(inner, images).type}, which cannot be exported"
                        )
                found[kind.name] = data_type(kind, part.header, part.notes, images)
            except NotCarriedError as error:
                gone.add(kind.name)
                lost.append(missing(part, str(error)))
    return found


def _begins_anew(part: Part, project: Project) -> Iterator[Missing]:
    """Yield a report for each block in VAR RETAIN, because Prescan resets it at the start."""
    assert isinstance(part.node, s.Pou)
    for section, _, name in declared(part.node.sections):
        kind = project.pous[part.name.upper()].symbols[name.key].type
        if section.qualifier == "RETAIN" and isinstance(kind, BlockType):
            why = "RETAIN is not exported: a power loss resets it"
            yield missing(part, why, of=f"{section.kind} {name.text}", at=name.at)


def _check_needed(made: Aoi, aois: dict[str, Aoi], types: dict[str, str]) -> None:
    """Refuse a POU that needs a type or block that is not exported."""
    for name in (*made.types, *made.blocks):
        if name not in types and name not in aois:
            raise NotCarriedError(f"needs {name}, which cannot be exported")


def _check_words(made: Aoi, aois: dict[str, Aoi]) -> None:
    """Refuse a POU that calls an instruction which Structured Text of Logix does not have.

    Raise NotCarriedError if a call is not on the list.
    """
    listed = words("logix")
    functions = {one.name for one in listed.functions.values() if not one.is_operator}
    known = {*KEYWORDS, *functions, *listed.instructions, *aois}
    for line in (*made.logic, *made.prescan):
        for name in _CALLED.findall(_ASIDE.sub(" ", line)):
            if name not in known:
                raise NotCarriedError(f"{listed.tool} has no {name}: {line.strip()}")
