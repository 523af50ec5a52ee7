"""What is taken of all changes that operators know: a sample, the same for the same seed.

Whether a change is taken depends on itself alone: code that moves, or that is changed elsewhere,
leaves the rest of the sample as it was, and so what is known of its survivors.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path

from structured_text.errors import InputError
from structured_text.mutants.mutant import Mutant, mutant_of
from structured_text.mutants.text import Edit

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
    """About one of so many changes of a file, at least one.

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
    every = [mutant_of(path, change.pou, change.operator, text, change.edits) for change in found]
    drawn = sorted(((_drawn(mutant, seed), k) for k, mutant in enumerate(every)))
    seen, taken = {meaning(text)}, list[Mutant]()
    for place, k in drawn:
        if taken and place * one_of >= 1:
            break
        try:
            means = meaning(every[k].text)
        except (SyntaxError, InputError):
            continue
        if means not in seen:
            seen.add(means)
            taken.append(every[k])
    return sorted(taken, key=lambda mutant: mutant.line)


def _drawn(mutant: Mutant, seed: int) -> float:
    """From 0 to 1, of what is changed to what, and in which function or entry."""
    where = mutant.pou.rpartition(":")[2]
    told = "\0".join((str(seed), where, mutant.operator, mutant.before, mutant.after))
    return int.from_bytes(blake2b(told.encode(), digest_size=8).digest(), "big") / 2**64
