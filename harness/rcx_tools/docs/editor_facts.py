"""The facts about blocks that the language server shows: legal values of inputs, and ErrorIDs."""

from __future__ import annotations

import json

from rcx_tools.docs.blocks.ranges import range_of
from rcx_tools.docs.blocks.source import Pou, pous

__all__ = ["editor_facts"]

_INPUTS = ("VAR_INPUT", "VAR_IN_OUT")


def editor_facts() -> str:
    """Return the file of facts: one object of JSON, with one line for each block."""
    rows = [f"{json.dumps(name)}: {json.dumps(_facts(pou))}" for name, pou in pous().items()]
    return "{\n" + ",\n".join(rows) + "\n}\n"


def _facts(pou: Pou) -> dict[str, object]:
    ranges = {
        pin.name: said
        for pin in pou.pins
        if pin.section in _INPUTS and (said := range_of(pou, pin))
    }
    has_errors = pou.pin("ErrorID") is not None
    return {"ranges": ranges, "errors": pou.errors() if has_errors else []}
