"""The sizes of array parameters of Add-On Instructions, from their arguments.

An InOut parameter takes arrays with more elements than it declares, and SIZE gives the number of
the argument (assumed). If all rungs pass arrays of the same size, the parameter has this size.
Otherwise it keeps its own, and calls with another size are refused.
"""

from __future__ import annotations

from collections.abc import Iterator

from structured_text.language.source import Line
from structured_text.projects.rockwell.ladder.model import LadderError, instructions
from structured_text.projects.rockwell.ladder.neutral_text import read_rung
from structured_text.projects.rockwell.values import ENABLE
from structured_text.projects.xml import Element

__all__ = ["size_parameters"]


def size_parameters(root: Element) -> None:
    """Give array parameters the sizes of their arguments."""
    required = {
        aoi.get("Name").upper(): [
            one
            for one in aoi.all("Parameters", "Parameter")
            if one.get("Required") == "true" and one.get("Name").upper() not in ENABLE
        ]
        for aoi in root.below("AddOnInstructionDefinition")
    }
    arrays = {
        name: some
        for name, some in required.items()
        if any(one.get("Usage") == "InOut" and _sizes(one) for one in some)
    }
    found: dict[int, tuple[Element, set[tuple[int, ...]]]] = {}
    for tags, name, arguments in _calls(root, arrays) if arrays else ():
        for parameter, argument in zip(arrays[name], arguments, strict=False):
            tag = tags.get(argument.upper())
            if parameter.get("Usage") == "InOut" and _sizes(parameter) and tag is not None:
                same = tag.get("DataType").upper() == parameter.get("DataType").upper()
                sizes = _sizes(tag) if same else ()
                found.setdefault(id(parameter), (parameter, set()))[1].add(sizes)
    for parameter, given in found.values():
        own, sizes = _sizes(parameter), next(iter(given))
        fits = len(own) == len(sizes) and all(a <= b for a, b in zip(own, sizes, strict=True))
        if len(given) == 1 and fits:
            parameter.attributes["Dimensions"] = " ".join(map(str, sizes))


def _sizes(element: Element) -> tuple[int, ...]:
    """Return the dimensions of a tag; nothing if it is not an array."""
    words = element.get("Dimensions").replace(",", " ").split()
    if not all(one.isdecimal() and len(one) < len("2147483648") for one in words):
        return ()
    return tuple(int(one) for one in words if int(one))


def _calls(
    root: Element, names: dict[str, list[Element]]
) -> Iterator[tuple[dict[str, Element], str, tuple[str, ...]]]:
    """Yield the tags that a call sees, its instruction, and the arguments behind the instance."""
    shared = [tag for owner in root.below("Controller") for tag in owner.all("Tags", "Tag")]
    for owner in root.below("Program", "AddOnInstructionDefinition"):
        own = (
            *owner.all("Tags", "Tag"),
            *owner.all("LocalTags", "LocalTag"),
            *owner.all("Parameters", "Parameter"),
        )
        seen = (*shared, *own) if owner.name == "Program" else own
        tags = {one.get("Name").upper(): one for one in seen}
        for part in owner.below("Text"):
            try:
                rung = read_rung(part.lines() or [Line("", part.at)])
            except LadderError:
                continue
            for instruction in instructions(rung):
                if instruction.name in names:
                    yield tags, instruction.name, tuple(instruction.operands[1:])
