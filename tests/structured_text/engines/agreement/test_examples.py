"""The examples run alike on all engines for any data from the robot."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from both_engines import COMPILED
from structured_text.engines.base import Program
from structured_text.engines.load import build
from structured_text.language.types import BlockType, StructType
from structured_text.projects.needed import needed

_PLC = Path(__file__).parents[4] / "plc"
#: Examples whose process image is a pair of arrays. The other examples have tests of their own.
EXAMPLES = [
    path.parent
    for path in sorted((_PLC / "examples").glob("*/Config.st"))
    if any("InputArea" in file.read_text(encoding="utf-8") for file in path.parent.glob("*.st"))
]


def _build(example: Path, engine: str) -> Program:
    files = sorted(example.glob("*.st"))
    return build([*needed(files, sorted((_PLC / "lib").rglob("*.st"))), *files], engine).program


@pytest.mark.parametrize(
    ("example", "seed"),
    [(example, seed) for k, example in enumerate(EXAMPLES) for seed in range(3 if k < 3 else 1)],
    ids=lambda value: getattr(value, "name", str(value)),
)
@pytest.mark.parametrize("engine", COMPILED)
def test_the_examples_run_alike_on_each_engine(example: Path, seed: int, engine: str) -> None:
    """Bits of the input area change at random, sometimes a dozen at once.

    The link comes and goes.
    """
    one, two = _build(example, engine), _build(example, "builtin")
    paths = [path for path, kind in one.walk() if not isinstance(kind, (StructType, BlockType))]
    starts = [path for path, _ in one.walk() if re.fullmatch(r"Main\.Start\d?", path)]
    chance = random.Random(seed)
    area = bytearray(one.read_bytes("Main.InputArea"))
    now_us = 0
    for scan in range(250):
        for _ in range(chance.choice((0, 0, 0, 1, 2, 30))):
            area[chance.randrange(len(area))] ^= 1 << chance.randrange(8)
        connected, start = chance.random() < 0.98, chance.random() < 0.5
        for program in (one, two):
            program.write_bytes("Main.InputArea", bytes(area))
            program.write("Main.Connected", connected)
            for path in starts:
                program.write(path, start)
            program.scan(now_us)
        now_us += chance.choice((1_000, 10_000, 50_000))
        different = [path for path in paths if one.read(path) != two.read(path)]
        assert different == [], f"scan {scan}, seed {seed}"
