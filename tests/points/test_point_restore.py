"""FB_PointRestore writes rows, reports differences, and can be interrupted and continued."""

from __future__ import annotations

from typing import Any

import pytest

from both_engines import ENGINES
from points_bench import PointsBench, points_bench, record

#: Words n+2, n+6 to n+30 of the manual's point 100 in pulses: 10000, -20000, 5000, -18000.
POINT_100 = [0, 0, 0x2710, 0, 0xB1E0, 0xFFFF, 0x1388, 0, 0xB9B0, 0xFFFF, 0, 0, 0, 0]
WAIT_ORG = [0, 0, 0x4157, 0x5449, 0x4F20, 0x4752, *[0x2020] * 4, 0, 0, 0, 0]


@pytest.fixture(params=ENGINES)
def plc(request: pytest.FixtureRequest) -> PointsBench:
    return points_bench(request.param)


@pytest.mark.parametrize(
    ("kind", "robot", "code", "number", "words"),
    [
        ("POINTS", 0, 0x100, 100, POINT_100),
        ("POINTS", 0, 0x100, 29_999, [0x0785, *[0x8000] * 13]),
        ("COMMENTS", 0, 0x104, 100, WAIT_ORG),
        ("SHIFTS", 0, 0x10C, 5, [*POINT_100[:10], 0, 0, 0, 0]),
        ("HANDS", 0, 0x110, 1, [0, 0, 0x2710, 0, 0xF830, 0xFFFF, 0x1388, *[0] * 7]),
        ("HANDS", 3, 0x3110, 1, [0, 0, 0x2710, 0, 0xF830, 0xFFFF, 0x1388, 0, 1, *[0] * 5]),
        ("PALLETS", 0, 0x108, 10, [0, 10, 15, 1, 100, *[0] * 9]),
    ],
)
def test_rows_are_written_with_the_telegrams_of_the_manual(
    plc: PointsBench, kind: str, robot: int, code: int, number: int, words: list[int]
) -> None:
    """Source: guide 4.3.1 to 4.3.5, the examples of the definitions."""
    words = [words[0], 0 if code != 0x108 else words[1], *words[2:]]
    plc.stored[code, number] = words
    assert plc.run("Backup", Kind=f"DATA_{kind}", RobotNumber=robot, First=number, Count=1) == 0
    plc.stored.clear()
    plc.sent.clear()
    assert plc.run("Restore") == 0
    assert plc.sent == [[code, words[0], number, *words[1:]]]
    assert plc.stored == {(code, number): words}
    assert plc["Restore.Number"] == number


def test_a_row_that_is_not_defined_is_not_written(plc: PointsBench) -> None:
    """Source: guide 4.3: there is no command that deletes."""
    record(plc, missing=12)
    tickets = plc["Robot.Inner.Command.NextTicket"]
    assert plc.run("Restore") == 0
    assert [words[:3] for words in plc.sent] == [[0x100, 1, n] for n in (10, 11, 13)]
    assert plc["Robot.Inner.Command.NextTicket"] - tickets == 3, (
        "the block takes no ticket for an undefined row"
    )


def test_a_record_of_a_hundred_rows_is_carried_whole(plc: PointsBench) -> None:
    record(plc, first=29_900, count=100)
    assert plc.run("Restore", most=1200) == 0
    assert {number: words[2] for (_, number), words in plc.stored.items()} == {
        number: number for number in range(29_900, 30_000)
    }
    plc.sent.clear()
    assert plc.run("Restore", most=1200, CompareOnly=True) == 0
    assert plc["Restore.Differences"] == 0
    assert [words[:3] for words in plc.sent] == [[0x101, 0, n] for n in range(29_900, 30_000)]


_DAMAGE: list[tuple[str, Any]] = [
    ("Rows[1].Defined", False),
    ("Rows[2].Flag", 3),
    ("Rows[4].Flag", 0x8001),
    *((f"Rows[3].Values[{axis}]", 0x01000000) for axis in range(1, 7)),
    ("Rows[1].Values[6]", -1),
    ("Head.Checksum", 0),
    ("Head.First", 11),
    ("Head.Count", 3),
    ("Head.Count", 5),
    ("Head.Kind", "DATA_COMMENTS"),
]


