"""The tools `list_blocks` and `block_page`: the blocks of the library."""

from __future__ import annotations

from rcx_harness.assistant.call import Answer, Call
from rcx_harness.cell.blocks import blocks, page

__all__ = ["block_page", "list_blocks"]


def list_blocks(call: Call) -> Answer:
    """List the blocks of the library, with their pins and purposes."""
    wanted = str(call.given.get("search") or "").lower()
    every = call.given.get("internal", False)
    found = [
        {
            "name": block.name,
            "folder": block.folder,
            "purpose": block.purpose,
            "section": block.section,
            "returns": block.result,
            "inputs": [pin.name for pin in block.pins if pin.section != "VAR_OUTPUT"],
            "outputs": [pin.name for pin in block.pins if pin.section == "VAR_OUTPUT"],
        }
        for block in blocks().values()
        if (every or not block.internal)
        and wanted in f"{block.name} {block.folder} {block.purpose}".lower()
    ]
    lines = [f"{row['name']}: {row['purpose']}" for row in found]
    return Answer({"blocks": found}, "\n".join(lines) or "no block contains this text")


def block_page(call: Call) -> Answer:
    """Return the page of a block: what it does, its pins, its errors and its source."""
    name = call.given["name"]
    text = page(name)
    block = blocks()[name]
    pins = [
        {
            "section": pin.section,
            "name": pin.name,
            "type": pin.type,
            "default": pin.default,
            "meaning": pin.comment,
        }
        for pin in block.pins
    ]
    data = {"name": name, "purpose": block.purpose, "pins": pins, "page": text}
    return Answer(data, text, whole=True)
