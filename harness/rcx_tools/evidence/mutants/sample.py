"""What is taken of all changes that operators know: a sample, the same for the same seed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from random import Random

from rcx_harness.errors import InputError
from rcx_harness.verify.mutants.mutant import Mutant, in_rounds, mutant_of
from rcx_harness.verify.mutants.text import Edit, edited

__all__ = ["Change", "sampled"]


@dataclass(frozen=True)
class Change:
    """One change of a file: its operator, the function or entry that it is in, its edits."""

    operator: str
    pou: str
    edits: tuple[Edit, ...]


def sampled(
    root: Path,
    file: Path,
    found: list[Change],
    meaning: Callable[[str], str],
    *,
    one_of: int,
    seed: int,
) -> list[Mutant]:
    """One of so many changes of a file, at least one: of each operator one first.

    Args:
        root: The repository.
        file: The file.
        found: What can be done to it.
        meaning: What a text means; changes that mean the same are one, and none is no mutant.
        one_of: 1 takes all.
        seed: Of the sample.
    """
    text = file.read_text(encoding="utf-8")
    path = file.relative_to(root).as_posix()
    seen = {meaning(text)}

    def mutants() -> Iterator[Mutant]:
        chance = Random(f"{seed}:{file.name}")
        for change in in_rounds(found, lambda change: change.operator, chance):
            try:
                means = meaning(edited(text, change.edits))
            except (SyntaxError, InputError):
                continue
            if means not in seen:
                seen.add(means)
                yield mutant_of(path, change.pou, change.operator, text, change.edits)

    most = math.ceil(len(found) / one_of)
    return sorted(islice(mutants(), most), key=lambda mutant: mutant.line)
