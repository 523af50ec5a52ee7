"""Charts of PLCopen XML with actions, transitions and conditions in LD and FBD."""

from __future__ import annotations

from pathlib import Path

from plcopen_drawings import block, element, notes_of, program_of, project, scanned

_XHTML = 'xmlns="http://www.w3.org/1999/xhtml"'
_RAIL = element("leftPowerRail", 90, at="0 0")


def _rung(contact: str, coil: str, **given: str) -> str:
    return (
        _RAIL
        + element("contact", 91, contact, "90", at="50 0", **given)
        + element("coil", 92, coil, "91", at="99 0")
    )


def _chart(first: str, second: str, extra: str = "", action: str = "") -> str:
    """Return the chart: (One) -first-> [Two] -second-> (One); Two has an action."""
    inline = f"<action qualifier='N'><inline name=''>{action}</inline></action>"
    connected = '<connectionPointIn><connection refLocalId="{}"/></connectionPointIn>'
    return (
        '<SFC><step localId="1" name="One" initialStep="true"><position x="0" y="0"/></step>\n'
        f'<transition localId="2"><position x="0" y="50"/>{connected.format(1)}{first}</transition>'
        f'\n<step localId="3" name="Two"><position x="0" y="100"/>{connected.format(2)}</step>\n'
        + (
            f'<actionBlock localId="4">{connected.format(3)}{inline}</actionBlock>\n'
            if action
            else ""
        )
        + f'<transition localId="5"><position x="0" y="150"/>{connected.format(3)}{second}'
        f'</transition>\n<jumpStep localId="6" targetName="One">{connected.format(5)}</jumpStep>\n'
        f"{extra}</SFC>"
    )


def _connected(sources: str) -> str:
    lines = "".join(
        f'<connection refLocalId="{number}"' + (f' formalParameter="{pin}"/>' if pin else "/>")
        for number, _, pin in (one.partition(".") for one in sources.split())
    )
    return f"<condition><connectionPointIn>{lines}</connectionPointIn></condition>"


def _named(name: str) -> str:
    return f'<condition><reference name="{name}"/></condition>'


def _when(text: str) -> str:
    return f'<condition><inline name=""><ST><p {_XHTML}>{text}</p></ST></inline></condition>'


def _with_transition(text: str, name: str, body: str) -> str:
    transition = f'<transition name="{name}"><body>{body}</body></transition>'
    return text.replace("<body>", f"<transitions>{transition}</transitions>\n<body>", 1)


#: An action in FBD that counts the scans in which its step is active.
_COUNT = (
    "<FBD>"
    + element("inVariable", 70, "N", at="0 0")
    + element("inVariable", 71, "1", at="0 20")
    + block(72, "ADD", {"IN1": "70", "IN2": "71"}, "OUT", "50 0")
    + element("outVariable", 73, "N", "72.OUT", at="99 0")
    + "</FBD>"
)


def test_conditions_are_connected_to_networks(tmp_path: Path) -> None:
    """One -> Two if A is TRUE or B is FALSE; Two -> One if A is FALSE. N counts the scans in Two.

    |  A            +-----+            +-----+   +-----+
    +--| |---+------| One |       A ---| NOT |---| Two |
    |  B     |      +-----+            +-----+   +-----+
    +--|/|---+

    Contacts have their values of this scan. A function is executed with the blocks, after the
    transitions, so NOT has the value of the last scan: Two is left in scan 4. What leads to no
    condition is not executed: 99 --- N.

    Source: PLCopen TC6 XML 2.01, sfcObjects, transition/condition/connectionPointIn; the generator
    of Beremiz (COMPUTE_FUNCTION_BLOCKS).
    """
    networks = (
        _RAIL
        + element("contact", 10, "A", "90", at="50 50")
        + element("contact", 11, "B", "90", at="50 70", negated="true")
        + element("inVariable", 12, "A", at="0 150")
        + block(13, "NOT", {"IN": "12"}, "OUT", "50 150")
        + element("inVariable", 14, "99", at="0 250")
        + element("outVariable", 15, "N", "14", at="50 250")
    )
    body = _chart(_connected("10 11"), _connected("13.OUT"), networks, _COUNT)
    program = program_of(tmp_path, project("A B : BOOL; N : INT", body))
    got = scanned(program, "A B", "N", "0 1", "1 1", "1 1", "0 1", "0 1", "0 0")
    assert got == ["0", "1", "2", "3", "3", "4"]


def test_a_block_of_conditions_is_executed_after_the_transitions(tmp_path: Path) -> None:
    """The counter C counts an edge of A once per scan, and its Q of the last scan is the condition.

          +-- CTU --+
    A --->|CU      Q|--- One -> Two, and Two -> One
    2 ----|PV     CV|
          +---------+

    The second edge is in scan 3, so One is left in scan 4, and Two in scan 5.

    Source: the generator of Beremiz (GenerateSFCTransition, COMPUTE_FUNCTION_BLOCKS).
    """
    networks = (
        element("inVariable", 10, "A", at="0 50")
        + element("inVariable", 11, "2", at="0 70")
        + block(
            12,
            "CTU",
            {"CU": "rising 10", "PV": "11"},
            "Q CV",
            "50 50",
            instanceName="C",
        )
    )
    body = _chart(_connected("12.Q"), _connected("12.Q"), networks, _COUNT)
    program = program_of(tmp_path, project("A : BOOL; N : INT; C : CTU", body))
    got = scanned(program, "A", "N C.CV", "0", "1", "0", "1", "0", "0")
    assert got == ["0 0", "0 1", "0 1", "0 2", "1 2", "1 2"]


