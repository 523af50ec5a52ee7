"""Types that a file uses and does not define, and that are not predefined.

Such a type gets the members whose types the routines show. A routine that needs another member is
refused by name, and the other routines are read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterator, Mapping, Sequence

from structured_text.projects.rockwell.decorated import type_name
from structured_text.projects.rockwell.uses import STEP, Use, operands, shape_value
from structured_text.projects.xml import Element

__all__ = ["unknown_types"]

#: Matches a tag without a colon, with its members, elements and bits.
_USED = re.compile(
    r"(?:\b(?P<bit>XIC|XIO|OTE|OTL|OTU)\s*\(\s*)?"
    r"(?<![\w.:\\#%])(?P<tag>[^\W\d]\w*)(?![\w:])"
    r"(?P<rest>(?:\.\w+|\[(?!:=\])[^\[\]]*\])*)(?P<closed>\s*\))?",
    re.IGNORECASE,
)
#: Types of members of drives, by the beginning of the type. Source: exports of these modules.
_MEMBERS = {
    "AB_POWERFLEX525": {"FREQCOMMAND": "INT", "OUTPUTFREQ": "INT"},
    "AB_POWERFLEX755": {"REFERENCE": "REAL", "FEEDBACK": "REAL"},
}
_NAMED = re.compile(r"[^\W\d]\w*")
#: The member of a type of which no member is known.
_HIDDEN = "Closed_"


def unknown_types(
    root: Element,
    typed: list[Element],
    known: Container[str],
    members: Mapping[str, Sequence[Use]],
    note: Callable[[str, Element], None],
) -> list[Element]:
    """Return a DataType element for each type of the elements `typed` that is not in `known`.

    `known` has names in upper case, and `members` the uses of tags of modules by their type.
    """
    places: dict[str, Element] = {}
    for one in typed:
        name = type_name(one.get("DataType"))
        if _NAMED.fullmatch(name) and name.upper() not in known:
            places.setdefault(name.upper(), one)
    if not places:
        return []
    uses = {key: Use(one.at, type_name(one.get("DataType"))) for key, one in places.items()}
    for key, use in uses.items():
        for other in members.get(key, ()):
            use.merge(other)
    for scope, tags in _scopes(root, places):
        _record(scope, tags, uses)
    return [_type(uses[key], place, note) for key, place in places.items()]


def _scopes(root: Element, places: Container[str]) -> Iterator[tuple[Element, dict[str, str]]]:
    """Yield each program and instruction with its tags of unknown types."""
    shared = {
        tag.get("Name").upper(): type_name(tag.get("DataType")).upper()
        for owner in root.below("Controller")
        for tag in owner.all("Tags", "Tag")
    }
    for owner in root.below("Program", "AddOnInstructionDefinition"):
        own = (
            *owner.all("Tags", "Tag"),
            *owner.all("LocalTags", "LocalTag"),
            *owner.all("Parameters", "Parameter"),
        )
        tags = dict(shared) if owner.name == "Program" else {}
        tags |= {one.get("Name").upper(): type_name(one.get("DataType")).upper() for one in own}
        yield owner, {name: kind for name, kind in tags.items() if kind in places}


def _record(scope: Element, tags: dict[str, str], uses: dict[str, Use]) -> None:
    if not tags:
        return
    for part in scope.below("Text", "Line"):
        pieces = operands(part, {}) if part.name == "Text" else [(part.text(), part.at, "")]
        for text, _, _ in pieces:
            for found in _USED.finditer(text):
                kind = tags.get(found["tag"].upper())
                steps = STEP.findall(found["rest"])
                while steps and steps[0][1]:  # an element of an array
                    del steps[0]
                if kind and steps and steps[0][0]:
                    flag = bool(found["bit"] and found["closed"])
                    uses[kind].add(steps, flag=flag, number="")


def _type(use: Use, place: Element, note: Callable[[str, Element], None]) -> Element:
    """Return the type with the members whose own types are known."""
    tables = (table for name, table in _MEMBERS.items() if use.name.upper().startswith(name))
    table = next(tables, {})
    members = []
    for key, one in use.members.items():
        shape = table.get(key) or one.shape()
        if shape is not None:
            members.append(shape_value(shape, one.name, f"{use.name}_{one.name}", place.at))
    text = f"the type {use.name} is not in the file"
    if members:
        names = ", ".join(one.get("Name") for one in members)
        note(f"{text}; its members are made from their uses: {names}", place)
    else:
        note(f"{text}; what needs its members is not read", place)
        members = [Element("DataValueMember", {"Name": _HIDDEN, "DataType": "BOOL"}, place.at)]
    value = Element("Structure", {"DataType": use.name}, place.at, list(members), place.at)
    return Element("Data", {"Format": "Decorated"}, place.at, [value], place.at)
