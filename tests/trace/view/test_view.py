"""A page of a recording shows the values of the records, here expected by hand."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from typing import Any

import pytest

from rcx_harness.trace import Cycle, Record, Scan, Violation
from rcx_harness.trace.view import BEGINNING
from rcx_harness.trace.view.page import View
from structured_text.errors import InputError
from view_page import PageContent

_HEADER: dict[str, Any] = {"format": "rcx-trace/1", "scan_us": 10_000, "size": 48, "seed": 0}


def _area(dedicated: int = 0, words: tuple[int, ...] = (), size: int = 48) -> bytes:
    area = bytearray(size)
    for k, one in enumerate(words):
        area[2 * k : 2 * k + 2] = one.to_bytes(2, "little")
    area[32:34] = dedicated.to_bytes(2, "little")
    return bytes(area)


def _scan(t_us: int, si: bytes = _area(), so: bytes = _area(), **more: Any) -> Scan:
    return Scan(t_us, t_us // 10_000, so, si, **more)


def _shown(*records: Record, **header: Any) -> PageContent:
    return PageContent(_page(*records, **header))


def _page(*records: Record, **header: Any) -> str:
    view = View({**_HEADER, **header})
    for record in records:
        view.take(record)
    return view.page("a run")


def test_signals_are_lanes_with_the_manuals_names_and_their_changes() -> None:
    """Each signal has a lane with its changes and its name in the manual.

    SI(00) is bit 0 of byte n+32, SO(02) is bit 2 of m+32.

    Source: manual chapter 5, 1.
    """
    page = _shown(_scan(0), _scan(10_000, si=_area(1)), _scan(20_000, _area(1), _area(4)))
    assert page.changes("SI(00) Emergency stop input") == [(-1, 0), (10_000, 1)]
    assert page.changes("SO(02) Servo ON status output") == [(-1, 0), (20_000, 1)]
    assert page.order() == ["SI(00) Emergency stop input", "SO(02) Servo ON status output"]
    names = page.groups()
    assert len(names["Dedicated inputs"]) == 9
    assert len(names["Dedicated outputs"]) == 11


def test_a_signal_that_is_on_at_first_is_no_event() -> None:
    page = _shown(_scan(5_000_000, si=_area(1)), _scan(5_010_000, si=_area(1)))
    assert page.changes("SI(00) Emergency stop input") == [(-1, 1)]
    assert (page.order(), page.table["begin"], page.table["end"]) == ([], 5_000_000, 5_010_000)


def test_telegrams_are_shown_as_text() -> None:
    """Telegrams are shown as text, here MOVE, PTP to point 19 at 50 %, and alarm 12.600.

    Source: guide 4.2.1; manual chapter 4, 4.
    """
    move = _area(words=(0x0001, 0x0004, 0, 50, 19))
    page = _shown(_scan(0), _scan(10_000, si=move), _scan(20_000, move, _area(words=(0x0100,))),
                  _scan(30_000, move, _area(words=(0x4000, 12, 600))), _scan(40_000))  # fmt: skip
    commands = page.changes("Remote command")
    assert [t_us for t_us, _ in commands] == [-1, 10_000, 40_000]
    assert commands[1][1].startswith("MovePtp (16#R001): MOVE, PTP")
    assert "point 19" in commands[1][1]
    texts = [text for _, text in page.changes("Remote status")]
    alarm = "abnormal end, alarm 12.600 Emergency stop on"
    assert texts == ["ready", "running", alarm, "ready"]
    idle = page.table["texts"][page.lane("Remote command")["idle"]]
    assert commands[0][1] == commands[2][1] == idle == "status reset"


def test_the_end_of_a_command_is_shown_before_the_reset_of_the_same_scan() -> None:
    """If a scan reads the end status and then writes 0, the end is shown before the reset.

    Both have the same time. On the side of the controller, the command is shown before its answer.

    Source: manual chapter 4, 3; spec of the trace: the area read at the start of a scan.
    """
    move, ended = _area(words=(0x0001, 0x0004, 0, 50, 19)), _area(words=(0x0200,))
    scans = [_scan(0), _scan(10_000, si=move), _scan(20_000, so=ended)]
    page = _shown(*scans)
    assert page.order() == ["Remote command", "Remote status", "Remote command"]
    assert [t_us for t_us, _ in page.changes("Remote status")] == [-1, 20_000]
    cycles = [Cycle(0, 0, _area(), _area()), Cycle(5_000, 1, move, ended)]
    assert _shown(*cycles, by="rcx serve").order() == ["Remote command", "Remote status"]


def test_broken_rules_have_their_text_and_the_section_of_the_manual() -> None:
    text = "plc, scan 1: interval: SI(06) ON only 10 ms after SI(00) ON; at least 100 ms"
    twice = [Violation(10_000, "interval", text)] * 2
    page = _shown(_scan(0), *twice, Violation(10_000, "contract", "plc, scan 1: contract: both"))
    assert [t_us for t_us, _ in page.changes("Rules broken")[1:]] == [10_000] * 3
    numbers = page.table["texts"]
    assert page.table["sections"][str(numbers.index(text))] == "ch. 5, 3"
    assert page.table["broken"] == 3


def test_variables_are_shown_as_in_structured_text_by_blocks_and_structures() -> None:
    stage = {"enum": "STAGE", "members": {"IDLE": 0, "RUN": 1}}
    pins = {"struct": "FB", "members": {"Execute": "BOOL", "Busy": "BOOL", "Time": "TIME"}}
    watch = {"Main.Stage": stage, "Main.Count": "DINT", "Main.Word": "WORD", "Main.Speed": "REAL",
             "Main.Name": "STRING", "Main.Move": pins}  # fmt: skip
    names = list(watch)
    before = ["IDLE", 5, 255, 0.5, "a", {"Execute": False, "Busy": False, "Time": "T#1500ms"}]
    after = ["RUN", 3, 256, "nan", "b", {"Execute": True, "Busy": False, "Time": "T#1500ms"}]
    values = [dict(zip(names, one, strict=True)) for one in (before, after)]
    records = [_scan(10_000 * k, vars=one) for k, one in enumerate(values)]
    page = _shown(*records, watch=watch)
    assert page.changes("Main.Stage") == [(-1, "IDLE"), (10_000, "RUN")]
    assert page.changes("Main.Count") == [(-1, 5), (10_000, 3)]
    assert (page.changes("Main.Word"), page.lane("Main.Word")["digits"]) == (
        [(-1, 255), (10_000, 256)],
        4,
    )
    assert str(page.changes("Main.Speed")) == "[(-1, 0.5), (10000, nan)]"
    assert page.changes("Main.Name")[1] == (10_000, "'b'")
    assert page.changes("Main.Move.Time") == [(-1, "T#1500ms")]
    groups = page.groups()
    assert groups["Block Main.Move"] == [f"Main.Move.{pin}" for pin in pins["members"]]
    assert groups["Variables of Main"] == names[:-1]


def test_positions_are_curves_and_have_speeds_and_are_no_events() -> None:
    cycles = [Cycle(5_000 * k, k, _area(), _area(), positions=(0.25 * k, 0.0)) for k in range(3)]
    page = _shown(_scan(0), *cycles, positions=[["Position X [mm]", "Position R [deg]"]])
    assert page.changes("Position X [mm]") == [(-1, 0), (5_000, 250), (10_000, 500)]
    assert page.lane("Position X [mm]")["fine"] == 1000
    speeds = page.groups()["Speeds"]
    assert speeds == ["Speed X [mm/s]", "Speed R [deg/s]"]
    of = [page.table["lanes"][page.lane(name)["speedOf"]]["name"] for name in speeds]
    assert of == ["Position X [mm]", "Position R [deg]"]
    assert page.order() == []


def test_a_number_that_changes_more_than_50_times_is_a_curve_and_no_event() -> None:
    for changes, is_curve in ((50, False), (51, True)):
        scans = [_scan(10_000 * k, vars={"N": k}) for k in range(changes + 1)]
        page = _shown(*scans, watch={"N": "INT"})
        assert page.lane("N").get("curve", False) is is_curve
        assert len(page.order()) == (0 if is_curve else 50)


def test_ports_that_change_are_shown_by_their_octal_numbers() -> None:
    """Ports are shown only if they change, by their octal numbers.

    Byte n+34 is SI2(), and n+40 is SI10(). In the large area, word 24 is at byte 48.

    Source: manual chapter 1, 4.1.
    """
    area = bytearray(256)
    area[40], area[49] = 0x81, 0x12
    page = _shown(_scan(0, bytes(256), bytes(256)), _scan(10_000, bytes(area), bytes(256)))
    group = page.groups()["General-purpose ports and words"]
    assert group == ["SI10()", "SIW(24)"]
    assert page.changes("SI10()")[1] == (10_000, 0x81)
    assert page.changes("SIW(24)")[1] == (10_000, 0x1200)


def test_the_controllers_view_is_a_group_without_events() -> None:
    cycles = [Cycle(0, 0, b"", _area()), Cycle(15_000, 3, _area(1), _area())]
    page = _shown(_scan(0), _scan(10_000, si=_area(1)), *cycles)
    group = next(g for g in page.table["groups"] if g["title"] == "As the controller sees it")
    assert group["open"] is False
    lanes = {page.table["lanes"][k]["name"]: page.table["lanes"][k] for k in group["lanes"]}
    assert lanes["Connection"]["count"] == 1
    assert page.order() == ["SI(00) Emergency stop input"]


def test_a_recording_of_the_controller_alone_shows_its_side_first() -> None:
    cycles = [Cycle(0, 0, b"", _area()), Cycle(5_000, 1, _area(1), _area())]
    page = _shown(*cycles, by="rcx serve")
    assert page.changes("SI(00) Emergency stop input") == [(-1, 1)]
    assert page.order() == ["Connection"]


def test_a_second_controller_has_groups_of_its_own() -> None:
    page = _shown(_scan(0), _scan(0, controller=2), _scan(10_000, _area(2), controller=2))
    assert "Controller 2: Dedicated inputs" in page.groups()
    assert page.order() == ["SI(01) Servo ON input"]


_ARM: dict[str, Any] = {
    "robot": 1,
    "name": "YK400XEC",
    "kind": "scara",
    "arms": [225.0, 175.0],
    "axes": [{"unit": "deg", "low": -90.0, "high": 90.0, "per": 10.0, "zero": 0}] * 2,
    "points": [{"number": 1, "mm": [1.0, 2.0]}],
}
_AXIS: dict[str, Any] = {"robot": 2, "kind": "axes", "axes": _ARM["axes"][:1]}


def test_each_robot_has_its_shape_its_lanes_and_its_poses() -> None:
    """Each robot has its drawing, its lanes and its poses.

    In the first controller, robot 1 has two axes and robot 2 has one axis. In the second
    controller, nothing moves.
    """
    names = ["Robot 1 axis 1 [pulses]", "Robot 1 axis 2 [pulses]", "Robot 2 axis 1 [pulses]"]
    left: tuple[dict[str, Any], ...] = ({"left": True}, {})
    page = _shown(
        _scan(0),
        Cycle(0, 0, _area(), _area(), positions=(0, 0, 0), poses=left),
        Cycle(5_000, 1, _area(), _area(), positions=(0, 0, 7)),
        Cycle(10_000, 2, _area(), _area(), poses=({}, {})),
        Cycle(10_000, 2, _area(), _area(), controller=2),
        positions=[names, ["Position axis 1 [pulses]"]],
        robots=[[_ARM, _AXIS], [_AXIS]],
    )
    first, second = page.table["robots"]
    assert (first["title"], second["title"]) == (
        "Controller 1, Robot 1, YK400XEC",
        "Controller 1, Robot 2",
    )
    assert (first["unit"], first["model"]) == ("pulses", _ARM)
    of = [[page.table["lanes"][k]["name"] for k in one["lanes"]] for one in (first, second)]
    assert of == [names[:2], names[2:]]
    assert first["poses"] == [[0, {"left": True}], [10_000, {}]]
    assert second["poses"] == [[0, {}]]


@pytest.mark.parametrize(
    "robots",
    [
        *(5, [5], [[5]], [[{}]], [], [[]], [[_ARM], [_ARM]], [[_AXIS]], [[_ARM, _AXIS]]),
        *([[_ARM | {"kind": "delta"}]], [[_ARM | {"arms": [1]}]], [[_ARM | {"arms": [0, 1]}]]),
        *([[_ARM | {"axes": [_AXIS, _AXIS]}]], [[_ARM | {"robot": "<b>"}]]),
        [[_ARM | {"axes": [{**one, "per": 0} for one in _ARM["axes"]]}]],
        [[_ARM | {"axes": [{**one, "low": float("nan")} for one in _ARM["axes"]]}]],
        *([[_ARM | {"points": [{"number": 1}]}]], [[_ARM | {"points": 5}]]),
        [[_ARM | {"points": [{"number": 1, "mm": ["<b>"]}]}]],
        [[_ARM | {"pallets": [{"number": 1, "corners": [], "places": []}]}]],
        [[_ARM | {"areas": [{"name": 5, "from": [0, 0], "to": [1, 1]}]}]],
        [[_ARM | {"areas": [{"name": "A", "from": [0, 0], "to": [1, 1, 1]}]}]],
    ],
)
def test_a_wrong_robot_is_one_message(robots: Any) -> None:
    axes = [["X [pulses]", "Y [pulses]"]]
    with pytest.raises(InputError, match="the header does not describe the robots in a known form"):
        _page(_scan(0), positions=axes, robots=robots)


@pytest.mark.parametrize("poses", [({},), ({}, {}, {}), ({}, {"shift": [1]}), ({"hand": "x"}, {})])
def test_a_wrong_pose_is_one_message(poses: Any) -> None:
    header = {"positions": [["X [mm]", "Y [mm]", "Z [mm]"]], "robots": [[_ARM, _AXIS]]}
    with pytest.raises(InputError, match="at 0 us are not those that the header describes"):
        _page(Cycle(0, 0, b"", _area(), 1, None, poses), **header)


@pytest.mark.parametrize(
    ("header", "record", "message"),
    [
        (
            {"watch": {"X": {"array": 1}}},
            _scan(0),
            "the header does not describe variables and times",
        ),
        ({"cycle_us": "x"}, _scan(0), "the header does not describe variables"),
        ({"watch": ["X"]}, _scan(0), "the header does not describe variables and times"),
        ({"watch": {"X": "INT"}}, _scan(0, vars={}), "at 0 us are not those that the header"),
        ({"watch": {"X": "INT"}}, _scan(0, vars={"X": "a"}), "at 0 us are not those that the"),
        ({"positions": [["X"]]}, Cycle(0, 0, b"", _area(), 1, (1.0, 2.0)), "at 0 us are not"),
        ({"positions": [["X"]]}, Cycle(0, 0, b"", _area(), 2, (1.0,)), "at 0 us are not those"),
        ({}, _scan(0, si=b"\0"), "areas of 48 and 1 bytes do not belong to a controller"),
        ({}, _scan(0, controller=99), "there is no controller 99"),
    ],
)
def test_a_wrong_record_is_one_message(
    header: dict[str, Any], record: Record, message: str
) -> None:
    with pytest.raises(InputError) as caught:
        _page(record, **header)
    assert message in str(caught.value)


class _Links(HTMLParser):
    """A parser that collects all addresses that a page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take addresses."""
        self.found += [value or "" for name, value in attrs if name in ("src", "href", "action")]


def test_the_page_is_one_file_that_needs_no_other_and_is_the_same_each_time() -> None:
    page = _page(_scan(0), _scan(10_000))
    assert page.startswith(BEGINNING)
    links = _Links()
    links.feed(page)
    assert links.found == ["data:,"]
    named = re.findall(r"https?://[^\s\"']+", page)
    assert named == ["http://www.w3.org/2000/svg"]  # an XML name space
    assert "default-src 'none'" in page
    assert not re.search(r"^(import|export) ", page, re.MULTILINE)
    assert page == _page(_scan(0), _scan(10_000))


def test_texts_of_users_cannot_become_part_of_the_page() -> None:
    view = View(_HEADER | {"watch": {"</script><b>": "STRING"}})
    view.take(_scan(0, vars={"</script><b>": "<img src=x>\ud800"}))
    page = view.page('<script>"@DATA@')
    assert page.count("<script") == 2
    assert "<img" not in page
    assert PageContent(page).table["title"] == '<script>"@DATA@'
