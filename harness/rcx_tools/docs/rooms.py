"""The rooms (top-level folders and modules) of the packages, and the imports between rooms."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TypeAlias

__all__ = ["PLANS", "against", "arrows", "drawn", "rooms", "rooms_svg"]

_HARNESS = Path(__file__).resolve().parents[2]

#: The rows of a plan. Each row has rooms (folders or modules) and their columns.
Plan: TypeAlias = tuple[Mapping[str, float], ...]

#: The plans of the packages. A room (folder or module) may import rooms in lower rows, and rooms
#: further to the right in its own row. Every room may import a room of the last row. All rooms of
#: rcx_harness may import structured_text.
PLANS: Mapping[str, Plan] = {
    "rcx_harness": (
        {"cli": 2.3},
        {"editor": 1.2, "assistant": 2.3},
        {"testing": 0.8, "new": 1.8, "bridge": 2.8, "serve": 3.8, "look": 4.8},
        {"verify": 1},
        {"cell": 2},
        {"trace": 1.5},
        {"watch": 1.5},
        {"robot": 1.5, "enip": 3.5},
        {"spec": 2},
    ),
    "structured_text": (
        {"editor": 0.4, "testing": 1.7, "debug": 3, "explore": 4.3},
        {"export": 0, "mutants": 1.1, "coverage": 2.3, "prove": 3.5, "bench": 4.8},
        {"projects": 0.5, "engines": 2.3, "farm": 4.3},
        {"language": 1.5},
        {"output": 1, "errors": 3},
    ),
}

_COLUMN, _ROW, _WIDTH, _HEIGHT, _EDGE = 108, 78, 84, 30, 16


def rooms(package: str) -> set[str]:
    """Return the top-level folders and modules of a package, except its own __init__."""
    home = _HARNESS / package
    folders = {path.parent.name for path in home.glob("*/__init__.py")}
    every = folders | {path.stem for path in home.glob("*.py")}
    return {name for name in every if not name.startswith("_")}


@cache
def arrows(package: str) -> dict[str, set[str]]:
    """Map each room to the rooms of the same package that it imports, even if only for types."""
    found: dict[str, set[str]] = {name: set() for name in rooms(package)}
    for file in (_HARNESS / package).rglob("*.py"):
        here = file.relative_to(_HARNESS / package).parts[0].removesuffix(".py")
        if here in found and "template" not in file.parts:
            tree = ast.parse(file.read_text(encoding="utf-8"))
            found[here] |= _imported(tree, package) & set(found)
    return {name: below - {name} for name, below in found.items()}


def _imported(tree: ast.AST, package: str) -> set[str]:
    """Return the rooms of a package that the imports of a module name."""
    paths: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            paths += [f"{node.module}.{one.name}" for one in node.names]
        elif isinstance(node, ast.Import):
            paths += [one.name for one in node.names]
    split = [path.split(".") for path in paths]
    return {parts[1] for parts in split if parts[0] == package and len(parts) > 1}


def drawn(every: Mapping[str, Iterable[str]]) -> list[tuple[str, str]]:
    """Return the arrows to draw for an acyclic graph of imports.

    An arrow is left out if a longer path implies it.
    """

    def reached(name: str) -> set[str]:
        return set(every[name]).union(*(reached(one) for one in every[name]))

    return sorted(
        (name, below)
        for name in every
        for below in every[name]
        if not any(below in reached(other) for other in every[name])
    )


def against(plan: Plan, every: Mapping[str, Iterable[str]]) -> list[tuple[str, str]]:
    """Return the imports that a plan forbids: their arrows go up or to the left.

    If there are no such imports, the imports are acyclic.

    Raises:
        KeyError: a room has no place in the plan.
    """
    order = {name: (row, line[name]) for row, line in enumerate(plan) for name in line}
    return [(name, one) for name in every for one in every[name] if order[one] <= order[name]]


def rooms_svg(package: str) -> str:
    """Return the plan of a package as the text of an SVG file.

    Raises:
        ValueError: an import violates the plan.
    """
    plan, every = PLANS[package], arrows(package)
    if wrong := against(plan, every):
        raise ValueError(f"against the plan of the rooms: {wrong}")
    places = {
        name: (_EDGE + round(column * _COLUMN), _EDGE + row * _ROW)
        for row, line in enumerate(plan)
        for name, column in line.items()
    }
    upper = {name: below - set(plan[-1]) for name, below in every.items()}
    body = [_arrow(places[name], places[below]) for name, below in drawn(upper)]
    ground = _EDGE + (len(plan) - 1) * _ROW - 10
    body.append(f'<path class="g" d="M{_EDGE} {ground}H{_EDGE + 5 * _COLUMN + _WIDTH}"/>')
    for name, (x, y) in places.items():
        body.append(f'<rect class="b" x="{x}" y="{y}" width="{_WIDTH}" height="{_HEIGHT}" rx="4"/>')
        body.append(f'<text x="{x + _WIDTH // 2}" y="{y + 20}">{name}</text>')
    width = 2 * _EDGE + 5 * _COLUMN + _WIDTH
    height = 2 * _EDGE + (len(plan) - 1) * _ROW + _HEIGHT
    size = f'width="{width}" height="{height}"'
    head = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} viewBox="0 0 {width} {height}">',
        f"<title>The rooms of {package} and what each imports</title>",
        "<style>text{font:13px sans-serif;text-anchor:middle}.b{fill:#eef3f8;stroke:#456}"
        ".a{fill:none;stroke:#789}.g{stroke:#789;stroke-dasharray:5 4}</style>",
        '<defs><marker id="t" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" '
        'markerHeight="8" orient="auto"><path d="M0 0L8 4L0 8z" fill="#789"/></marker></defs>',
        f'<rect {size} fill="#fff"/>',
    ]
    return "\n".join([*head, *body, "</svg>", ""])


def _arrow(upper: tuple[int, int], lower: tuple[int, int]) -> str:
    """Return a line from the lower edge of a box to the upper edge of another."""
    (x, y), (to_x, to_y) = upper, lower
    x, to_x, y = x + _WIDTH // 2, to_x + _WIDTH // 2, y + _HEIGHT
    bend = to_y - (_ROW - _HEIGHT)  # straight down past the rows in between, then to the side
    middle = (bend + to_y) // 2
    path = f"M{x} {y}V{bend}C{x} {middle} {to_x} {middle} {to_x} {to_y}"
    return f'<path class="a" marker-end="url(#t)" d="{path}"/>'
