"""The robots of a recording for the page: shapes, poses, and the lanes of their positions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

from rcx_harness.trace.view.lanes import Lane

__all__ = ["Robots"]

_KINDS = ("scara", "cartesian", "axes")
_OF_AXIS = ("low", "high", "per", "zero")
_PLACE = range(3, 7)
_Shape = Mapping[str, Any]


class Robots:
    """The shapes and poses of the robots, for the page."""

    def __init__(
        self, shapes: Sequence[Sequence[_Shape]], lanes: Sequence[Sequence[Lane]], unit: str
    ) -> None:
        self._lanes, self._unit = lanes, unit
        self._shapes = [[_checked(shape) for shape in every] for every in shapes]
        for every, axes in zip(self._shapes, lanes, strict=True):
            if sum(len(shape["axes"]) for shape in every) != len(axes):
                raise ValueError("other axes than positions")
        self._poses: list[list[list[tuple[int, _Shape]]]] = [[[] for _ in one] for one in shapes]

    def take(self, t_us: int, controller: int, poses: Sequence[_Shape]) -> None:
        """Record the poses of the robots of a controller from `t_us` on."""
        for noted, pose in zip(self._poses[controller - 1], poses, strict=True):
            _numbers(pose.get("shift", [0.0] * 4), range(4, 5))
            _numbers(pose.get("hand", [0.0] * 4), range(4, 5))
            if not noted or noted[-1][1] != pose:
                noted.append((t_us, pose))

    def table(self, places: Mapping[int, int]) -> list[dict[str, Any]]:
        """Return the robots for the page; `places` has the number of each shown lane."""
        found = []
        for who, (every, lanes) in enumerate(zip(self._shapes, self._lanes, strict=True)):
            rest = iter(lanes)
            for shape, noted in zip(every, self._poses[who], strict=True):
                own = [places.get(id(next(rest))) for _ in shape["axes"]]
                if None in own:
                    continue  # no position was recorded
                words = [f"Controller {who + 1}"] if len(self._shapes) > 1 else []
                words.append(f"Robot {shape['robot']}")
                title = ", ".join([*words, shape["name"]] if shape.get("name") else words)
                entry = {"title": title, "unit": self._unit, "model": shape, "lanes": own}
                found.append({**entry, "poses": noted})
        return found


def _checked(shape: _Shape) -> _Shape:
    """Return the shape if the page can draw it, else raise KeyError, TypeError or ValueError."""
    kind, axes = shape["kind"], shape["axes"]
    if kind not in _KINDS or not axes or not isinstance(shape["robot"], int):
        raise ValueError("no robot")
    for axis in axes:
        _numbers([axis[key] for key in _OF_AXIS], range(4, 5))
        if axis["per"] == 0 or axis["low"] >= axis["high"]:
            raise ValueError("no axis")
    if kind == "scara":
        _numbers(shape["arms"], range(2, 3))
        if min(shape["arms"]) <= 0 or len(axes) == 1:
            raise ValueError("no arms")
    for point in shape.get("points", ()):
        _numbers([point["number"]], range(1, 2))
        _numbers(point["mm"] if "mm" in point else point["joints"], range(1, 7))
    for pallet in shape.get("pallets", ()):
        _numbers([pallet["number"]], range(1, 2))
        for place in (*pallet["corners"], *pallet["places"]):
            _numbers(place, _PLACE)
        if len(pallet["corners"]) != len("XYXY"):
            raise ValueError("no pallet")
    for area in shape.get("areas", ()):
        if not isinstance(area["name"], str) or len(area["from"]) != len(area["to"]):
            raise ValueError("no area")
        for corner in (area["from"], area["to"]):
            _numbers(corner, range(2, 4))
    return shape


def _numbers(values: Sequence[Any], how_many: range) -> None:
    """Raise TypeError or ValueError unless the values are a list of this many finite numbers."""
    if not isinstance(values, list) or len(values) not in how_many:
        raise TypeError("no numbers")
    for value in values:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
            raise ValueError("no number")
