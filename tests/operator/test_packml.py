"""FB_PackMl executes or refuses every command in every state, and aborts at faults.

The test plays the robot.
"""

from __future__ import annotations

import pytest

from alone import Alone
from both_engines import ENGINES
from plc_bench import ROOT, PlcBench

#: The numbers of PackTags. Source: Beckhoff E_PMLState; Siemens LPMLV2022 state constants.
_STATES = (
    *("CLEARING", "STOPPED", "STARTING", "IDLE", "SUSPENDED", "EXECUTE", "STOPPING", "ABORTING"),
    *("ABORTED", "HOLDING", "HELD", "UNHOLDING", "SUSPENDING", "UNSUSPENDING", "RESETTING"),
    *("COMPLETING", "COMPLETE"),
)
_NUMBERS = {state: number for number, state in enumerate(_STATES, start=1)}
#: Maps each acting state to the next state. Source: ROS-Industrial packml, transition table.
_DONE = {
    "CLEARING": "STOPPED",
    "STARTING": "EXECUTE",
    "EXECUTE": "COMPLETING",
    "STOPPING": "STOPPED",
    "ABORTING": "ABORTED",
    "HOLDING": "HELD",
    "UNHOLDING": "EXECUTE",
    "SUSPENDING": "SUSPENDED",
    "UNSUSPENDING": "EXECUTE",
    "RESETTING": "IDLE",
    "COMPLETING": "COMPLETE",
}
#: Command, old state, new state, without Stop and Abort.
#: Source: ROS-Industrial packml, transition table; OPC 30050: SuspendedToHolding.
_COMMANDS = {
    ("RESET", "STOPPED"): "RESETTING",
    ("RESET", "COMPLETE"): "RESETTING",
    ("START", "IDLE"): "STARTING",
    ("HOLD", "EXECUTE"): "HOLDING",
    ("HOLD", "SUSPENDED"): "HOLDING",
    ("UNHOLD", "HELD"): "UNHOLDING",
    ("SUSPEND", "EXECUTE"): "SUSPENDING",
    ("UNSUSPEND", "SUSPENDED"): "UNSUSPENDING",
    ("CLEAR", "ABORTED"): "CLEARING",
    ("COMPLETE", "EXECUTE"): "COMPLETING",
}
_NO_STOP = {"CLEARING", "STOPPED", "STOPPING", "ABORTING", "ABORTED"}
_NO_ABORT = {"ABORTING", "ABORTED"}
_ALL: tuple[str, ...] = ("NONE", "RESET", "START", "STOP", "HOLD", "UNHOLD", "SUSPEND")
_ALL += ("UNSUSPEND", "ABORT", "CLEAR", "COMPLETE")


def _expected(command: str, state: str) -> str:
    if command == "STOP" and state not in _NO_STOP:
        return "STOPPING"
    if command == "ABORT" and state not in _NO_ABORT:
        return "ABORTING"
    return _COMMANDS.get((command, state), state)


class _Bench(PlcBench):
    """A robot without a fault, and an FB_PackMl that the test can put into any state."""

    def __init__(self, engine: str = "auto") -> None:
        super().__init__(program=ROOT / "tests/data/library/PackMl.st", engine=engine)
        self.power_up()

    def put(self, state: str) -> None:
        """Put the block into this state without a command."""
        self["PackMl.StateComplete"] = self["PackMl.CmdChangeRequest"] = False
        self["PackMl.UnitModeChangeRequest"] = False
        self["PackMl.State"] = f"PACKML_{state}"
        self.scan()
        assert self.state == state

    def command(self, command: str) -> None:
        """Send a request once, as an HMI does."""
        self["PackMl.CntrlCmd"] = f"PACKML_CMD_{command}"
        self["PackMl.CmdChangeRequest"] = True
        self.scan()

    @property
    def state(self) -> str:
        """Return the current PackML state."""
        return str(self["PackMl.State"]).removeprefix("PACKML_")


@pytest.mark.parametrize("engine", ENGINES)
def test_every_command_in_every_state_follows_the_model_or_is_refused(engine: str) -> None:
    """Source: the tables above."""
    plc = _Bench(engine)
    for state in _NUMBERS:
        for command in _ALL:
            plc.put(state)
            plc.command(command)
            expected = _expected(command, state)
            assert plc.state == expected, (command, state)
            refused = 0x8077 if expected == state else 0
            assert plc["PackMl.ErrorID"] == refused, (command, state)
            assert plc["PackMl.Error"] == bool(refused)