@pytest.mark.parametrize(("place", "value"), _DAMAGE)
def test_nothing_is_written_from_a_record_that_was_changed(
    plc: PointsBench, place: str, value: Any
) -> None:
    record(plc)
    plc[place] = value
    for compare_only in (False, True):
        assert plc.run("Restore", CompareOnly=compare_only) == 0x8068
        assert plc.sent == []
        assert plc["Restore.Row"] == 1


def test_the_robot_of_hands_belongs_to_therecord(plc: PointsBench) -> None:
    plc.stored[0x1110, 0] = [0, 0, 5, *[0] * 11]
    assert plc.run("Backup", Kind="DATA_HANDS", RobotNumber=1, First=0, Count=1) == 0
    plc["Head.RobotNumber"] = 2
    assert plc.run("Restore") == 0x8068


@pytest.mark.parametrize(
    ("change", "error", "row"),
    [
        ({"Head.Count": 0}, 0x8044, 1),
        ({"Head.Count": 101}, 0x8044, 1),
        ({"Head.First": -1}, 0x8044, 1),
        ({"Head.First": 32_767}, 0x8044, 1),
        ({"Head.RobotNumber": 5, "Restore.FirstRow": 3}, 0x8040, 3),
        ({"Head.RobotNumber": 5, "Restore.FirstRow": 101}, 0x8040, 1),
        ({"Head.Count": 0, "Connected": False}, 0x8044, 1),
        ({"Restore.FirstRow": 0}, 0x8044, 1),
        ({"Restore.FirstRow": 5}, 0x8044, 5),
        ({"Restore.FirstRow": 100}, 0x8044, 100),
        ({"Restore.FirstRow": 101}, 0x8044, 1),
    ],
)
def test_a_head_or_a_first_row_that_does_not_exist_is_refused(
    plc: PointsBench, change: dict[str, Any], error: int, row: int
) -> None:
    """An illegal head or FirstRow is refused, and Row stays a legal index of the array."""
    record(plc)
    for place, value in change.items():
        plc[place] = value
    assert plc.run("Restore", most=1) == error
    assert plc.sent == []
    assert plc["Restore.Row"] == row


def test_a_restore_interrupted_during_its_check_can_start_at_first_row_again(
    plc: PointsBench,
) -> None:
    """If the link is lost during the check, Row is FirstRow again, so no row is left out."""
    record(plc, count=9)
    plc["Restore.FirstRow"] = 2
    plc.scan_until(lambda: plc["Restore.Row"] == 7, execute="Restore")
    plc.change("Connected", to=False)
    assert (plc["Restore.ErrorID"], plc["Restore.Row"]) == (0x8001, 2)
    assert plc["Restore.Number"] == 11, "row 1 is point 10"


@pytest.mark.parametrize("row", [3, 7])
def test_a_controller_that_is_no_longer_ready_ends_the_check(plc: PointsBench, row: int) -> None:
    """Source: docs/reference/errors.md, 16#8002."""
    record(plc, count=9)
    plc.scan_until(lambda: plc["Restore.Row"] == row, execute="Restore")
    plc.outputs(SO01=False, scans=1)
    assert (plc["Restore.ErrorID"], plc["Restore.Row"]) == (0x8002, 1)
    assert plc["Restore.Number"] == 10


def test_an_array_that_was_never_filled_is_refused(plc: PointsBench) -> None:
    assert (plc["Restore.Row"], plc["Backup.Row"]) == (1, 1), (
        "Row is a legal index of the array from the start"
    )
    assert plc.run("Restore", most=1) == 0x8044
    assert plc["Restore.LastDifferent"] == -1


_DIFFERENT: list[tuple[str, int]] = [("Flag", 2), *((f"Values[{k}]", 1000) for k in range(1, 7))]


@pytest.mark.parametrize(("field", "value"), _DIFFERENT)
def test_a_difference_in_any_field_is_detected(plc: PointsBench, field: str, value: int) -> None:
    """Source: guide 4.3.1: flag, and the data of six axes."""
    record(plc)
    assert plc.run("Restore") == 0
    place = 0 if field == "Flag" else 2 * int(field[7])
    plc.stored[0x100, 12][place] = value
    plc.sent.clear()
    assert plc.run("Restore", CompareOnly=True) == 0
    assert (plc["Restore.Differences"], plc["Restore.LastDifferent"]) == (1, 12)
    assert plc.codes == [0x101] * 4


