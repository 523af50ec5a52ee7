"""FB_Jog takes turns with other commands, which wait while SI(06) stops a jog."""

from __future__ import annotations

from jog_bench import STOPPED, end_by_stop, jog_plc, jogging


def test_a_jog_waits_for_its_turn() -> None:
    plc = jog_plc()
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan(3)
    plc.change("Jog.Enable", to=True, scans=5)
    assert plc["Jog.Busy"]
    assert plc.words[0] == 0x0501
    plc.complete()
    plc.scan_until(lambda: plc.words[0] == 0x0020, most=4)


def test_a_waiting_command_is_sent_only_when_si06_is_on_again() -> None:
    """A waiting command is sent after SI(06) is ON again.

    Before, it would end with alarm 12.400.
    """
    plc = jog_plc()
    jogging(plc)
    plc["First.Code"], plc["First.Execute"] = 0x0001, True
    end_by_stop(plc)
    while plc.words[0] != 0x0001:
        assert plc.now_us < 5_000_000
        assert plc.words[0] == 0
        plc.scan()
    assert "SI06" in plc.inputs
    assert plc["Robot.Settled"]


def test_a_command_does_not_wait_while_stop_ok_is_false() -> None:
    """If StopOk holds SI(06) OFF, commands do not wait, as some commands move nothing."""
    plc = jog_plc()
    jogging(plc)
    plc["StopOk"] = False
    end_by_stop(plc)
    plc.give("First", 0x0501, most=5)


def test_a_command_does_not_wait_while_a_program_stop_holds_si06_off() -> None:
    """If a program stop holds SI(06) OFF, the next command does not wait until SI(06) is ON."""
    plc = jog_plc()
    jogging(plc)
    plc["Robot.Inner.HoldStop"] = True
    end_by_stop(plc)
    assert plc.inputs == ["SI00"]
    plc.give("First", 0x0501, most=4)
    assert plc.inputs == ["SI00"]


def test_a_jog_that_ended_while_the_area_was_illegal_needs_no_stop() -> None:
    """If the jog ends while the area cannot be written, the block needs no stop afterwards."""
    plc = jog_plc()
    jogging(plc)
    plc["Jog.Enable"], plc["WriteArea.Size"] = False, 47
    plc.scan()
    assert plc.words[0] == 0x0020, "the code must stay in the area"
    plc["WriteArea.Size"] = 48
    plc.answer(0x4000, STOPPED, scans=1)
    assert plc.words[0] == 0
    assert plc.inputs == ["SI00", "SI06"]
    assert not plc["Jog.Error"]
