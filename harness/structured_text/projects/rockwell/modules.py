"""The tags of modules: `Local:1:I` of the inputs, `:O` of the outputs, `:C` of the configuration.

An L5X does not list these tags. Their names follow from the modules' places, and their types from
the decorated values. A module in a chassis has its parent's name and its slot, a module of a
network its own name.

Source: 1756-PM004, I/O tag addresses: Location:Slot:Type.Member.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from structured_text.projects.rockwell.decorated import value_of
from structured_text.projects.rockwell.uses import (
    MODULE,
    Use,
    module_names,
    module_uses,
    value_element,
)
from structured_text.projects.xml import Element

__all__ = ["ModuleTags", "module_tags"]

#: Networks on which a module has an address, but no slot.
_NETWORKS = ("ETHERNET", "CONTROLNET", "DEVICENET", "SERIAL", "DH+", "RIO", "USB")


@dataclass
class ModuleTags:
    """The tags of the modules of a file that its routines use.

    Attributes:
        tags: A Tag element for each tag.
        images: The names of inputs and outputs, in upper case. A connection overwrites them.
        aliases: The tags that are parts of the tag of a rack's adapter, with the part.
        guessed: The tags whose types come from their uses.
        members: The uses of tags that are parameters of instructions, by the type in upper case.
    """

    tags: list[Element] = field(default_factory=list)
    images: set[str] = field(default_factory=set)
    aliases: dict[str, str] = field(default_factory=dict)
    guessed: list[Element] = field(default_factory=list)
    members: dict[str, list[Use]] = field(default_factory=dict)


def module_tags(root: Element) -> ModuleTags:
    """Return the tags of modules that the routines and aliases of a file use."""
    found = ModuleTags()
    uses = module_uses(root)
    modules = list(_modules(root))
    made = {one.get("Name").upper(): one for module in modules for one in _tags_of(module)}
    for module in modules:
        for key, target in _parts_of(module, made):
            if key in uses:
                found.aliases[key] = target
                uses.setdefault(target.partition(".")[0].upper(), Use(module.at))
    for key, use in uses.items():
        if key in found.aliases:
            continue
        tag = made.get(key)
        if tag is None and use.name and (shape := use.shape()) is not None:
            tag = Element("Tag", {"Name": use.name}, use.at, [], use.at)
            tag.content.append(value_element(shape, f"{use.name}_USED", use.at))
            tag.attributes["DataType"] = tag.children[0].children[0].get("DataType")
            found.guessed.append(tag)
            if isinstance(shape, str):
                found.members.setdefault(shape.upper(), []).append(use)
        if tag is not None:
            image = not key.endswith(":C")
            # a connection to the module overwrites inputs and outputs, so they begin with 0
            found.tags.append(replace(tag, content=[]) if image else tag)
            if image:
                found.images.add(key)
    named = {module.get("Name").upper(): module for module in modules}
    for key in {name.upper(): None for name, _ in module_names(root)}:
        if key in named:
            module = named[key]
            given = {"Name": f"{module.get('Name')}:{MODULE}", "DataType": MODULE}
            found.tags.append(Element("Tag", given, module.at, [], module.at))
    return found


# --- tags that a module describes -------------------------------------------------------------


def _modules(root: Element) -> Iterator[Element]:
    for owner in root.below("Modules"):
        yield from owner.all("Module")


def _place(module: Element) -> str:
    """Return the first part of the names of a module's tags."""
    for port in module.all("Ports", "Port"):
        kind, slot = port.get("Type").upper(), port.get("Address")
        if port.get("Upstream") == "true" and kind not in _NETWORKS and slot.isdigit():
            return f"{module.get('ParentModule')}:{slot}"
    return module.get("Name")


def _tags_of(module: Element) -> Iterator[Element]:
    place = _place(module)
    for one in module.all("Communications", "ConfigTag"):
        yield from _tag(f"{place}:C", one)
    seen: set[str] = set()
    for connection in module.all("Communications", "Connections", "Connection"):
        for kind, letter in (("Input", "I"), ("Output", "O")):
            suffix = connection.get(f"{kind}TagSuffix") or letter
            for one in connection.all(f"{kind}Tag"):
                if suffix not in seen:
                    yield from _tag(f"{place}:{suffix}", one)
                seen.add(suffix)


def _tag(name: str, owner: Element) -> Iterator[Element]:
    """Yield the tag of a connection, if its type is known."""
    value = value_of(owner)
    if value is None or not value.get("DataType"):
        return
    named = {
        "Name": name,
        "DataType": value.get("DataType"),
        "Dimensions": value.get("Dimensions"),
    }
    yield Element("Tag", named, owner.at, list(owner.content), owner.end)


def _parts_of(module: Element, tags: dict[str, Element]) -> Iterator[tuple[str, str]]:
    """Yield the tags that are a slot of the adapter's tag, for a module of a rack connection."""
    slot = _place(module).rpartition(":")[2]
    for kind, letter in (("In", "I"), ("Out", "O")):
        for _ in module.all("Communications", "RackConnection", f"{kind}AliasTag"):
            adapter = f"{module.get('ParentModule')}:{letter}"
            tag = tags.get(adapter.upper())
            value = value_of(tag) if tag is not None else None
            names = [one.get("Name") for one in value.children] if value is not None else []
            for member in ("Slot", "Data"):
                if slot.isdigit() and member in names:
                    yield f"{_place(module)}:{letter}".upper(), f"{adapter}.{member}[{slot}]"
                    break
