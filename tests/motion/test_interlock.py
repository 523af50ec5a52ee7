"""FB_Interlock decides which robot may enter a shared area.

The tests set the data that the blocks read about each robot.
"""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from plc_bench import compiled

_ROBOTS = (1, 2, 3)
_NOT_CONNECTED, _NOT_READY, _SERVOS_OFF = 0x8001, 0x8002, 0x800C
_NOT_GRANTED, _KEPT, _INTRUDER = 0x8078, 0x8079, 0x807A


class Table:
    """Three robots at one shared area, whose blocks are called in this order every 10 ms.

    At first, all robots are outside of the area.
    """

    def __init__(self, engine: str = "auto", outside: bool = True) -> None:
        held = "".join(
            f"    Robot{k} : RCX_REF;\n    Lock{k} : FB_Interlock;\n    Skip{k} : BOOL;\n"
            f"    Twice{k} : BOOL;\n"
            for k in _ROBOTS
        )
        calls = "".join(
            f"  Robot{k}.Inner.Scan := Robot{k}.Inner.Scan + UINT#1;\n"
            f"  Robot{k}.Inner.Elapsed := UINT#10;\n"
            f"  IF NOT Skip{k} THEN\n    Lock{k}(Robot := Robot{k}, Area := Area);\n  END_IF;\n"
            f"  IF Twice{k} THEN\n    Lock{k}(Robot := Robot{k}, Area := Area);\n  END_IF;\n"
            for k in _ROBOTS
        )
        self._program = compiled(
            f"PROGRAM Table\n  VAR\n    Area : RCX_SHARED_AREA;\n{held}  END_VAR\n"
            f"{calls}END_PROGRAM\n",
            engine,
        )
        self._now_us = 0
        for k in _ROBOTS:
            self.ready(k)
            self[f"Lock{k}.Outside"] = outside

    def __getitem__(self, path: str) -> object:
        return self._program.read(f"Main.{path}")

    def __setitem__(self, path: str, value: bool | int | str) -> None:
        self._program.write(f"Main.{path}", value)

    def ready(self, robot: int) -> None:
        """Set link, CPU_OK and servos."""
        for name in ("Connected", "SO.SO01_CpuOk", "SO.SO02_ServoOn"):
            self[f"Robot{robot}.{name}"] = True

    def scan(self, count: int = 1) -> str:
        """Run scans, and return the outputs of the three blocks after the last scan."""
        for _ in range(count):
            self._program.scan(self._now_us)
            self._now_us += 10_000
        return self.shown

    @property
    def shown(self) -> str:
        """Return V (Valid), B (Busy), E (Error) or - per robot, with * for a holder."""
        letters = []
        for k in _ROBOTS:
            on = [name[0] for name in ("Valid", "Busy", "Error") if self[f"Lock{k}.{name}"]]
            letters.append(("".join(on) or "-") + "*" * bool(self[f"Lock{k}.Holds"]))
        return " ".join(letters)

    def error(self, robot: int) -> object:
        """Return the ErrorID of a robot."""
        return self[f"Lock{robot}.ErrorID"]

    def want(self, *robots: int) -> None:
        """Set Enable of these robots in this order, in successive scans."""
        for one in robots:
            self[f"Lock{one}.Enable"] = True
            self.scan()

    def leave(self, robot: int) -> None:
        """Set Enable of this robot's block to FALSE."""
        self[f"Lock{robot}.Enable"] = False
        self.scan()

    def acknowledge(self, robot: int) -> None:
        """Press Acknowledge for one scan."""
        self[f"Lock{robot}.Acknowledge"] = True
        self.scan()
        self[f"Lock{robot}.Acknowledge"] = False


def _table(*wanting: int, engine: str = "auto") -> Table:
    """Return a table in which these robots have requested the area, in this order."""
    table = Table(engine)
    assert table.scan(2) == "- - -"
    table.want(*wanting)
    return table


