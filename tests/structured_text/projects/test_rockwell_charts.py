"""Sequential Function Charts of Logix in an L5X.

Expected values follow from Rockwell 1756-PM006: a scan executes the actions of the active steps,
and then evaluates the transitions below them.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

from l5x_ladder import program, read
from structured_text.engines.builtin import BuiltinProgram
from structured_text.projects.model import Foreign

_L5X = """<RSLogix5000Content><Controller Name="C"{options}>
<Programs><Program Name="P" MainRoutineName="Main"><Tags>{tags}</Tags>
<Routines><Routine Name="Main" Type="{kind}">{content}</Routine>
<Routine Name="Sub" Type="ST"><STContent><Line Number="0">{code}</Line></STContent></Routine>
</Routines></Program></Programs>
<Tasks><Task Name="T" Type="PERIODIC" Rate="10" Priority="10">
<ScheduledPrograms><ScheduledProgram Name="P"/></ScheduledPrograms></Task></Tasks>
</Controller></RSLogix5000Content>
"""
_TAGS = {
    **dict.fromkeys("abcd", "BOOL"),
    **dict.fromkeys("ijk", "DINT"),
    **dict.fromkeys(("S0", "S1", "S2", "S3"), "SFC_STEP"),
    **dict.fromkeys(("A0", "A1", "A2"), "SFC_ACTION"),
    **dict.fromkeys(("T0", "T1", "T2"), "BOOL"),
    "End": "SFC_STOP",
}


def _tag(name: str, kind: str) -> str:
    """Return a tag; `TYPE(PRE=3)` has values in its data, `BOOL(1)` is a value."""
    plain, _, values = kind.rstrip(")").partition("(")
    data = ""
    for value in values.split():
        member, mark, number = value.partition("=")
        if mark:
            data += f'<DataValueMember Name="{member}" DataType="DINT" Value="{number}"/>'
        else:
            data = f'<DataValue DataType="{plain}" Value="{value}"/>'
    data = f'<Structure DataType="{plain}">{data}</Structure>' if "=" in values else data
    data = f'<Data Format="Decorated">{data}</Data>' if data else ""
    return f'<Tag Name="{name}" TagType="Base" DataType="{plain}">{data}</Tag>\n'


def _step(number: int, text: str) -> str:
    """Return a step `S0: A0 N i := 1; | A1 Stored`; the actions have their tags and qualifiers."""
    name, _, rest = text.partition(":")
    actions = ""
    for action in filter(None, map(str.strip, rest.split("|"))):
        tag, qualifier, *code = action.split(" ", 2)
        kind = {"N": "NonStored"}.get(qualifier, qualifier)
        body = f'<STContent><Line Number="0">{code[0]}</Line></STContent>' if code else ""
        actions += f'<Action Operand="{tag}" Qualifier="{kind}"><Body>{body}</Body></Action>'
    initial = "true" if name.strip() == "S0" else "false"
    kind = "Stop" if name.strip() == "End" else "Step"
    given = f'ID="{number}" Operand="{name.strip()}" InitialStep="{initial}"'
    return f"<{kind} {given}>{actions}</{kind}>\n"


def _chart(text: str) -> str:
    """Return the content of a chart, with an element in each line.

    `S0: ...` is a step with the number 0, `T0 a AND b` a transition with the number 10. Other lines
    are links `0-10-1`, or XML.
    """
    made = ""
    for line in filter(None, map(str.strip, text.splitlines())):
        if line[0] in "SE":
            made += _step(3 if line[0] == "E" else int(line[1]), line)
        elif line[0] == "T":
            condition = f'<STContent><Line Number="0">{line[3:]}</Line></STContent>'
            made += f'<Transition ID="1{line[1]}" Operand="{line[:2]}">'
            made += f"<Condition>{condition}</Condition></Transition>\n"
        elif line[0] == "<":
            made += line
        else:
            ends = line.split("-")
            for source, target in pairwise(ends):
                made += f'<DirectedLink FromID="{source}" ToID="{target}"/>\n'
    return f"<SFCContent>{made}</SFCContent>"


def _branch(number: int, kind: str, flow: str) -> str:
    """Return a branch with two legs, whose numbers follow its own."""
    legs = "".join(f'<Leg ID="{number + leg}"/>' for leg in (1, 2))
    given = f'ID="{number}" BranchType="{kind}" BranchFlow="{flow}"'
    return f"<Branch {given}>{legs}</Branch>\n"


def _written(
    folder: Path, chart: str, *, code: str = "", options: str = "", kind: str = "SFC", **tags: str
) -> Path:
    """Write a project whose main routine is a chart. `code` is a routine that nothing calls."""
    file = folder / "cell.L5X"
    content = _chart(chart) if kind == "SFC" else chart
    shown = "".join(_tag(name, given) for name, given in {**_TAGS, **tags}.items())
    text = _L5X.format(options=options, tags=shown, content=content, code=code, kind=kind)
    file.write_text(text.replace("< ", "&lt; "), encoding="utf-8")
    return file


def _running(
    folder: Path, chart: str, *, code: str = "", options: str = "", **tags: str
) -> BuiltinProgram:
    return program(_written(folder, chart, code=code, options=options, **tags))


def _scans(made: BuiltinProgram, names: str, *changes: str) -> list[list[object]]:
    """Return values after scans every 10 ms; `a` sets a tag before a scan, `!a` clears it."""
    found = []
    for scan, change in enumerate(changes):
        for name in change.split():
            made.write(f"Main.{name.strip('!')}", not name.startswith("!"))
        made.scan(scan * 10_000)
        found.append([made.read(f"Main.{name}") for name in names.split()])
    return found


def test_actions_are_executed_before_transitions(tmp_path: Path) -> None:
    """Both transitions are always TRUE, so the steps alternate; each is executed once.

    After a scan, the step of the next scan is active.
    """
    made = _running(
        tmp_path,
        "S0: A0 N i := i + 1;\nS1: A1 N j := j + 1;\nT0 1 = 1\nT1 1 = 1;\n0-10-1-11-0",
    )
    assert _scans(made, "i j S0.X S1.X", "", "", "", "") == [
        [1, 0, False, True],
        [1, 1, True, False],
        [2, 1, False, True],
        [2, 2, True, False],
    ]


def test_a_selection_takes_the_leftmost_transition(tmp_path: Path) -> None:
    """The legs lead to T1 and then to T0, so T1 wins if both are TRUE. Stop ends the chart."""
    chart = "S0:\nS1:\nEnd:\nT0 a\nT1 b\n" + _branch(20, "Selection", "Diverge")
    chart += "\n0-20\n21-11-1\n22-10-3"
    made = _running(tmp_path, chart)
    assert _scans(made, "S0.X S1.X End.X", "", "a b", "") == [
        [True, False, False],
        [False, True, False],
        [False, True, False],
    ]
    made = _running(tmp_path, chart)
    names = "S0.X S1.X End.X"
    assert _scans(made, names, "a", "b") == [[False, False, True]] * 2


def test_a_selection_converges_to_a_step(tmp_path: Path) -> None:
    """S1 and S2 lead to S3 by their own transitions."""
    chart = "S0:\nS1:\nS2:\nS3:\nT0 1 = 1\nT1 a\nT2 b\n"
    chart += _branch(20, "Selection", "Converge")
    made = _running(tmp_path, f"{chart}\n0-10-2\n1-11-21\n2-12-22\n20-3")
    assert _scans(made, "S2.X S3.X", "", "a", "b") == [[True, False], [True, False], [False, True]]


def test_simultaneous_branches_wait_for_each_other(tmp_path: Path) -> None:
    """T0 starts S1 and S2; T1 is evaluated only if S1 is active together with S3 behind S2."""
    chart = "S0:\nS1: A1 N i := i + 1;\nS2: A2 N j := j + 1;\nS3:\nT0 1 = 1\nT1 1 = 1\nT2 a\n"
    chart += _branch(20, "Simultaneous", "Diverge") + "\n"
    chart += _branch(30, "Simultaneous", "Converge")
    made = _running(tmp_path, f"{chart}\n0-10-20\n21-1\n22-2-12-3\n1-31\n3-32\n30-11-0")
    assert _scans(made, "S0.X S1.X S2.X S3.X i j", "", "", "a", "") == [
        [False, True, True, False, 0, 0],
        [False, True, True, False, 1, 1],
        [False, True, False, True, 2, 2],
        [True, False, False, False, 3, 2],
    ]


def test_pulses_execute_when_a_step_begins_and_ends(tmp_path: Path) -> None:
    """P1 executes in the first scan, P0 in the last one, P in both."""
    made = _running(
        tmp_path,
        "S0:\nS1: A0 PulseRisingEdge i := i + 1; | A1 PulseFallingEdge j := j + 1; |"
        "A2 Pulse k := k + 1;\nT0 a\nT1 b\n0-10-1-11-0",
    )
    assert _scans(made, "i j k", "", "a", "", "!a", "b") == [
        *([0, 0, 0], [0, 0, 0], [1, 0, 1], [1, 0, 1], [1, 1, 2]),
    ]


def test_a_stored_action_is_on_until_its_reset(tmp_path: Path) -> None:
    """A0 begins with S0 and is reset in S2; the Boolean action A1 is only on in S1.

    Q of a non-stored action is FALSE when its step has been left.
    """
    made = _running(
        tmp_path,
        "S0: A0 Stored i := i + 1;\nS1: A1 N\nS2: A0 Reset\nT0 1 = 1\nT1 a\n0-10-1-11-2",
    )
    assert _scans(made, "i A0.Q A1.Q", "", "", "a", "") == [
        *([1, True, False], [2, True, True], [3, True, False], [3, False, False]),
    ]


@pytest.mark.parametrize(
    ("qualifier", "on"),
    [
        ("TimeLimited", "110000"),
        ("TimeDelayed", "001100"),
        ("StoredTimeLimited", "110000"),
        ("StoredTimeDelayed", "001111"),
        ("TimeDelayedStored", "001111"),
    ],
)
def test_timed_actions_begin_or_end_after_their_preset(
    qualifier: str, on: str, tmp_path: Path
) -> None:
    """The preset is 20 ms, that is two scans. The step is left behind the fourth scan."""
    made = _running(
        tmp_path, f"S0: A0 {qualifier} i := i + 1;\nS1:\nT0 a\n0-10-1", A0="SFC_ACTION(PRE=20)"
    )
    seen = _scans(made, "i", "", "", "", "a", "", "")
    counts = [on[: scan + 1].count("1") for scan in range(6)]
    assert seen == [[count] for count in counts]


def test_a_step_measures_its_time(tmp_path: Path) -> None:
    """S1 begins in the second scan; DN is set at its preset of 20 ms and stays.

    FS is only TRUE in the actions of its first scan.
    The transition from S1 to S1 restarts the time, and counts once more.
    """
    made = _running(
        tmp_path,
        "S0:\nS1: A1 N a := S1.FS; i := S1.Count;\nT0 1 = 1\nT1 S1.DN AND b\n0-10-1-11-1",
        S1="SFC_STEP(PRE=20)",
        code="k := S1.T;",
    )
    assert _scans(made, "S1.T S1.DN a i S1.FS", "", "", "", "", "b", "!b") == [
        *([0, False, False, 0, False], [0, False, True, 1, False], [10, False, False, 1, False]),
        *([20, True, False, 1, False], [0, False, False, 1, False], [0, False, True, 2, False]),
    ]


def test_a_chart_begins_where_the_options_say(tmp_path: Path) -> None:
    """The data show S1 as active: the default goes on there, `InitialStep` begins at S0."""
    chart = "S0: A0 N i := 1;\nS1: A1 N j := 1;\nT0 0 = 1\nT1 0 = 1\n0-10-1-11-0"
    made = _running(tmp_path, chart, S1="SFC_STEP(X=1)")
    assert _scans(made, "i j", "") == [[0, 1]]
    made = _running(
        tmp_path, chart, options=' SFCRestartPosition="InitialStep"', S1="SFC_STEP(X=1)"
    )
    assert _scans(made, "i j", "") == [[1, 0]]


def test_the_prescan_clears_what_is_assigned_without_retention(tmp_path: Path) -> None:
    """A tag left of [:=] is 0 before the first scan, in a chart and in a text.

    Source: 1756-PM007, non-retentive assignment.
    """
    chart = "S0:\nS1: A1 N b [:=] 1;\nT0 a\n0-10-1"
    made = _running(tmp_path, chart, b="BOOL(1)")
    assert _scans(made, "b", "", "a", "") == [[False], [False], [True]]
    text = '<STContent><Line Number="0">IF a THEN i [:=] 5; END_IF;</Line></STContent>'
    made = program(_written(tmp_path, text, kind="ST", i="DINT(7)"))
    assert _scans(made, "i", "", "a") == [[0], [5]]


def test_a_tag_of_a_module_is_found_left_of_the_sign(tmp_path: Path) -> None:
    """The bit shows that the member of the module is a DINT; bit 3 is 8."""
    made = _running(tmp_path, "S0: A0 N Local:1:O.Data.3[:=]1;")
    made.scan(0)
    assert made.read("Local_1_O.Data") == 8


def test_a_note_of_an_action_is_reported_once(tmp_path: Path) -> None:
    """GSV reads nothing of the system; its note has the line of the action."""
    chart = "S0: A0 N GSV(Task,Main,Rate,i);\nS1:\nT0 a\n0-10-1"
    notes = [note for note in read(_written(tmp_path, chart)).notes if "GSV" in note]
    assert len(notes) == 1
    assert "i keeps its value" in notes[0]


def test_each_line_names_its_element(tmp_path: Path) -> None:
    """The lines of an action, a transition and a step have its name."""
    file = _written(tmp_path, "S0: A0 N i := 1;\nS1:\nT0 a\n0-10-1")
    piece = next(unit.piece for unit in read(file).units if unit.kind == "PROGRAM")
    assert not isinstance(piece.body, Foreign)
    places = {line.text.strip(): line.network for line in piece.body}
    assert places["i := 1;"] == "action A0"
    assert places["T0 := a;"] == "transition T0"
    assert places["S0.X := TRUE;"] == "step S0"


@pytest.mark.parametrize(
    ("chart", "said"),
    [
        ("S1:", "a chart has exactly one initial step, this chart has 0"),
        ("S0:\nT0 a\n0-10", "the transition T0 has no step below it"),
        ("S0:\nT0 a\n10-0", "the transition T0 has no step above it"),
        ("S0:\nT0 a\nT1 a\n0-10-11-0", "the transition T0 leads to another transition"),
        ("S0:\nT0 i\n0-10-0", "the condition of the transition T0: a condition must be BOOL"),
        ("S0:\nT0 a := b\n0-10-0", "the condition of the transition T0: ':=' is not expected"),
        ("S0:\nT0\n0-10-0", "the condition of the transition T0 is empty"),
        ("S0:\nT0 JSR(Sub,0)\n0-10-0", "the condition of the transition T0 calls a routine"),
        ("S0: A0 Nix", "the action A0 of the step S0 has the qualifier 'Nix'"),
        ("S0: A0 N i := nix;", "the action A0: there is no tag nix in this file"),
        ("S0: a N", "the action a is not a tag of the type SFC_ACTION"),
        ("S0: A0 N a := S0.LS;", "the step S0: its member LS is used, and is not supported"),
        ("S0: A0 N i := 1;\nS1: A0 N i := 2;", "two steps have statements for the action A0"),
        ("S0:\n0-7", "a link ends at the element '7', which is not in the chart"),
        ("S0:\n<Nix/>", "the element Nix is not known"),
        ("S0:\n<SbrRet/>", "the element SbrRet with parameters of the routine is not supported"),
        ("S0:\nEnd:\nT0 a\n0-10-3-10", "something follows the stop End"),
        ('S0:\n<Step ID="0" Operand="S1"/>', "two elements have the number 0"),
        ('S0:\n<Step ID="5" Operand="S0"/>', "two steps have the tag S0"),
        ('S0:\n<Step ID="5" Operand="a"/>', "the step a is not a tag of the type SFC_STEP"),
        ('S0:\n<Branch ID="5" Priority="User"/>', "a selection with the priority 'User'"),
        ('S0:\n<Step ID="5" PresetUsesExpr="true" Operand="S1"/>', "the expression for Preset"),
        ("S0: A0 N i := 1;\nS1:\nT0 a\n<Branch ID='20' BranchType='Selection' BranchFlow="
         "'Converge'><Leg ID='21'/></Branch>\n0-21\n20-10-1", "is connected to a branch that"),
    ],
)  # fmt: skip
def test_a_chart_is_refused_by_name(chart: str, said: str, tmp_path: Path) -> None:
    """The message has the element and what to do."""
    piece = next(
        unit.piece for unit in read(_written(tmp_path, chart)).units if unit.kind == "PROGRAM"
    )
    assert isinstance(piece.body, Foreign)
    assert said in piece.body.why


@pytest.mark.parametrize("option", ["SFCExecutionControl", "SFCLastScan", "SFCRestartPosition"])
def test_other_options_of_charts_are_refused(option: str, tmp_path: Path) -> None:
    """Only the defaults are computed, and the restart at the initial step."""
    file = _written(tmp_path, "S0:", options=f' {option}="Other"')
    piece = next(unit.piece for unit in read(file).units if unit.kind == "PROGRAM")
    assert isinstance(piece.body, Foreign)
    assert "'Other'" in piece.body.why
