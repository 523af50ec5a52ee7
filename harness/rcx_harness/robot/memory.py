"""What the controller stores: it survives a power cycle, and remote commands read and write it."""

from __future__ import annotations

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.numbers import fits_integer
from rcx_harness.robot.pallet import interpolated, weights
from rcx_harness.robot.parameters import Parameters
from rcx_harness.robot.stored import Hand, Pallet, Point, Shift
from rcx_harness.robot.variables import Variables

__all__ = ["Memory"]


class Memory:
    """All stored data by their numbers; robot 0 is robot 1.

    Attributes:
        points: Point data.
        comments: Point comments, without spaces at their ends.
        pallets: Pallet data.
        shifts: Shift data that were defined.
        hands: Hand data that were defined, by robot (1 to 4) and hand number.
        variables: Static variables.
        parameters: Parameters of robots and axes.
    """

    def __init__(self, config: RobotConfig) -> None:
        self.config = config
        self.points: dict[int, Point] = dict(config.points)
        self.comments: dict[int, str] = {n: text.rstrip() for n, text in config.comments.items()}
        self.pallets: dict[int, Pallet] = dict(config.pallets)
        self.shifts: dict[int, Shift] = dict(config.shifts)
        self.hands: dict[tuple[int, int], Hand] = dict(config.hands)
        self.variables = Variables(config)
        self.parameters = Parameters(config)

    def point(self, number: int) -> Point:
        """Point data.

        Raises:
            CommandError: the point is not defined.
        """
        if number not in self.points:
            raise CommandError(self.config.undefined_point_alarm)
        return self.points[number]

    def comment(self, number: int) -> str:
        """The comment of a point, whether the point is defined or not.

        Raises:
            CommandError: there is none, and the configuration has an alarm for it.
        """
        if number not in self.comments:
            self._undefined_data()
        return self.comments.get(number, "")

    def pallet(self, number: int) -> Pallet:
        """Pallet data.

        Raises:
            CommandError: the pallet is not defined.
        """
        if number not in self.pallets:
            raise CommandError(self.config.undefined_pallet_alarm)
        return self.pallets[number]

    def work_point(self, pallet: int, work: int) -> Point:
        """A work position of a pallet, with unit, hand and arm rotation of its first point.

        Args:
            pallet: Number of the pallet, 0 to 39.
            work: Number of the work position, from 1.

        Raises:
            CommandError: pallet, work position or a point that counts for it is not defined, or
                these points do not have the same unit.
        """
        found = self.pallet(pallet)
        if not 1 <= work <= found.count:
            raise CommandError(self.config.work_position_alarm)
        weight = weights(found, work)
        points = {offset: self.point(found.first + offset) for offset in weight}
        first = self.point(found.first)
        if any(point.mm != first.mm for point in points.values()):
            raise CommandError(self.config.point_unit_alarm)
        data = interpolated({offset: point.data for offset, point in points.items()}, weight)
        return self.changed(first, data)

    def changed(self, point: Point, data: tuple[int, ...]) -> Point:
        """A point with other data.

        Raises:
            CommandError: a value does not fit into 32 bits.
        """
        if not all(map(fits_integer, data)):
            raise CommandError(self.config.overflow_alarm)
        return Point(data, point.mm, point.hand, point.arm1, point.arm2)

    def shift(self, number: int) -> Shift:
        """Shift data; all 0 where none were defined. Shift 0 is there from the start.

        Raises:
            CommandError: there are none, and the configuration has an alarm for it.
        """
        if number and number not in self.shifts:
            self._undefined_data()
        return self.shifts.get(number, (0, 0, 0, 0))

    def hand(self, robot: int, number: int) -> Hand:
        """Hand data; all 0 where none were defined. Hand 0 is there from the start.

        Raises:
            CommandError: there are none, and the configuration has an alarm for it.
        """
        key = (robot or 1, number)
        if number and key not in self.hands:
            self._undefined_data()
        return self.hands.get(key, Hand())

    def _undefined_data(self) -> None:
        if self.config.undefined_data_alarm:
            raise CommandError(self.config.undefined_data_alarm)
