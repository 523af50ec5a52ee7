"""The network of a statement as a drawing for the debug console, with what has power."""

from __future__ import annotations

from collections.abc import Callable

from structured_text.debug.scopes import Frame
from structured_text.debug.values import Held
from structured_text.errors import InputError
from structured_text.language.project import Project
from structured_text.language.source import NetworkLine
from structured_text.language.types import ElementaryType, EnumType
from structured_text.projects.diagrams.networks.draw.drawing import State
from structured_text.projects.diagrams.networks.draw.live import Found, LiveNetwork, edges_of
from structured_text.projects.diagrams.networks.draw.power import power_of
from structured_text.projects.diagrams.networks.draw.text import network_text
from structured_text.projects.diagrams.networks.stored import lines_of, network_at

__all__ = ["drawing_of"]

_TRUTH = {"TRUE": True, "FALSE": False}


def drawing_of(
    project: Project, frame: Frame, look: Callable[[str], Held], shown: Callable[[Held], str]
) -> str:
    """Return the drawing of the network that a frame executes.

    Args:
        project: The program.
        frame: The frame.
        look: Returns the value of an expression in the frame, or raises InputError.
        shown: Returns a value as text.

    Raises:
        InputError: The statement does not come from a network of a diagram.
    """
    line, found = frame.line, None
    if isinstance(line, NetworkLine):
        every = (network_at(source, line) for source in project.files)
        found = next(filter(None, every), None)
    if found is None or not isinstance(line, NetworkLine):
        hint = "stop in a rung or network of a ladder or function block diagram"
        raise InputError("this statement has no drawing", hint=hint)
    source, diagram, number = found
    held: dict[str, Held] = {}

    def find(text: str) -> Found | None:
        try:
            held[text] = value = look(text)
        except InputError:
            return None
        boolean = isinstance(value.type, ElementaryType) and value.type.name == "BOOL"
        has_value = isinstance(value.type, (ElementaryType, EnumType))
        return Found(text, boolean, has_value and (boolean or bool(value.path)))

    live = LiveNetwork(diagram, number, find, edges_of(lines_of(source, line.pou, number)))
    elements = live.elements()
    power = power_of(elements, lambda text: _value(shown(held[text])))
    values = {key: shown(held[name]) for key, name in live.values().items()}
    for element in elements:
        is_boolean = not element.get("number") and element.get("always") is None
        if "name" in element and is_boolean:
            name = element["name"]
            values[element["id"]] = "?" if name is None else shown(held[name])
    return network_text(diagram, number, State(power, values))


def _value(text: str) -> bool | int | None:
    """Return the value of a text if it is a truth value or an integer."""
    if text in _TRUTH:
        return _TRUTH[text]
    return int(text) if text.lstrip("-").isdecimal() else None