def test_a_transition_in_ladder_assigns_its_name(tmp_path: Path) -> None:
    """One -> Two while A is FALSE; the transition Go is in ladder: --|/ A|--( Go )--.

    Source: PLCopen TC6 XML 2.01, transitions; the generator of Beremiz.
    """
    body = _chart(_named("Go"), _when("FALSE"), "", _COUNT)
    text = project("A : BOOL; N : INT", body)
    whole = _with_transition(text, "Go", f"<LD>{_rung('A', 'Go', negated='true')}</LD>")
    assert scanned(program_of(tmp_path, whole), "A", "N", "1", "1", "0") == ["0", "0", "1"]
    other = _with_transition(text, "Go", f"<LD>{_rung('A', 'Other')}</LD>")
    assert "the transition Go is in LD, and nothing assigns Go" in notes_of(tmp_path, other)


def test_a_named_action_in_ladder(tmp_path: Path) -> None:
    """The action Work is in FBD; it is executed while Two is active."""
    body = _chart(_when("A"), _when("FALSE"), "", "@")
    body = body.replace("<inline name=''>@</inline>", '<reference name="Work"/>')
    action = f'<actions><action name="Work"><body>{_COUNT}</body></action></actions>'
    text = project("A : BOOL; N : INT", body).replace("<body>", f"{action}<body>", 1)
    assert scanned(program_of(tmp_path, text), "A", "N", "0", "1", "0") == ["0", "1", "2"]


def test_a_diagram_in_a_chart_that_is_not_read_is_named(tmp_path: Path) -> None:
    """The reason of a condition or an action becomes the reason of the whole chart."""
    networks = element("contact", 10, "A", "", at="50 50")
    body = _chart(_connected("10"), _when("FALSE"), networks, _COUNT)
    note = notes_of(tmp_path, project("A : BOOL; N : INT", body))
    assert "the contact A is not connected on its left side" in note
    wrong = _COUNT.replace('refLocalId="72"', 'refLocalId="71"').replace("<block", "<steps", 1)
    body = _chart(_when("A"), _when("FALSE"), "", wrong.replace("</block>", "</steps>"))
    note = notes_of(tmp_path, project("A : BOOL; N : INT", body))
    assert "the element <steps> is not supported" in note


def test_a_condition_with_a_block_in_a_file_of_codesys_is_not_read(tmp_path: Path) -> None:
    """CODESYS evaluates a condition only while its step is active, so its blocks would differ."""
    networks = element("inVariable", 10, "A")
    networks += block(11, "TON", {"IN": "10"}, "Q ET", instanceName="T")
    body = _chart(_connected("11.Q"), _when("FALSE"), networks)
    text = project("A : BOOL; T : TON", body, company="3S-Smart Software Solutions GmbH")
    note = notes_of(tmp_path, text)
    assert "a condition with a block or an edge is not supported" in note


def test_a_convergence_of_codesys_may_have_jumps_above_it(tmp_path: Path) -> None:
    """A leads from One to Two and back; B leads from One to Three. N counts the scans in Three.

            One
      +------+------+
      + A           + B
     Two          Three
      + A           + A
     jump to One    |
      +------+------+
         jump to One

    CODESYS connects the first jump to the convergence, though the jump has ended its branch.

    Source: exports of CODESYS.
    """

    def joined(kind: str, number: int, above: str, more: str = "", **given: str) -> str:
        lines = "".join(
            f'<connectionPointIn><connection refLocalId="{one}"/></connectionPointIn>'
            for one in above.split()
        )
        values = "".join(f' {name}="{one}"' for name, one in given.items())
        return f'<{kind} localId="{number}"{values}>{lines}{more}</{kind}>\n'

    count = f'<action qualifier="N"><inline name="">{_COUNT}</inline></action>'
    body = (
        joined("step", 1, "", name="One", initialStep="true")
        + joined("selectionDivergence", 2, "1")
        + element("inVariable", 20, "A")
        + joined("transition", 3, "2", _connected("20"))
        + joined("step", 4, "3", name="Two")
        + joined("transition", 5, "4", _connected("20"))
        + joined("jumpStep", 6, "5", targetName="One")
        + element("inVariable", 21, "B")
        + joined("transition", 7, "2", _connected("21"))
        + joined("step", 8, "7", name="Three")
        + joined("actionBlock", 9, "8", count)
        + joined("transition", 10, "8", _connected("20"))
        + joined("selectionConvergence", 11, "6 10")
        + joined("jumpStep", 12, "11", targetName="One")
    )
    text = project("A B : BOOL; N : INT", f"<SFC>{body}</SFC>", company="3S-Smart CODESYS")
    program = program_of(tmp_path, text)
    # One, Two, One, Three (N = 1 and 2), One with the final scan of the action.
    got = scanned(program, "A B", "N", "1 0", "1 0", "0 1", "0 0", "1 0", "0 0")
    assert got == ["0", "0", "1", "2", "3", "3"]