@pytest.mark.parametrize("engine", ["auto", "builtin"])
def test_first_come_first_served(engine: str) -> None:
    """Source: a rule of this library."""
    table = _table(engine=engine)
    table.want(3, 1, 2)
    assert table.shown == "B B V*"
    table.leave(3)
    assert table.scan() == "V* B -"
    table.want(3)
    assert table.shown == "V* B B"
    table.leave(1)
    assert table.shown == "- V* B"
    table.leave(2)
    assert table.shown == "- - V*"
    table.leave(3)
    assert table.shown == "- - -"
    assert table["Area.Holders"] == 0


def test_a_grant_and_a_release_take_no_scan() -> None:
    table = _table()
    table["Lock1.Enable"] = True
    assert table.scan() == "V* - -"
    table["Lock2.Enable"] = True
    assert table.scan() == "V* B -"
    table["Lock1.Enable"] = False
    assert table.scan() == "- V* -"


@pytest.mark.parametrize("scans", range(5))
def test_the_first_that_waits_is_let_in_at_once_however_long_it_waited(scans: int) -> None:
    table = _table(3, 1, 2)
    assert table.scan(scans) == "B B V*"
    table.leave(3)
    assert table.scan() == "V* B -"


def test_two_that_ask_in_the_same_scan_are_served_in_the_order_of_their_calls() -> None:
    table = _table()
    table["Lock2.Enable"] = table["Lock3.Enable"] = True
    assert table.scan() == "- V* B"


def test_it_is_held_until_the_robot_is_outside() -> None:
    table = _table(1, 2)
    table["Lock1.Outside"] = False
    assert table.scan() == "V* B -"
    table.leave(1)
    assert table.scan(5) == "-* B -"
    table["Lock1.Outside"] = True
    assert table.scan() == "- V* -"


def test_a_robot_that_is_outside_keeps_the_area_until_enable_falls() -> None:
    """Outside alone does not release the area: the robot may just be entering, with a grant."""
    table = _table(1, 2)
    for outside in (False, True):
        table["Lock1.Outside"] = outside
        assert table.scan(3) == "V* B -"


def test_after_a_start_of_the_plc_no_place_is_known_until_it_is_shown() -> None:
    table = Table(outside=False)
    table["Lock1.Enable"] = True
    assert table.scan(5) == "B* -* -*"
    table["Lock2.Outside"] = True
    assert table.scan() == "B* - -*"
    table["Lock3.Outside"] = True
    table.scan()
    assert table.scan() == "V* - -"


def test_in_the_first_scan_no_robot_gets_the_area() -> None:
    """In the first scan no robot gets the area.

    Blocks that are called later may still report that their robot holds it.
    """
    table = Table()
    table["Lock1.Enable"] = True
    table["Lock3.Outside"] = False
    assert table.scan() == "B* -* -*"
    assert table.scan(3) == "B - -*"


def test_two_that_may_both_be_inside_wait_for_each_other_until_one_is_outside() -> None:
    table = Table(outside=False)
    table["Lock3.Outside"] = True
    table["Lock1.Enable"] = table["Lock2.Enable"] = True
    assert table.scan(5) == "B* B* -"
    table["Lock2.Outside"] = True
    table.scan()
    assert table.scan() == "V* B -"


def test_a_robot_inside_comes_before_those_that_wait() -> None:
    """A robot inside gets the area first, because the others wait for it to leave."""
    table = Table(outside=False)
    table["Lock1.Outside"] = table["Lock3.Outside"] = True
    table.scan(2)
    table.want(1, 3)
    assert table.shown == "B -* B"
    table.want(2)
    assert table.shown == "B V* B"
    table["Lock2.Outside"] = True
    table.leave(2)
    assert table.scan() == "V* - B"
    table.leave(1)
    assert table.shown == "- - V*"