@pytest.mark.parametrize("place", [0, 3, 5, 7, 9, 11, 13])
def test_a_lower_value_in_the_controller_counts_as_a_difference(
    plc: PointsBench, place: int
) -> None:
    """A value that is lower in the controller than in the record also counts as a difference.

    The flag is 0 instead of 1, or a value is negative instead of positive.

    Source: guide 4.3.1: flag, and the data of six axes as double words with a sign.
    """
    record(plc)
    assert plc.run("Restore") == 0
    plc.stored[0x100, 12][place] = 0xFFFF if place else 0
    assert plc.run("Restore", CompareOnly=True) == 0
    assert (plc["Restore.Differences"], plc["Restore.LastDifferent"]) == (1, 12)


@pytest.mark.parametrize("kept", [False, True])
def test_a_point_of_zeros_differs_from_a_missing_point(plc: PointsBench, kept: bool) -> None:
    """A point with only zeros differs from a missing point.

    Either only the record has the point, or only the controller has it.

    Source: docs/how-to/points.md: a number that is not defined is a row with Defined FALSE.
    """
    zeros = [0] * 14
    if kept:
        plc.stored[0x100, 10] = zeros
    assert plc.run("Backup", First=10, Count=1) == 0
    plc.stored.clear()
    if not kept:
        plc.stored[0x100, 10] = zeros
    assert plc.run("Restore", CompareOnly=True) == 0
    assert (plc["Restore.Differences"], plc["Restore.LastDifferent"]) == (1, 10)


def test_number_always_names_the_point_in_row(plc: PointsBench) -> None:
    """Source: docs/reference/blocks/FB_PointRestore.md, Number; point 10 is in row 1."""
    record(plc)
    plc.scan_until(lambda: len(plc.sent) == 1, execute="Restore")
    seen = []
    while plc["Restore.Busy"]:
        seen.append((plc["Restore.Row"], plc["Restore.Number"]))
        plc.scan()
    assert list(dict.fromkeys(seen)) == [(1, 10), (2, 11), (3, 12), (4, 13)]
    assert (plc["Restore.Done"], plc["Restore.Row"], plc["Restore.Number"]) == (True, 1, 10)


@pytest.mark.parametrize("compares", [False, True])
@pytest.mark.parametrize("first", [1, 3])
def test_row_is_1_again_in_the_scan_of_done(plc: PointsBench, compares: bool, first: int) -> None:
    """In the scan of Done, Row is 1, so a start with FirstRow := Row writes all rows again.

    A start that only reports Done without work would look like a restore.

    Source: comments of Row and FirstRow
    """
    record(plc)
    plc["Restore.FirstRow"], plc["Restore.CompareOnly"] = first, compares
    plc.scan_until(lambda: bool(plc["Restore.Done"]), execute="Restore")
    assert (plc["Restore.Row"], plc["Restore.Number"]) == (1, 10)
    plc.change("Restore.Execute", to=False, scans=3)
    assert plc["Restore.Row"] == 1
    plc.stored.clear()
    plc.sent.clear()
    assert plc.run("Restore", FirstRow=plc["Restore.Row"], CompareOnly=False) == 0
    assert [words[2] for words in plc.sent] == [10, 11, 12, 13]


def test_a_comparison_names_every_row_that_differs(plc: PointsBench) -> None:
    """A comparison reports every row that differs or is missing on one side."""
    record(plc, missing=11)
    assert plc.run("Restore") == 0
    plc.stored[0x100, 11] = list(POINT_100)
    del plc.stored[0x100, 12]
    plc.stored[0x100, 13][3] = 1
    plc["Restore.CompareOnly"] = True
    plc["Restore.Execute"] = True
    named = []
    for _ in range(60):
        plc.scan()
        if plc["Restore.Different"]:
            named.append((plc["Restore.LastDifferent"], plc["Restore.Differences"]))
    assert named == [(11, 1), (12, 2), (13, 3)]
    assert plc["Restore.Done"] is True
    plc.change("Restore.Execute", to=False, scans=3)
    # afterwards a comparison without differences resets the outputs
    assert plc.run("Restore", CompareOnly=False) == 0
    assert (plc["Restore.Differences"], plc["Restore.LastDifferent"]) == (0, -1)
    assert plc["Restore.Different"] is False


