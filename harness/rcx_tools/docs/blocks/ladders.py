"""The example of a block as ladder: the same statements as a drawn network."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

from rcx_tools.docs.blocks.examples import program, shows_all, snippets
from rcx_tools.docs.blocks.source import ROOT
from structured_text.errors import InputError
from structured_text.export.ladder.body import ladder_of
from structured_text.export.parts import sources_of
from structured_text.projects.diagrams.networks.draw.svg import networks_svg
from structured_text.projects.diagrams.networks.model import Diagram

__all__ = ["LADDER_MARK", "block_ladder", "ladder_text"]

#: Mark of a generated drawing. It stands below the first line of the file.
LADDER_MARK = "<!-- ladder, generated from docs/reference/blocks/snippets.toml by `make docs` -->"
#: Columns from which on a drawing goes on below. It is then as wide as the text of the site.
_WIDTH = 82


def block_ladder(name: str) -> str:
    """Return the drawing of a block's example as SVG."""
    diagram = _diagram(name)
    several = len(diagram.networks) > 1
    svg = networks_svg(diagram, f"{name} in ladder", width=_WIDTH, headed=several)
    begin, end, rest = svg.partition("\n")
    return f"{begin}{end}{LADDER_MARK}\n{rest}"


def ladder_text(name: str) -> str:
    """Return the picture of a block's example for its page, as Markdown."""
    count = len(_diagram(name).networks)
    networks = "one network" if count == 1 else f"{count} networks"
    return f"The same as ladder:\n\n![The example as ladder, {networks}](ladders/{name}.svg)\n"


@cache
def _diagram(name: str) -> Diagram:
    """Return the networks of those statements that the page of a block shows.

    Raises:
        InputError: a statement of the example cannot be a network.
    """
    snippet = snippets()[name]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, snippet.path.name)
        file.write_text(program(snippet), encoding="utf-8")
        sources = sources_of(ROOT / "plc/lib", [file], only_needed=True)
        (part,) = sources.of("PROGRAM")
        ladder = ladder_of(part, sources, ordered=False)
    if ladder.diagram is None or ladder.notes:
        raise InputError(f"the example of {name} cannot be ladder: {'; '.join(ladder.notes)}")
    if shows_all(snippet):
        return ladder.diagram
    # The first network calls FB_ReadArea, the last one FB_WriteArea.
    shown = ladder.diagram.networks[1:-1]
    return replace(
        ladder.diagram,
        networks=tuple(replace(network, number=network.number - 1) for network in shown),
        elements=tuple(
            replace(element, network=element.network - 1)
            for element in ladder.diagram.elements
            if any(element.network == network.number for network in shown)
        ),
    )
