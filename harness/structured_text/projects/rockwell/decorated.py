"""The types of structures that an L5X does not declare, from the decorated values of their tags.

A decorated value names each member with its type. So the structures of modules, of predefined types
and of other vendors are known without a declaration.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Iterator, Mapping

from structured_text.projects.rockwell.data import Data
from structured_text.projects.rockwell.expression_reader import plain_tag
from structured_text.projects.rockwell.predefined import predefined
from structured_text.projects.xml import Element

__all__ = ["type_name", "undeclared", "used_types", "value_of"]

_STRUCTURES = ("Structure", "StructureMember")
_MEMBERS = ("DataValueMember", "ArrayMember", "StructureMember")
_NAME = re.compile(r"[^\W\d]\w*")
#: Matches the length at the end of the name of a text type, as in STRING_16.
_LENGTH = re.compile(r"STR(?:ING)?_?([1-9]\d{0,3})\Z", re.IGNORECASE)
#: The length of STRING, and that of the longest text.
_STRING, _LONGEST = 82, 65_535


def type_name(name: str) -> str:
    """Return a type's name without colons: AB_1756_DI_I_0 for `AB:1756_DI:I:0`."""
    return plain_tag(name)


def value_of(owner: Element) -> Element | None:
    """Return the decorated value of a tag, or None."""
    for form in (*owner.all("Data"), *owner.all("DefaultData")):
        if form.get("Format") == "Decorated" and form.children:
            return form.children[0]
    return None


def undeclared(root: Element, known: Container[str]) -> list[Element]:
    """Return a DataType element for each type that a file uses without a declaration.

    The type is described by values, or it is predefined. Other types are left out. `known` has the
    names of the declared types, in upper case.
    """
    found = _described(root, known)
    members = [member for kind in found.values() for member in kind.below("Member")]
    for one in (*root.below("Member", "Tag", "LocalTag", "Parameter"), *members):
        name = type_name(one.get("DataType"))
        if name.upper() not in known and name.upper() not in found:
            kind = predefined(name, one.at)
            if kind is not None:
                found[name.upper()] = kind
    return list(found.values())


def _described(root: Element, known: Container[str]) -> dict[str, Element]:
    """Return a DataType element for each structure that occurs only in values, by its name."""
    found: dict[str, dict[str, Element]] = {}
    places: dict[str, Element] = {}
    for form in root.below("Data", "DefaultData"):
        if form.get("Format") == "Decorated":
            for structure in _structures(form):
                name = type_name(structure.get("DataType"))
                if _NAME.fullmatch(name) and name.upper() not in known:
                    members = found.setdefault(name.upper(), {})
                    places.setdefault(name.upper(), structure)
                    for one in _members(structure):
                        members.setdefault(one.get("Name").upper(), one)
    return {
        key: _text_type(places[key], root)
        if _is_text(key, members)
        else _type(places[key], list(members.values()))
        for key, members in found.items()
    }


def _is_text(name: str, members: Mapping[str, Element]) -> bool:
    """Return whether a structure is a text: its characters have the type of the whole."""
    data = members.get("DATA")
    return data is not None and type_name(data.get("DataType")).upper() == name


def _text_type(place: Element, root: Element) -> Element:
    """Return a text type. The length is in its name, or it is that of STRING or of a value."""
    name = type_name(place.get("DataType"))
    size = _LENGTH.search(name)
    length = int(size[1]) if size is not None else _STRING
    for structure in _structures(root):
        if type_name(structure.get("DataType")).upper() == name.upper():
            for one in structure.all("DataValueMember"):
                given = one.get("Value")
                if one.get("Name").upper() == "LEN" and given.isdigit():
                    length = max(length, min(int(given), _LONGEST))
    data = {"Name": "DATA", "DataType": "SINT", "Dimension": str(length)}
    held = Element("Members", {}, place.at, [Element("Member", data, place.at)], place.at)
    named = {"Name": name, "Family": "StringFamily"}
    return Element("DataType", named, place.at, [held], place.at)


def used_types(names: Iterable[str], members: Mapping[str, Mapping[str, Data]]) -> set[str]:
    """Return some types and the types of all their members, in upper case."""
    found: set[str] = set()
    waiting = [name.upper() for name in names]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += [one.type.upper() for one in members.get(name, {}).values()]
    return found


def _structures(element: Element) -> Iterator[Element]:
    for one in element.children:
        if one.name in _STRUCTURES and one.get("DataType"):
            yield one
        yield from _structures(one)


def _members(structure: Element) -> Iterator[Element]:
    for one in structure.children:
        if one.name in _MEMBERS and _NAME.fullmatch(one.get("Name")) and one.get("DataType"):
            named = {
                "Name": one.get("Name"),
                "DataType": one.get("DataType"),
                "Dimension": one.get("Dimensions"),
            }
            yield Element("Member", named, one.at, [], one.at)


def _type(place: Element, members: list[Element]) -> Element:
    held = Element("Members", {}, place.at, list(members), place.at)
    name = type_name(place.get("DataType"))
    return Element("DataType", {"Name": name}, place.at, [held], place.at)
