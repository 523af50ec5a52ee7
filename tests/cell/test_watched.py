# ruff: noqa: RUF001 - charts consist of these box-drawing characters
"""Watched variables are selected by path or pattern, and have the same values on every engine.

The expected values follow from tests/cell/programs/Watched.st. This program counts its scans and
sets most variables in the third scan. Five scans run in 50 ms.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from both_engines import ENGINES
from rcx_harness import Cell, InputError, RobotConfig
from rcx_harness.trace import Scan, read_trace
from rcx_harness.trace.chart import Timeline, text_chart
from structured_text.bench.watched import is_like

Build = Callable[..., Cell]

_EVERY = (
    "Main.S*,Main.Grid,Main.Item,Main.Items[*].Speed",
    "Main.Block.*, Main.Waited",
    "Main.Ratio,Main.Mask,Main.Text,Main.Connected,Main.Day",
)
_S = ("Speed", "State")
_AT_THE_END = {"Main.Scans": "5", "Main.State": "W_RUN", "Main.Grid[1,0]": "0",
               "Main.Grid[1,1]": "0", "Main.Grid[2,0]": "0", "Main.Grid[2,1]": "-35",
               "Main.Item.Speed": "0.1", "Main.Item.State": "W_END", "Main.Item.Name": "'gripper'",
               "Main.Items[0].Speed": "0", "Main.Items[1].Speed": "2.5", "Main.Block.Go": "TRUE",
               "Main.Block.Sum": "-3", "Main.Block.Inner": "16#00AB", "Main.Waited": "T#25ms",
               "Main.Ratio": "0.1", "Main.Mask": "16#0F", "Main.Text": "'a b'",
               "Main.Connected": "TRUE", "Main.Day": "D#1970-01-01"}  # fmt: skip


@pytest.fixture
def watched(build_cell: Build, tmp_path: Path) -> Build:
    """Return a function that builds cells of programs/Watched.st with watched patterns."""
    program = Path(__file__).parent / "programs" / "Watched.st"
    (tmp_path / "no-library").mkdir()

    def build(*patterns: str, engine: str = "builtin", **options: object) -> Cell:
        lib = tmp_path / "no-library"
        return build_cell(program, lib=lib, engine=engine, watch=patterns, **options)

    return build


@pytest.mark.parametrize("engine", ENGINES)
def test_values_are_shown_as_in_structured_text(watched: Build, engine: str) -> None:
    cell = watched(*_EVERY, engine=engine)
    cell.run("50ms")
    assert cell.watched() == _AT_THE_END
    cell.close()
    assert cell.watched() == _AT_THE_END, "a closed cell must keep the last values"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_trace_has_all_values_and_types(watched: Build, engine: str, tmp_path: Path) -> None:
    file = tmp_path / "t.jsonl"
    cell = watched("Main.Grid,Main.Item", "Main.Waited,Main.Day", engine=engine, trace=file)
    cell.run("50ms")
    cell.close()
    header, records = read_trace(file)
    states = {"enum": "W_STATE", "members": {"W_IDLE": 0, "W_RUN": 1, "W_END": 2}}
    item = {"Speed": "REAL", "State": states, "Name": "STRING"}
    assert header["watch"] == {
        "Main.Grid": {"array": [[1, 2], [0, 1]], "of": "INT"},
        "Main.Item": {"struct": "W_ITEM", "members": item},
        "Main.Waited": "TIME",
        "Main.Day": "DATE",
    }
    last = [record for record in records if isinstance(record, Scan)][-1]
    assert last.vars is not None
    assert json.loads(json.dumps(last.vars)) == {
        "Main.Grid": [[0, 0], [0, -35]],
        "Main.Item": {"Speed": pytest.approx(0.1), "State": "W_END", "Name": "gripper"},
        "Main.Waited": "T#25ms",
        "Main.Day": "D#1970-01-01",
    }


def test_a_trace_without_watched_variables_has_no_values(watched: Build) -> None:
    cell = watched()
    cell.run("20ms")
    assert not any('"watch"' in line or '"vars"' in line for line in cell.trace.lines())
    assert cell.watched() == {}


@pytest.mark.parametrize(
    ("pattern", "found"),
    [
        ("Main.State", ["Main.State"]),
        ("main.st*", ["main.State"]),
        ("Main.S*,Main.Mask", ["Main.Scans", "Main.State", "Main.Mask"]),
        ("Main.?ask", ["Main.Mask"]),
        ("Main.*State", ["Main.State"]),
        ("*.Mask", ["Main.Mask"]),
        ("Main.Item.*", ["Main.Item.Speed", "Main.Item.State", "Main.Item.Name"]),
        ("Main.Items[*].S*", [f"Main.Items[{k}].{name}" for k in (0, 1) for name in _S]),
        ("Main.Items[1].*ame", ["Main.Items[1].Name"]),
        ("Main.Grid[*,1]", ["Main.Grid[1,1]", "Main.Grid[2,1]"]),
        ("Main.Grid[2,0],Main.Mask", ["Main.Grid[2,0]", "Main.Mask"]),
        ("Main.*.Speed", ["Main.Item.Speed"]),
        ("Main.T*", ["Main.Text"]),
        ("Main.B*", ["Main.Blink"]),
        ("Main.*Area,Main.Mask", None),
        ("Main.InputArea[1?]", [f"Main.InputArea[{k}]" for k in range(10, 20)]),
    ],
)
def test_a_pattern_finds_variables_but_no_blocks_and_no_long_arrays(
    watched: Build, pattern: str, found: list[str] | None
) -> None:
    """A pattern does not match function blocks (Timer, Block) and long arrays (InputArea)."""
    if found is None:
        with pytest.raises(InputError, match="matches only blocks and long arrays; name one"):
            watched(pattern)
        return
    cell = watched(pattern)
    cell.scan()
    assert list(cell.trace.scans()[-1].vars or ()) == found


@pytest.mark.parametrize(
    ("pattern", "message"),
    [
        ("Main.Sate", "Main of type Watched has no member Sate; did you mean State"),
        ("Main.Sate*", "no variable matches Main.Sate*; did you mean State"),
        ("Main.Item.X?", "no variable matches Main.Item.X?; there are Speed, State, Name"),
        ("Main.Mask.*", "no variable matches Main.Mask.*"),
        ("Main.Items[7*]", "no variable matches Main.Items[7*]; did you mean [1] or [0]"),
        ("Other.*", "there is no program instance Other"),
        ("Main..*", "is not a pattern of variables; write it as Main.Hmi.* or Main.A[*]"),
        (".*", "is not a pattern of variables"),
        ("Main.Block*", "name one: Main.Block, or its variables as Main.Block.*"),
    ],
)
def test_a_mistyped_name_gets_suggestions(watched: Build, pattern: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        watched(pattern)
    assert message in str(caught.value)


def test_global_variables_are_found_with_and_without_their_list(
    build_cell: Build, tmp_path: Path
) -> None:
    files = {
        "GVL": "VAR_GLOBAL\n  Limit : INT := 3;\n  Large : INT := 9;\nEND_VAR",
        "Areas": "VAR_GLOBAL\n  InputArea, OutputArea : ARRAY [0..511] OF BYTE;\nEND_VAR",
        "Plant": "PROGRAM Plant\nVAR n : INT; END_VAR\nn := n + GVL.Limit;\nEND_PROGRAM",
    }
    (tmp_path / "lib").mkdir()
    for name, source in files.items():
        (tmp_path / f"{name}.st").write_text(source, encoding="utf-8")
    paths = [tmp_path / f"{name}.st" for name in files]
    options = {"lib": tmp_path / "lib", "engine": "builtin"}
    cell = build_cell(paths, watch="GVL.L*,Lim*,gvl.large,GVL.Limit", **options)
    cell.scan()
    assert cell.watched() == {"GVL.Limit": "3", "GVL.Large": "9", "Limit": "3", "gvl.large": "9"}
    with pytest.raises(InputError, match=r"no variable matches GVL.X\*; there are Limit, Large"):
        build_cell(paths, watch="GVL.X*", **options)
    with pytest.raises(InputError, match="there is no program instance GVX"):
        build_cell(paths, watch="GVX.*", **options)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_chart_has_a_lane_for_each_member_and_element(watched: Build, engine: str) -> None:
    """Each member has its own lane. The third scan (20 ms) changes all values but Connected."""
    cell = watched("Main.State,Main.Item,Main.Connected", engine=engine)
    timeline = Timeline(cell.trace)
    cell.trace.listen(timeline.take)
    cell.run("50ms")
    lines = text_chart(timeline, 80).splitlines()
    assert lines[0].split()[2:] == ["0", "20"]
    at = dict(line.rsplit(None, 1) for line in lines)
    assert at["Main.Item.State"].strip("─") == "W_IDLE─╳W_END"
    assert at["Main.State"].strip("─") == "W_IDLE─╳W_RUN"
    assert at["Main.Item.Speed"].strip("─") == "0──────╳0.1"
    assert at["Main.Item.Name"].strip("─") == "''─────╳'gripper'"
    assert set(at["Main.Connected"]) == {"▔"}


def test_variables_that_change_in_each_scan_add_no_columns(watched: Build) -> None:
    """Scans and Blink change in each scan and add no columns. State adds a column at 20 ms."""
    cell = watched("Main.Scans,Main.Blink,Main.State", robot=RobotConfig(boot_time=0.0))
    timeline = Timeline(cell.trace)
    cell.trace.listen(timeline.take)
    cell.run("2s")
    times = timeline.instants()
    assert 20_000 in times
    assert len(times) < 10
    line = next(one for one in text_chart(timeline, 80).splitlines() if "Main.Scans" in one)
    assert "╳3─" in line, "the column must show the value of its time"


def test_a_single_changing_variable_adds_columns(watched: Build) -> None:
    timeline = Timeline(watched("Main.Scans").trace)
    for k in range(100):
        timeline.take(Scan(k, k, bytes(48), bytes(48), {"Main.Scans": k}))
    assert len(timeline.instants()) == 99


@pytest.mark.parametrize(
    "pattern", ["Main.*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*b", "Main." + "*?" * 15 + "*"]
)
def test_a_pattern_of_thirty_stars_is_compared_quickly(watched: Build, pattern: str) -> None:
    """The comparison with a pattern of thirty stars ends quickly.

    A regular expression would try all ways to divide the name among the stars.

    Source: docs/reference/limits.md, variables that are watched.
    """
    with pytest.raises(InputError, match="no variable matches"):
        watched(pattern)


@pytest.mark.parametrize(
    ("pattern", "name", "matches"),
    [
        ("*", "", True),
        ("*", "Speed", True),
        ("s*d", "Speed", True),
        ("S*e*d", "Speed", True),
        ("S*x*d", "Speed", False),
        ("?peed", "Speed", True),
        ("?speed", "Speed", False),
        ("*ee?*", "Speed", True),
        ("Speed*", "Speed", True),
        ("Spee", "Speed", False),
    ],
)
def test_a_star_and_a_question_mark_are_wildcards(pattern: str, name: str, matches: bool) -> None:
    """`*` matches any text, and `?` matches one character.

    Source: docs/reference/trace.md, --watch.
    """
    assert is_like(pattern, name) == matches


def test_watched_variables_have_a_limit(watched: Build, monkeypatch: pytest.MonkeyPatch) -> None:
    """If a pattern matches more variables than the limit (here 3), it is rejected.

    Source: docs/reference/limits.md, variables that are watched.
    """
    for module in ("structured_text.language.displayed", "structured_text.bench.watched"):
        monkeypatch.setattr(f"{module}.MOST_WATCHED", 3)
    with pytest.raises(InputError, match="4 variables are watched, with all members and elements"):
        watched("Main.Grid")
    with pytest.raises(InputError, match="matches more than 3 variables"):
        watched("Main.*.*")
