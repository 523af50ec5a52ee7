"""Samples of all possible changes. The same seed always gives the same sample.

The hash of a change alone determines whether the change is taken. If other code moves or changes,
the sample stays the same. The recorded reasons of survivors therefore stay valid.
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
    """One change of a file: the operator, the changed function or entry, and the edits."""

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
    """Return about one of `one_of` changes of a file, but at least one.

    Args:
        root: The repository.
        file: The file.
        found: All possible changes of the file.
        meaning: Function that returns the meaning of a text. Changes with equal meanings count
            once. A change that does not alter the meaning of the file is not a mutant.
        one_of: On average, one out of this number of changes is taken. With 1 all changes are
            taken.
        seed: Seed of the sample.
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
    """Return a number from 0 to 1: a hash of the change, and of the function or entry around it."""
    where = mutant.pou.rpartition(":")[2]
    told = "\0".join((str(seed), where, mutant.operator, mutant.before, mutant.after))
    return int.from_bytes(blake2b(told.encode(), digest_size=8).digest(), "big") / 2**64