@pytest.mark.parametrize(
    ("signal", "number"),
    [
        ("Connected", _NOT_CONNECTED),
        ("SO.SO01_CpuOk", _NOT_READY),
        ("SO.SO02_ServoOn", _SERVOS_OFF),
    ],
)
def test_a_robot_lost_in_the_area_holds_it_until_acknowledge(signal: str, number: int) -> None:
    """Source: a rule of this library; link loss: manual chapter 1, 5.2."""
    table = _table(1, 2)
    table[f"Robot1.{signal}"] = False
    assert table.scan() == "E* B -"
    assert (table.error(1), table["Lock1.Kept"]) == (number, True)
    table.ready(1)
    table.scan(2)
    assert table.error(1) == number, "the first error stays"
    table.leave(1)
    table.ready(1)
    assert table.scan(9) == "-* B -"
    table.want(1)
    assert table.shown == "E* B -"
    assert table.error(1) == _KEPT
    table.acknowledge(1)
    assert table.scan(3) == "E V* -", "an error stays until Enable falls"
    assert table["Lock1.Kept"] is False
    table.leave(1)
    assert table.shown == "- V* -"


def test_a_robot_in_the_area_without_enable_holds_it() -> None:
    """A robot in the area without Enable holds the area until it is outside.

    Its link is lost in the meantime.
    """
    table = _table(1)
    table["Lock1.Outside"] = False
    table.leave(1)
    assert table.shown == "-* - -"
    table["Robot1.Connected"] = False
    table.scan()
    table.ready(1)
    table["Lock1.Outside"] = True
    assert table.scan(3) == "-* - -"
    assert table["Lock1.Kept"] is True
    table.acknowledge(1)
    assert table.shown == "- - -"


def test_acknowledge_does_not_release_a_robot_that_is_not_outside() -> None:
    table = _table(1, 2)
    table["Lock1.Outside"] = False
    table.scan()
    table["Robot1.Connected"] = False
    table.leave(1)
    table.acknowledge(1)
    assert table.shown == "-* B -"
    assert table["Lock1.Kept"] is False
    table["Lock1.Outside"] = True
    assert table.scan() == "- V* -"


def test_an_acknowledge_that_was_true_before_the_loss_has_no_effect() -> None:
    table = _table(1)
    table["Lock1.Acknowledge"] = True
    table.scan()
    table["Robot1.Connected"] = False
    table.leave(1)
    assert table.scan(3) == "-* - -"
    assert table["Lock1.Kept"] is True


def test_after_an_acknowledged_loss_the_robot_inside_gets_it_back_with_a_new_enable() -> None:
    table = _table(1, 2)
    table["Lock1.Outside"] = table["Robot1.SO.SO02_ServoOn"] = False
    table.scan()
    table.leave(1)
    table.ready(1)
    table.acknowledge(1)
    table.want(1)
    assert table.shown == "V* B -"


def test_a_loss_outside_keeps_nothing() -> None:
    table = _table()
    table["Robot1.Connected"] = False
    table.want(1, 2)
    assert table.shown == "E V* -"
    table["Robot2.Connected"] = False
    table["Lock3.Enable"] = True
    assert table.scan() == "E E* B"
    assert (table.error(1), table["Lock1.Kept"], table["Lock2.Kept"]) == (0x8001, False, True)


def test_a_waiting_robot_that_is_lost_gives_its_place_up() -> None:
    table = _table(1, 2, 3)
    table["Robot2.SO.SO02_ServoOn"] = False
    table.scan()
    table.leave(1)
    assert table.scan(3) == "- E V*"
    assert table.error(2) == _SERVOS_OFF


def test_an_unknown_position_counts_as_inside() -> None:
    """If the position becomes unknown, the robot counts as inside.

    A lost link makes the position bits FALSE. The earlier position, outside, is not used.
    """
    table = _table()
    table["Robot2.Connected"] = table["Lock2.Outside"] = False
    assert table.scan() == "- -* -"
    table.want(1)
    assert table.shown == "B -* -"
    table.ready(2)
    table["Lock2.Outside"] = True
    table.scan()
    assert table.scan() == "V* - -"


