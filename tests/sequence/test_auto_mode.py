"""FB_AutoMode follows chapter 5, 3.2, AUTO mode changeover.

The test plays the controller.
"""

from __future__ import annotations

import pytest

from plc_bench import PlcBench
from sequence_bench import sequences


def _level(plc: PlcBench) -> str:
    return " ".join(name for name in ("Valid", "Busy", "Error") if plc[f"AutoMode.{name}"])


def _shown(plc: PlcBench) -> tuple[object, ...]:
    return (_level(plc), plc["AutoMode.ErrorID"], plc["AutoMode.Reason"])


def test_auto_mode_changeover_process() -> None:
    """The block waits for the AUTO switch, the lock, the status output and the authority.

    The switch is at the SAFETY connector, the lock is at the programming box.

    Source: manual chapter 5, 3.2, AUTO mode changeover process.
    """
    plc = sequences()
    plc.outputs(SO10=False)
    plc.change("AutoMode.Enable", to=True, scans=1000)
    assert _shown(plc) == ("Busy", 0, "AUTO_NOT_SELECTED")
    assert "SAFETY connector" in str(plc["AutoMode.Text"])
    plc.outputs(SO10=True, scans=1)
    assert _shown(plc) == ("Valid", 0, "AUTO_SELECTED")
    assert "control authority" in str(plc["AutoMode.Text"])


def test_another_mode_turns_the_output_off() -> None:
    """Source: manual chapter 5, 2, SO(10)."""
    plc = sequences()
    plc.change("AutoMode.Enable", to=True)
    plc.outputs(SO10=False, scans=1)
    assert _shown(plc) == ("Busy", 0, "AUTO_WITHDRAWN")
    plc.scan(20)
    assert _shown(plc) == ("Busy", 0, "AUTO_WITHDRAWN")
    assert "left" in str(plc["AutoMode.Text"])
    plc.outputs(SO10=True, scans=1)
    assert _shown(plc) == ("Valid", 0, "AUTO_SELECTED")


@pytest.mark.parametrize(
    ("cause", "shown"),
    [
        ("link", ("Error", 0x8001, "AUTO_NOT_CONNECTED")),
        ("SO01", ("Error", 0x8002, "AUTO_CPU_NOT_OK")),
    ],
)
def test_a_mode_that_cannot_be_read_is_an_error_until_it_can(
    cause: str, shown: tuple[object, ...]
) -> None:
    plc = sequences()
    plc.change("AutoMode.Enable", to=True)
    if cause == "link":
        plc["Connected"] = False
    else:
        plc.outputs(SO01=False)
    plc.scan()
    assert _shown(plc) == shown
    assert "not known" in str(plc["AutoMode.Text"])
    plc["Connected"] = True
    plc.outputs(SO01=True, scans=1)
    assert _shown(plc) == ("Valid", 0, "AUTO_SELECTED")


def test_without_enable_nothing_is_shown() -> None:
    plc = sequences()
    plc.scan()
    assert _shown(plc) == ("", 0, "AUTO_NOT_ASKED")
    plc.change("AutoMode.Enable", to=True)
    plc.change("AutoMode.Enable", to=False)
    assert _shown(plc) == ("", 0, "AUTO_NOT_ASKED")
    assert plc["AutoMode.Text"] == ""
    plc.outputs(SO10=False)
    plc.change("AutoMode.Enable", to=True)
    assert _shown(plc) == ("Busy", 0, "AUTO_NOT_SELECTED"), "the earlier state has no effect"


def test_auto_mode_changes_no_dedicated_input() -> None:
    """Source: manual chapter 5, 3.2, AUTO mode changeover process."""
    plc = sequences()
    plc.outputs(SO10=False)
    plc.change("AutoMode.Enable", to=True, scans=50)
    assert plc.inputs == ["SI00", "SI06"]
