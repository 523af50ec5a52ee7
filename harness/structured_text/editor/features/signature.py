"""Signature help: the pins of the call around the cursor, and the pin that is being written."""

from __future__ import annotations

from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.context import context
from structured_text.editor.index import Index
from structured_text.editor.lookup import callee_of
from structured_text.editor.pins import callee_title, pins_of_callee, result_of
from structured_text.editor.positions import from_editor, units
from structured_text.editor.texts import document
from structured_text.editor.writing import comment

__all__ = ["TRIGGERS", "signature"]

#: Characters behind which an editor should ask for signature help by itself.
TRIGGERS = ("(", ",")


def signature(
    index: Index, path: Path | str, text: str, position: lsp.Position
) -> lsp.SignatureHelp | None:
    """Return the pins of the call around a position; None outside of a call."""
    whole = document(text, str(path))
    here = context(whole, whole.offset(from_editor(whole.lines, position)))
    callee = None if here.call is None else callee_of(index, here.owner, here.call.callee)
    if here.call is None or callee is None:
        return None
    label = f"{callee_title(index, callee)}("
    parameters: list[lsp.ParameterInformation] = []
    active = None
    pins = pins_of_callee(index, callee)
    for number, pin in enumerate(pins):
        begin = units(label) + (2 if number else 0)
        label += f"{', ' if number else ''}{pin.text}"
        said = comment(index, pin.definition) if pin.definition is not None else ""
        parameters.append(lsp.ParameterInformation((begin, units(label)), said or None))
        if pin.name.upper() == here.call.active:
            active = number
    if active is None and not here.call.active and here.call.place < len(pins):
        active = here.call.place
    result = result_of(callee)
    label += f") : {result}" if result else ")"
    said = comment(index, callee.definition) if callee.definition is not None else ""
    shown = lsp.SignatureInformation(label, said or None, parameters, active)
    return lsp.SignatureHelp([shown], 0, active)
