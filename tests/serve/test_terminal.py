"""The terminal shows the connections of the controllers in words."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
from contextlib import suppress

import pytest
from rich.console import Console

from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.cyclic.shared import Drop
from rcx_harness.robot import Led
from rcx_harness.serve.terminal import screen
from rcx_harness.serve.view import LED_MEANINGS, view
from serve_process import own_addresses
from served import ServedHost, image


def _text(served: ServedHost, height: int) -> str:
    console = Console(width=160)
    with console.capture() as capture:
        console.print(screen([served], height))
    return capture.get()


@pytest.mark.parametrize(
    ("state", "text"),
    [
        (OwnerState.NONE, "no master has connected yet"),
        (
            OwnerState.WAITING,
            "a master has opened the connection, but sends nothing yet: 192.168.0.10, every 10 ms",
        ),
        (OwnerState.RUN, "connected: 192.168.0.10, every 10 ms"),
        (
            OwnerState.IDLE,
            "connected, but the master's program is stopped (idle): 192.168.0.10, every 10 ms",
        ),
        (OwnerState.TIMED_OUT, "the master fell silent: the connection has timed out"),
        (OwnerState.CLOSED, "the master has closed the connection"),
    ],
)
def test_the_connection_is_described_in_a_sentence(state: OwnerState, text: str) -> None:
    served = ServedHost()
    served.network.become(state)
    served.run(5)
    assert view(0, served)["connection"] == text
    served.network.listeners = 1
    served.station.happen("link_down")
    served.run(5)
    cut = f"the network cable is unplugged ({text}; 1 more that only listen)"
    assert view(0, served)["connection"] == cut


def test_packets_of_a_wrong_length_are_not_shown_as_silence() -> None:
    """Packets of a wrong length are reported as such, not as silence of the master.

    There are 195 packets of 300 bytes instead of 54, and 3 packets before the connection.
    """
    served = ServedHost()
    served.network.drops[Drop.LENGTH] = 3
    served.network.become(OwnerState.WAITING)
    served.run(5)
    served.network.drops[Drop.LENGTH], served.network.lengths = 198, (300, 54)
    served.run(5)
    assert view(0, served)["connection"] == (
        "a master has opened the connection, but none of its packets is accepted: 192.168.0.10, "
        "every 10 ms; dropped: 195 of a wrong length (300 bytes instead of 54)"
    )
    assert view(0, served)["packets"]["dropped"] == (
        "198 of a wrong length (300 bytes instead of 54)"
    )
    assert "dropped         198 of a wrong length" in _text(served, 40)


def test_a_refused_connection_is_shown_until_a_master_has_connected() -> None:
    served = ServedHost()
    served.network.refuse("192.168.0.10 asked for 256 bytes: refused")
    served.run(5)
    refused = "no master has connected yet; 192.168.0.10 asked for 256 bytes: refused"
    assert view(0, served)["connection"] == refused
    served.network.become(OwnerState.WAITING)
    served.network.become(OwnerState.RUN)
    served.run(5)
    assert view(0, served)["connection"] == "connected: 192.168.0.10, every 10 ms"


@pytest.mark.exhaustive
def test_a_refusal_beside_a_master_is_shown_for_a_minute() -> None:
    served = ServedHost()
    served.network.become(OwnerState.RUN)
    served.network.refuse("192.168.0.11 asked for a connection: refused")
    served.run(59_995)
    shown = "connected: 192.168.0.10, every 10 ms"
    assert view(0, served)["connection"] == (
        f"{shown}; 192.168.0.11 asked for a connection: refused"
    )
    served.run(10)
    assert view(0, served)["connection"] == shown


def test_a_controller_that_stands_still_says_so(served: ServedHost) -> None:
    served.silent = True
    assert view(0, served)["connection"].startswith("the controller's process does not respond")


def test_a_controller_without_power_or_not_booted_says_so(served: ServedHost) -> None:
    asyncio.run(served.ask({"event": "power_off", "args": {}}))
    assert view(0, served)["connection"] == "the controller is off"
    asyncio.run(served.ask({"event": "power_on", "args": {}}))
    assert view(0, served)["connection"].startswith("the controller starts")


def test_every_state_of_the_leds_has_the_manuals_meaning() -> None:
    """Source: manual chapter 1, 3."""
    states = {led.value for led in Led}
    assert set(LED_MEANINGS["module"]) == set(LED_MEANINGS["network"]) == states


def test_the_view_names_each_dedicated_bit_and_has_the_pendants_ports(served: ServedHost) -> None:
    shown = view(3, served)
    assert shown["id"] == 3
    on = [one["signal"] for one in shown["inputs"] + shown["outputs"] if one["on"]]
    assert on == ["SI(00)", "SI(06)", "SO(01)", "SO(04)", "SO(10)", "SO(11)"]
    ports = [one["port"] for one in shown["monitor"]["SI"]]
    assert ports == [0, 1, 2, 3, 4, 5, 6, 7, 10, 11, 12, 13, 14, 15]
    assert shown["monitor"]["SI"][0]["value"] == 0x41
    assert [one["port"] for one in shown["monitor"]["SOW"]] == list(range(16))


def test_the_terminal_shows_every_dedicated_bit_by_its_name(served: ServedHost) -> None:
    text = _text(served, 40)
    assert "127.0.0.1, 48 bytes" in text
    assert "connected: 192.168.0.10, every 10 ms" in text
    assert "Network Status  ● green (online, connected to the master)" in text
    assert "● SI(06) Stop input" in text
    assert "○ SO(02) Servo ON status output" in text


def test_with_little_room_the_terminal_shows_the_bits_that_are_on(served: ServedHost) -> None:
    text = _text(served, 12)
    assert "SI(00) SI(06) SO(01) SO(04) SO(10) SO(11)" in text
    assert "Stop input" not in text


def test_the_terminal_shows_the_last_command_alarms_and_broken_rules(served: ServedHost) -> None:
    served.network.send(image(0x41, 0x0505))
    served.run(50)
    served.network.send(image(0x01, 0x0FFF))
    served.run(50)
    served.station.happen("alarm", {"group": 12, "category": 762})
    served.run(5)
    text = _text(served, 40)
    assert "ReadPositionPulses (16#R505): Current position reference, pulse units: normal" in text
    assert "12.762" in text
    assert "may be set only in status 16#0000; not executed" in text


@pytest.mark.skipif(
    not sys.platform.startswith("linux"),
    reason="it needs a pseudo-terminal, and loopback addresses besides 127.0.0.1",
)
def test_a_terminal_gets_the_table() -> None:
    """If the output is a terminal, `rcx serve` prints the table. Pipes and files get lines."""
    ours, terminal = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "rcx_harness", "serve", "--address", *own_addresses(1)],
        stdin=subprocess.DEVNULL, stdout=terminal, stderr=terminal,
        env={**os.environ, "TERM": "xterm", "PYTHONIOENCODING": "utf-8"},
    )  # fmt: skip
    try:
        os.close(terminal)
        said = b""
        while b"Module Status" not in said:  # os.read fails at the end
            said += os.read(ours, 4096)
        assert "╭" in said.decode(errors="ignore")
        process.send_signal(signal.SIGINT)
        with suppress(OSError):  # reading fails after the last program closed it
            while os.read(ours, 4096):
                pass
        assert process.wait() == 0
    finally:
        process.kill()
        process.wait()
        os.close(ours)