def test_pallets_and_comments_are_compared_as_they_are_stored(plc: PointsBench) -> None:
    """Pallets and comments are compared as the controller stores them.

    A comment filled with zeros equals a comment filled with spaces. Source: guide 4.3.2.
    """
    plc.stored[0x104, 3] = [0, 0, 0x4157, *[0x2020] * 7, 0, 0, 0, 0]
    assert plc.run("Backup", Kind="DATA_COMMENTS", First=3, Count=1) == 0
    plc.stored[0x104, 3] = [0, 0, 0x4157, *[0] * 11]
    assert plc.run("Restore", CompareOnly=True) == 0
    assert plc["Restore.Differences"] == 0


def test_a_restore_stops_at_a_refused_point_and_can_continue_there(plc: PointsBench) -> None:
    """If a row is refused, the block ends at this row and can be continued there.

    In this test the pendant (programming box) has the control authority: alarm 12.76.

    Source: guide chapter 1, 1.2, code 0x4000.
    """
    record(plc)
    plc.refuses[12] = (12, 76)
    assert plc.run("Restore") == 0x8020
    assert (plc["Restore.Row"], plc["Restore.Number"]) == (3, 12)
    assert [words[2] for words in plc.sent] == [10, 11, 12]

    plc.refuses.clear()
    plc.sent.clear()
    assert plc.run("Restore", FirstRow=plc["Restore.Row"]) == 0
    assert [words[:3] for words in plc.sent] == [[0x100, 1, 12], [0x100, 1, 13]]


def test_the_alarm_of_a_write_is_never_taken_for_a_missing_point(plc: PointsBench) -> None:
    record(plc)
    plc.refuses[10] = (6, 204)
    plc.scan_until(lambda: bool(plc["Restore.Error"]), execute="Restore")
    assert plc["Restore.ErrorID"] == 0x8020
    plc.scan(2)
    assert (plc["Restore.AlarmGroup"], plc["Restore.AlarmCategory"]) == (6, 204)


def test_a_lost_link_ends_the_block_and_nothing_restarts_by_itself(plc: PointsBench) -> None:
    """Source: manual chapter 1, 5.2."""
    record(plc)
    plc.scan_until(lambda: len(plc.sent) == 2, execute="Restore")
    plc.change("Connected", to=False, scans=3)
    assert (plc["Restore.ErrorID"], plc["Restore.Row"]) == (0x8001, 2)
    plc.change("Connected", to=True, scans=60)
    assert len(plc.sent) == 2
    plc.change("Restore.Execute", to=False, scans=2)
    assert plc.run("Restore", FirstRow=2) == 0
    assert [words[2] for words in plc.sent] == [10, 11, 11, 12, 13]


def test_a_link_lost_for_one_scan_between_two_rows_ends_the_block(plc: PointsBench) -> None:
    """If the link is lost for one scan between two rows, the block does not write the next row.

    Source: manual chapter 1, 5.2.
    """
    record(plc)
    plc.scan_until(lambda: len(plc.sent) == 1, execute="Restore")
    plc.scan_until(lambda: plc["Restore.Row"] == 2)
    plc.change("Connected", to=False)
    assert plc["Restore.ErrorID"] == 0x8001
    plc.change("Connected", to=True, scans=20)
    assert [words[2] for words in plc.sent] == [10]


def test_head_and_inputs_are_sampled_at_the_rising_edge(plc: PointsBench) -> None:
    """Source: PLCopen, edge-triggered blocks."""
    record(plc)
    plc["Restore.FirstRow"] = 3
    plc.change("Restore.Execute", to=True)
    plc["Restore.FirstRow"], plc["Restore.CompareOnly"] = 1, True
    plc["Head.Count"], plc["Head.First"], plc["Head.Checksum"] = 1, 90, 0
    plc.change("Restore.Execute", to=False)
    plc.scan_until(lambda: not plc["Restore.Busy"], execute="Restore")
    assert plc["Restore.Done"] is True
    assert [words[:3] for words in plc.sent] == [[0x100, 1, 12], [0x100, 1, 13]]