@pytest.mark.parametrize("engine", ENGINES)
def test_an_acting_state_ends_and_a_waiting_state_waits(engine: str) -> None:
    """Source: the tables above."""
    plc = _Bench(engine)
    for state, number in _NUMBERS.items():
        plc.put(state)
        assert plc["PackMl.StateCurrent"] == number
        assert plc["PackMl.Acting"] is (state in _DONE)
        plc.change("PackMl.StateComplete", to=True)
        assert plc.state == _DONE.get(state, state)
        assert plc["PackMl.StateCurrent"] == _NUMBERS[plc.state]


def test_a_command_comes_before_what_is_done_and_what_is_done_before_a_refused_one() -> None:
    plc = _Bench()
    plc.put("EXECUTE")
    plc["PackMl.StateComplete"] = True
    plc.command("HOLD")
    assert plc.state == "HOLDING"
    plc.put("STARTING")
    plc["PackMl.StateComplete"] = True
    plc.command("UNHOLD")
    assert (plc.state, plc["PackMl.ErrorID"]) == ("EXECUTE", 0x8077)


def test_a_request_counts_at_its_rising_edge_and_clears_the_last_refusal() -> None:
    plc = _Bench()
    plc.put("STOPPED")
    plc.command("START")
    assert plc["PackMl.ErrorID"] == 0x8077
    plc.change("PackMl.CntrlCmd", to="PACKML_CMD_RESET", scans=3)
    assert (plc.state, plc["PackMl.ErrorID"]) == ("STOPPED", 0x8077), "there was no edge"
    plc.change("PackMl.CmdChangeRequest", to=False)
    plc.command("RESET")
    assert (plc.state, plc["PackMl.ErrorID"]) == ("RESETTING", 0)


def test_the_block_starts_in_aborted_and_stays_there() -> None:
    """Source: nothing starts by itself; OPC 30050: Aborted is a usual initial state."""
    plc = PlcBench(program=ROOT / "tests/data/library/PackMl.st")
    plc["PackMl.StateComplete"] = True
    for _ in range(40):
        plc.scan()
        assert plc["PackMl.State"] == "PACKML_ABORTED"
    assert (plc["PackMl.StateCurrent"], plc["PackMl.UnitModeCurrent"]) == (9, 1)
    assert plc["PackMl.Mode"] == "PACKML_MODE_PRODUCTION"


#: An event that makes the robot unavailable, the event that ends it, and the ErrorID.
_TROUBLES = [
    ("Connected=0", "Connected=1", 0x8001),
    ("SO01=0", "SO01=1", 0x8002),
    ("SO00=1", "SO00=0", 0x8003),
    ("EmergencyStopOk=0", "EmergencyStopOk=1", 0x8003),
    ("SO03=1", "SO03=0", 0x8004),
]


@pytest.mark.parametrize(("trouble", "back", "error"), _TROUBLES)
def test_an_unavailable_robot_aborts_every_state(trouble: str, back: str, error: int) -> None:
    """Source: manual chapter 5, 2; PackML: aborting is entered on a machine fault."""
    plc = _Bench()
    for state in _NUMBERS:
        plc.put(state)
        plc.let(trouble)
        plc.scan(2 if trouble == "EmergencyStopOk=0" else 1)  # FB_WriteArea passes it to the blocks
        expected = {"CLEARING": "CLEARING", "ABORTED": "ABORTED"}.get(state, "ABORTING")
        assert plc.state == expected, state
        if expected == "ABORTING" and state != "ABORTING":
            assert plc["PackMl.AbortID"] == error
        plc.let(back)
        plc.scan(16)


def test_clearing_ends_stopped_only_once_the_fault_has_gone() -> None:
    """Source: PackML: the faults are cleared in Clearing."""
    plc = _Bench()
    plc.put("EXECUTE")
    plc.outputs(SO03=True, scans=1)
    assert (plc.state, plc["PackMl.AbortID"]) == ("ABORTING", 0x8004)
    plc.outputs(SO00=True)
    plc.change("PackMl.StateComplete", to=True)
    assert plc.state == "ABORTED"
    plc["PackMl.StateComplete"] = False
    plc.command("CLEAR")
    plc.scan(5)
    assert (plc.state, plc["PackMl.AbortID"]) == ("CLEARING", 0x8004)
    plc.change("PackMl.StateComplete", to=True)
    assert (plc.state, plc["PackMl.AbortID"]) == ("ABORTING", 0x8003), "the fault is still present"
    plc.scan()
    assert plc.state == "ABORTED"
    plc["PackMl.CmdChangeRequest"] = plc["PackMl.StateComplete"] = False
    plc.outputs(SO00=False, SO03=False, scans=1)
    plc.command("CLEAR")
    plc.change("PackMl.StateComplete", to=True)
    assert (plc.state, plc["PackMl.AbortID"]) == ("STOPPED", 0)


