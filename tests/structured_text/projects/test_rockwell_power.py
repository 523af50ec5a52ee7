"""Random rungs behave as an interpreter that walks along the rung, instruction by instruction.

The interpreter executes each instruction at its place, as a controller does, and knows nothing of
expressions, variables or statements.
"""

from __future__ import annotations

import random
from pathlib import Path
from typing import TypeAlias

import pytest

from l5x_ladder import program, written

_BITS = "abcdefgh"
_INPUTS = ("XIC", "XIO", "ONS")
_OUTPUTS = ("OTE", "OTL", "OTU", "ADD")
_Series: TypeAlias = "list[tuple[str, str] | list[_Series]]"


def _series(rng: random.Random, depth: int) -> _Series:
    found: _Series = []
    for _ in range(rng.randint(0 if depth else 1, 4)):
        if depth < 3 and rng.random() < 0.35:
            found.append([_series(rng, depth + 1) for _ in range(rng.randint(1, 3))])
        else:
            names = _INPUTS if rng.random() < 0.6 else _OUTPUTS
            found.append((rng.choice(names), rng.choice(_BITS)))
    return found


def _text(series: _Series) -> str:
    parts = []
    for node in series:
        if isinstance(node, list):
            parts.append(f"[{','.join(_text(leg) for leg in node)}]")
        else:
            name, bit = node
            parts.append("ADD(i,1,i)" if name == "ADD" else f"{name}({bit})")
    return "".join(parts)


def _walk(series: _Series, power: bool, state: dict[str, int]) -> bool:
    for node in series:
        if isinstance(node, list):
            ends = [_walk(leg, power, state) for leg in node]
            power = any(ends)
            continue
        name, bit = node
        value = bool(state[bit])
        if name == "XIC":
            power = power and value
        elif name == "XIO":
            power = power and not value
        elif name == "ONS":
            state[bit], power = power, power and not value
        elif name == "OTE":
            state[bit] = power
        elif name in ("OTL", "OTU") and power:
            state[bit] = name == "OTL"
        elif name == "ADD" and power:
            state["i"] += 1
    return power


def _differences(folder: Path, seed: int, scans: int) -> list[str]:
    rng = random.Random(seed)
    rungs = [_series(rng, 0) for _ in range(12)]
    running = program(written(folder, [f"{_text(rung)};" for rung in rungs]))
    running.scan(0)  # the prescan
    state: dict[str, int] = {name: running.read(f"Main.{name}") for name in (*_BITS, "i")}
    for scan in range(1, scans + 1):
        for bit in _BITS:
            if rng.random() < 0.5:
                state[bit] = rng.random() < 0.5
                running.write(f"Main.{bit}", bool(state[bit]))
        running.scan(scan * 10_000)
        for rung in rungs:
            _walk(rung, True, state)
        found = {name: running.read(f"Main.{name}") for name in state}
        if found != state:
            return [f"seed {seed}, scan {scan}: {found} instead of {state}"]
    return []


@pytest.mark.parametrize("seed", range(6))
def test_random_rungs_behave_as_the_drawn_rungs(tmp_path: Path, seed: int) -> None:
    """Twelve rungs with nested branches, outputs in the middle and one-shots, in 20 scans."""
    assert _differences(tmp_path, seed, 20) == []
