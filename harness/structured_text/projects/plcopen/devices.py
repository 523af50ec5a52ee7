"""The devices in an export of CODESYS.

Only one device is read at a time.

A device is a `configuration`. An application is a `resource` in the device, or in the elements that
CODESYS has added to the project. Each application has its own programs, lists and tasks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from structured_text.errors import InputError
from structured_text.projects.xml import Element

__all__ = ["choose_device"]

#: Elements that show that a device has a program.
_CONTENT = ("task", "pou", "globalVars", "pouInstance", "dataType", "Interface")


@dataclass(frozen=True)
class _Application:
    """An application, with the element that contains it."""

    device: str
    name: str
    parent: Element
    element: Element

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names by which a user can choose the application, in upper case."""
        return self.device.upper(), self.name.upper(), f"{self.device}.{self.name}".upper()


def choose_device(root: Element, device: str, file: Path) -> None:
    """Remove all devices from the tree of a project, except the one to read.

    Raise InputError if `device` is empty and there are several devices, or if no device has this
    name.
    """
    every = list(_applications(root, "", root))
    found = [one for one in every if any(one.element.below(*_CONTENT))]
    devices = list(dict.fromkeys(one.device for one in found))
    titles = devices if len(devices) > 1 else [_title(one) for one in found]
    if len(set(titles)) < 2 and not device:
        return
    chosen = [one for one in found if device.upper() in one.names]
    if device and len({one.device for one in chosen}) == 1 < len(chosen):
        titles = [_title(one) for one in chosen]
    elif len(chosen) == 1:
        for one in found:
            if one not in chosen:
                one.parent.content.remove(one.element)
        for configuration in root.below("configuration"):
            if not configuration.all("resource") and configuration.get("name") in devices:
                configuration.content.clear()
        return
    listed = " and ".join(titles) or "none"
    if not device or chosen:
        text = f"the project has several devices: {listed}"
    else:
        text = f"the project has no device {device}; it has {listed}"
    hint = f"choose one: --device {titles[0]}" if titles else "leave --device out"
    raise InputError(
        text, file=file, line=found[1].element.at if len(found) > 1 else None, hint=hint
    )


def _title(one: _Application) -> str:
    return f"{one.device}.{one.name}" if one.device else one.name


def _applications(element: Element, device: str, parent: Element) -> Iterator[_Application]:
    """Yield the applications below an element, with the device that each belongs to."""
    for child in element.children:
        if child.name == "resource":
            yield _Application(device, child.get("name"), element, child)
        elif child.name == "configuration":
            yield from _applications(child, child.get("name"), child)
        elif child.name in ("instances", "configurations", "addData", "data"):
            yield from _applications(child, device, child)