def test_a_pulse_of_execute_is_enough(plc: PointsBench) -> None:
    """Source: PLCopen, edge-triggered blocks."""
    record(plc)
    plc.change("Restore.Execute", to=True)
    plc["Restore.Execute"] = False
    plc.scan_until(lambda: bool(plc["Restore.Done"]))
    plc.scan(10)
    assert (plc["Restore.Done"], plc["Restore.Busy"], plc["Restore.Row"]) == (False, False, 1)
    assert [words[:3] for words in plc.sent] == [[0x100, 1, n] for n in (10, 11, 12, 13)]


def test_a_comparison_started_by_a_pulse_shows_its_progress(plc: PointsBench) -> None:
    """A comparison started by a pulse of Execute counts its differences while it runs.

    The controller no longer has any of the four points. Source: PLCopen, edge-triggered blocks.
    """
    record(plc)
    plc["Restore.CompareOnly"], plc["Restore.Execute"] = True, True
    plc.scan()
    plc["Restore.Execute"] = False
    seen = []
    while plc["Restore.Busy"]:
        assert plc["Restore.Active"] or not plc.words[0], "a code is on the wire"
        plc.scan()
        if plc["Restore.Different"]:
            seen.append(plc["Restore.LastDifferent"])
    assert seen == [10, 11, 12, 13]


def test_changing_a_row_during_its_command_does_not_change_the_command(plc: PointsBench) -> None:
    """Source: guide chapter 2: data and code are held unchanged until the end."""
    record(plc)
    plc.scan_until(lambda: len(plc.sent) == 1, execute="Restore")
    plc["Rows[1].Defined"] = False
    plc["Rows[1].Values[1]"] = 7
    plc.silent = True
    plc.scan(5)
    assert plc["Restore.Row"] == 1, "the command is still on the wire"
    plc.silent = False
    plc.scan_until(lambda: plc["Restore.Row"] == 2)
    assert plc.stored[0x100, 10] == [1, 0, 10, 0, *[0] * 10]


def test_a_row_changed_while_it_waits_is_written_with_the_old_values(
    plc: PointsBench,
) -> None:
    """If a row changes while the restore waits for the command words, the old values are written.

    The backup uses the command words meanwhile.
    """
    record(plc)
    plc.silent = True
    plc.refuses[500] = (12, 76)
    plc.change("Restore.Execute", to=True)
    plc["Backup.First"], plc["Backup.Count"], plc["Backup.Execute"] = 500, 1, True
    plc.scan(10)
    assert (plc["Restore.Busy"], plc["Restore.Active"]) == (True, False)
    assert (plc["Backup.Busy"], plc["Backup.Active"]) == (True, True)
    plc["Rows[1].Defined"] = False
    plc["Rows[1].Values[1]"] = 7
    plc.scan(5)
    assert (plc["Restore.Row"], plc["Restore.Number"]) == (1, 10)
    plc.silent = False
    plc.scan_until(lambda: bool(plc["Backup.Error"]))
    plc.scan_until(lambda: plc["Restore.Row"] == 2)
    assert plc.stored == {(0x100, 10): [1, 0, 10, 0, *[0] * 10]}


def test_a_comparison_after_a_refused_write_sends_no_flag(plc: PointsBench) -> None:
    """Source: guide 4.3.1, the reference: word n+2 is not used, 16#0000."""
    record(plc)
    plc.refuses[10] = (12, 76)
    assert plc.run("Restore") == 0x8020
    assert plc.sent == [[0x100, 1, 10, 0, 10, *[0] * 11]]
    plc.sent.clear()
    plc.refuses.clear()
    plc.stored[0x100, 10] = [1, 0, 10, 0, *[0] * 10]
    assert plc.run("Restore", CompareOnly=True) == 0
    assert plc.sent == [[0x101, 0, n, *[0] * 13] for n in (10, 11, 12, 13)]
    assert plc["Restore.Differences"] == 3


def test_after_a_head_that_was_refused_another_one_is_taken(plc: PointsBench) -> None:
    record(plc)
    plc["Head.Count"] = 0
    assert plc.run("Restore", most=1) == 0x8044
    plc["Head.Count"] = 4
    assert plc.run("Restore") == 0
    assert len(plc.sent) == 4
