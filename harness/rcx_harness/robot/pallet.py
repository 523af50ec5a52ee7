"""The work positions of a pallet, from the points that define it."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from rcx_harness.robot.numbers import nearest
from rcx_harness.robot.stored import Pallet

__all__ = ["interpolated", "weights"]


def weights(pallet: Pallet, work: int) -> Mapping[int, Fraction]:
    """How much each defining point counts for a work position.

    Args:
        pallet: Its work positions in X, Y and Z direction.
        work: Number of the work position from 1; X counts first, then Y, then Z.

    Returns:
        Weight by offset from the pallet's first point, without those that do not count: 0 is the
        first work position, 1 the end in X, 2 the end in Y, 3 the corner of both, 4 the end in Z.
    """
    rest, x = divmod(work - 1, pallet.nx)
    z, y = divmod(rest, pallet.ny)
    u, v, w = _share(x, pallet.nx), _share(y, pallet.ny), _share(z, pallet.nz)
    every = {0: (1 - u) * (1 - v) - w, 1: u * (1 - v), 2: v * (1 - u), 3: u * v, 4: w}
    return {offset: weight for offset, weight in every.items() if weight}


def interpolated(
    data: Mapping[int, tuple[int, ...]], weight: Mapping[int, Fraction]
) -> tuple[int, ...]:
    """The data of a work position per axis, from those of the points by offset."""
    axes = zip(*(data[offset] for offset in weight), strict=True)
    return tuple(
        nearest(sum((w * v for w, v in zip(weight.values(), axis, strict=True)), Fraction(0)))
        for axis in axes
    )


def _share(index: int, count: int) -> Fraction:
    """Part of the way from the first to the last of `count` positions."""
    return Fraction(index, count - 1) if count > 1 else Fraction(0)