def test_an_abort_by_command_has_no_error_behind_it() -> None:
    plc = _Bench()
    plc.put("IDLE")
    plc.command("ABORT")
    assert (plc.state, plc["PackMl.AbortID"]) == ("ABORTING", 0)


@pytest.mark.parametrize("state", _NUMBERS)
def test_the_unit_mode_changes_only_in_stopped_idle_and_aborted(state: str) -> None:
    """Source: PackML lets the machine choose these states: Stopped, Idle and Aborted."""
    plc = _Bench()
    for mode, number in (("MAINTENANCE", 2), ("MANUAL", 3), ("PRODUCTION", 1)):
        before = plc["PackMl.Mode"]
        plc.put(state)
        plc.change("PackMl.UnitMode", to=f"PACKML_MODE_{mode}")
        assert plc["PackMl.Mode"] == before, "the mode was not requested"
        plc.change("PackMl.UnitModeChangeRequest", to=True)
        if state in ("STOPPED", "IDLE", "ABORTED"):
            assert plc["PackMl.Mode"] == f"PACKML_MODE_{mode}"
            assert (plc["PackMl.UnitModeCurrent"], plc["PackMl.ErrorID"]) == (number, 0)
        else:
            assert (plc["PackMl.Mode"], plc["PackMl.ErrorID"]) == (before, 0x8077)


def test_an_invalid_unit_mode_is_refused() -> None:
    plc = _Bench()
    plc.put("IDLE")
    plc.change("PackMl.UnitModeChangeRequest", to=True)
    assert (plc["PackMl.Mode"], plc["PackMl.ErrorID"]) == ("PACKML_MODE_PRODUCTION", 0x8077)


def test_a_mode_that_is_refused_is_told_although_the_command_beside_it_is_taken() -> None:
    plc = _Bench()
    plc.put("HELD")
    plc["PackMl.UnitMode"] = "PACKML_MODE_MANUAL"
    plc["PackMl.UnitModeChangeRequest"] = True
    plc.command("UNHOLD")
    assert (plc.state, plc["PackMl.ErrorID"]) == ("UNHOLDING", 0x8077)


def test_an_accepted_mode_clears_the_error_of_a_refused_command() -> None:
    """Source: comment of Error: until the next request."""
    plc = _Bench()
    plc.put("IDLE")
    plc.command("HOLD")
    assert plc["PackMl.ErrorID"] == 0x8077
    plc["PackMl.CmdChangeRequest"] = False
    plc.change("PackMl.UnitMode", to="PACKML_MODE_MANUAL")
    assert plc["PackMl.ErrorID"] == 0x8077, "no command was requested"
    plc.change("PackMl.UnitModeChangeRequest", to=True)
    assert (plc["PackMl.ErrorID"], plc["PackMl.Error"]) == (0, False)
    assert (plc["PackMl.Mode"], plc["PackMl.UnitModeCurrent"]) == ("PACKML_MODE_MANUAL", 3)


def test_abortid_keeps_the_first_fault_while_other_faults_change() -> None:
    """Source: comment of AbortID: what has aborted."""
    plc = _Bench()
    plc.put("EXECUTE")
    plc.outputs(SO03=True, scans=1)
    assert (plc.state, plc["PackMl.AbortID"]) == ("ABORTING", 0x8004)
    for trouble in ("SO01=0", "SO01=1", "SO03=0"):
        plc.let(trouble)
        plc.scan(2)
        assert (plc.state, plc["PackMl.AbortID"]) == ("ABORTING", 0x8004)
    plc.put("EXECUTE")
    plc.command("ABORT")
    plc.outputs(SO03=True, scans=1)
    assert (plc.state, plc["PackMl.AbortID"]) == ("ABORTING", 0), "the command came first"


def test_before_the_first_call_the_outputs_show_the_initial_state() -> None:
    """Before the first call, the outputs already show Aborted (9) in Production (1) to an HMI."""
    block = Alone("FB_PackMl", {"Robot": "RCX_REF"})
    for _ in range(2):
        shown = [block[f"Block.{pin}"] for pin in ("State", "Mode")]
        assert shown == ["PACKML_ABORTED", "PACKML_MODE_PRODUCTION"]
        shown = [block[f"Block.{pin}"] for pin in ("StateCurrent", "UnitModeCurrent", "Acting")]
        assert shown == [9, 1, False]
        block.scan(0)