def test_a_waiting_robot_that_enters_is_an_error_and_takes_valid_away() -> None:
    table = _table(1, 2)
    table["Lock2.Outside"] = False
    table.scan()
    assert table.scan() == "B* E* -"
    assert table.error(2) == _INTRUDER
    table["Lock2.Outside"] = True
    table.scan()
    assert table.scan() == "V* E -"
    assert table["Lock1.Kept"] is table["Lock2.Kept"] is False


def test_the_wait_for_the_area_ends_after_timeout() -> None:
    """If the area stays occupied, the wait ends in an error after Timeout (300 ms, 30 scans)."""
    table = _table()
    table["Lock2.Timeout"] = "T#300ms"
    table.want(1, 2, 3)
    table["Lock2.Timeout"] = "T#0s"  # Timeout was sampled when Enable rose
    assert table.scan(28) == "V* B B"
    assert table.scan() == "V* E B"
    assert table.error(2) == _NOT_GRANTED
    table.leave(1)
    assert table.scan(2) == "- E V*"
    table.leave(2)
    assert table.shown == "- - V*"


@pytest.mark.parametrize(
    ("limit", "scans"),
    [("T#1ms", 1), ("T#300ms", 30), ("T#301ms", 31), ("", 6000), ("T#0s", None)],
)
def test_a_time_limit_counts_from_the_scan_of_the_request(limit: str, scans: int | None) -> None:
    """The wait ends in the 10 ms scan in which the limit is reached.

    The default limit is one minute; T#0s means no limit.
    """
    table = _table()
    if limit:
        table["Lock2.Timeout"] = limit
    table.want(1, 2)
    assert table.scan((scans or 9000) - 1) == "V* B -"
    assert table.scan() == ("V* E -" if scans else "V* B -")


def test_a_limit_counts_anew_for_each_wait() -> None:
    table = _table()
    table["Lock1.Timeout"] = "T#100ms"
    table.want(2, 1)
    assert table.scan(8) == "B V* -"
    table.leave(2)
    assert table.scan(30) == "V* - -"
    table["Lock3.Outside"] = False
    table.scan()
    assert table.scan(10) == "B* - -*"
    assert table.scan() == "E* - -*"
    table["Lock3.Outside"] = True
    assert table.scan(3) == "E - -", "the robot was outside and has no grant any more"


def test_a_waiting_robot_that_is_not_called_any_more_is_passed_over() -> None:
    table = _table(1, 2, 3)
    table["Skip2"] = True
    table.scan(3)
    table.leave(1)
    assert table.scan() == "- B V*", "block 2 shows its outputs of the last call"


@pytest.mark.parametrize("number", [100, 65_531])
def test_a_waiting_robot_that_was_not_called_goes_to_the_end_of_the_queue(number: int) -> None:
    """A robot that is not called for a while goes to the end of the queue.

    This includes scan numbers that restart at 0 with the next call.
    """
    table = _table()
    table["Robot2.Inner.Scan"] = number
    table.want(1, 2, 3)
    table["Skip2"] = True
    table.scan()
    table["Skip2"] = False
    table.scan()
    table.leave(1)
    assert table.scan(3) == "- B V*"
    table.leave(3)
    assert table.scan() == "- V* -"


def test_a_robot_in_the_area_that_is_no_longer_called_holds_it() -> None:
    """If the block of a robot in the area is no longer called, the robot still holds the area."""
    table = _table(1, 2)
    table["Skip1"] = True
    assert table.scan(50) == "V* B -"
    table["Skip1"] = table["Lock1.Enable"] = False
    assert table.scan() == "- V* -"


def test_a_request_that_is_given_up_costs_the_next_one_nothing() -> None:
    table = _table(1, 2, 3)
    table.leave(2)
    table.leave(1)
    assert table.scan(2) == "- - V*"


def test_requests_that_are_given_up_in_one_scan_cost_nothing_either() -> None:
    table = _table(1, 2, 3)
    for k in _ROBOTS:
        table[f"Lock{k}.Enable"] = False
    assert table.scan() == "- - -"
    table.want(1)
    assert table.shown == "V* - -"


@pytest.mark.parametrize("pause", [1, 2])
def test_a_robot_that_waits_again_does_not_delay_the_first(pause: int) -> None:
    """If a robot requests the area again, its earlier place in the queue has no effect.

    The area passes to the first robot of the queue in this scan.
    """
    table = _table(2, 3, 1)
    table["Lock1.Enable"] = False
    table.scan(pause)
    table["Lock1.Enable"], table["Lock2.Enable"] = True, False
    assert table.scan() == "B - V*"


def _with_a_fourth_robot() -> Table:
    """Return a table in which a fourth robot holds the area, and robots 1, 3 and 2 wait for it."""
    table = _table()
    table["Area.Holders"] = 1
    table.want(1, 3, 2)
    assert table.shown == "B B B"
    return table


def test_if_the_first_is_not_called_any_more_the_others_keep_their_order() -> None:
    table = _with_a_fourth_robot()
    table["Skip1"] = True
    table.scan(3)
    table["Area.Holders"] = 0
    assert table.scan() == "B B V*"
    table.leave(3)
    assert table.scan() == "B V* -"


def test_if_the_first_robot_gives_up_the_next_one_follows_in_the_same_scan() -> None:
    """If the first robot of the queue gives up, the next robot moves up in the same scan.

    No other robot can take the free area in between.
    """
    table = _with_a_fourth_robot()
    table["Area.Holders"] = 0
    table.leave(1)
    assert table.shown == "- B V*"


@pytest.mark.parametrize("skipped", [False, True])
def test_any_number_of_requests_that_have_gone_cost_three_scans_at_most(skipped: bool) -> None:
    table = _table(1, 2, 3)
    for _ in range(40):
        table.leave(2)
        table.want(2)
    table["Skip2"] = skipped
    table.leave(3)
    table.want(3)
    table.leave(2)
    table["Lock1.Enable"] = False
    assert "V*" in table.scan(4)
    assert table["Lock3.Valid"]


def test_tickets_begin_again_after_the_largest() -> None:
    table = _table()
    table["Area.First"] = table["Area.NextTicket"] = 4_294_967_295
    table.want(2, 3, 1)
    assert table.shown == "B V* B"
    table.leave(2)
    assert table.scan() == "B - V*"
    table.leave(3)
    assert table.scan() == "V* - -"


def test_enable_in_every_second_scan_takes_no_place_of_another_robot() -> None:
    table = _table(1, 2)
    for on in (True, False) * 5:
        table["Lock3.Enable"] = on
        table.scan()
    table.leave(1)
    assert table.shown == "- V* -"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_block_that_is_called_twice_in_a_scan_is_an_error(engine: str) -> None:
    """A second call in a scan is an error: it would double the speed of the Timeout.

    The robot would also lose its place in the queue each time.

    Source: docs/reference/errors.md, 16#8016; head: called once in every scan
    """
    table = _table(engine=engine)
    table["Twice3"] = True
    assert table.scan(5) == "- - -", "a block without a request does not matter"
    table["Twice3"] = False
    table.want(1, 2)
    assert table.shown == "V* B -"
    for k, shown in ((2, "V* E -"), (1, "E E -")):
        table[f"Twice{k}"] = True
        assert table.scan() == shown
        table[f"Twice{k}"] = False
        assert table.scan(3) == shown
        assert table.error(k) == 0x8016
    table.leave(2)
    table.want(2)
    assert table.scan() == "E V* -"
