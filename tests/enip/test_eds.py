"""`rcx eds` writes an EDS file that tools can read and that describes the adapter."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from enip_frames import forward_open
from log_records import log_messages
from rcx_harness.cli.app import main
from rcx_harness.enip.eds import eds_text
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.target.adapter import Adapter
from structured_text.errors import InputError

Captured = pytest.CaptureFixture[str]
Sheet = dict[str, dict[str, list[str]]]

_FIELD = re.compile(r'\s*("[^"]*"|[^",;]*)\s*([,;])')


def read(text: str) -> Sheet:
    """Return the sections, entries and fields of an EDS file. Quotes are not removed."""
    sheet: Sheet = {}
    rest = "\n".join(line.partition("$")[0] for line in text.splitlines())
    while rest := rest.lstrip():
        if section := re.match(r"\[([\w /]+)\]", rest):
            entries = sheet.setdefault(section[1], {})
            rest = rest[section.end() :]
            continue
        key = re.match(r"(\w+)\s*=", rest)
        assert key, f"neither section nor entry: {rest[:60]!r}"
        assert key[1] not in entries, f"{key[1]} twice"
        fields = entries[key[1]] = []
        rest = rest[key.end() :]
        while True:
            part = _FIELD.match(rest)
            assert part, f"not a field of {key[1]}: {rest[:60]!r}"
            fields.append(part[1].strip())
            rest = rest[part.end() :]
            if part[2] == ";":
                break
    return sheet


@pytest.fixture
def sheet() -> Sheet:
    return read(eds_text())


@pytest.mark.parametrize("size", [48, 256])
def test_a_reader_of_eds_files_finds_no_fault(size: int) -> None:
    """The reader eds-pie, which knows the EDS format, finds no mistake in the file."""
    from eds_pie.eds_pie import CIP_EDS  # eds-pie sets up logging when it is imported

    with log_messages() as complaints:
        read_in = CIP_EDS(eds_text(size))
    # Messages about the section Port are ignored, because eds-pie does not know its entries.
    assert [
        one for one in complaints if "[Port]" not in one and "Unknown Entry [{" not in one
    ] == []
    assert read_in.protocol == "EtherNetIP"
    assert read_in.get_value("Params", "Param2", 11) == str(size)


def test_the_reader_reports_a_mistake_in_the_file() -> None:
    from eds_pie.eds_pie import CIP_EDS

    with log_messages() as complaints:
        CIP_EDS(eds_text().replace("Param1,Param2,Assem150", "Param1,Param9,Assem150"))
    assert any("Missing referenced Entry [Params].Param9" in one for one in complaints)


def test_the_sections_come_in_their_order(sheet: Sheet) -> None:
    assert list(sheet)[:6] == [
        *("File", "Device", "Device Classification", "Params", "Assembly", "Connection Manager")
    ]
    assert sheet["Device Classification"] == {"Class1": ["EtherNetIP"]}


def test_the_device_is_the_adapters_identity() -> None:
    identity = Identity(vendor=1, product_code=77, major_revision=3, minor_revision=9)
    device = read(eds_text(identity=identity))["Device"]
    assert {key: fields for key, fields in device.items() if key != "VendName"} == {
        "VendCode": ["1"],
        "ProdType": ["43"],
        "ProdTypeStr": ['"Generic Device"'],
        "ProdCode": ["77"],
        "MajRev": ["3"],
        "MinRev": ["9"],
        "ProdName": ['"RCX3 virtual controller"'],
    }


def test_packet_interval_and_both_sizes_are_parameters(sheet: Sheet) -> None:
    """The EDS file offers packet intervals of 2 ms to 3.2 s, and sizes of 48 and 256 bytes.

    Source: manual chapter 1, 4.3 (Output Size, Input Size).
    """
    parameters = sheet["Params"]
    assert [parameters[f"Param{k}"][6] for k in (1, 2, 3)] == [
        '"RPI"',
        '"Output Size"',
        '"Input Size"',
    ]
    assert parameters["Param1"][9:12] == ["2000", "3200000", "10000"]
    assert parameters["Param2"][9:12] == parameters["Param3"][9:12] == ["48", "256", "48"]
    choice = ["48", '"48 bytes"', "256", '"256 bytes"']
    assert parameters["Enum2"] == parameters["Enum3"] == choice
    assert {len(parameters[f"Param{k}"]) for k in (1, 2, 3)} == {21}


def test_the_proposed_size_can_be_chosen() -> None:
    parameters = read(eds_text(256))["Params"]
    assert parameters["Param2"][9:12] == parameters["Param3"][9:12] == ["48", "256", "256"]


def test_three_connections_read_assembly_100_and_one_writes_150(sheet: Sheet) -> None:
    """The EDS file has three cyclic class 1 connections: Exclusive Owner, Input Only, Listen Only.

    Trigger and transport: bit 1 class 1, bit 16 cyclic, bits 24 to 26 listen, input, owner.
    Parameters: bits 0 and 2 fixed sizes, bits 8 to 10 O->T format (4: run/idle header, 3:
    heartbeat), bits 12 to 14 T->O format (0: modeless), bit 18 O->T point to point, bits 21 and 22
    T->O multicast and point to point, bits 26 and 30 scheduled priority.
    """
    reads = ["Param1", "Param3", "Assem100"]
    only = ["Param1", "0", "", *reads]
    entries = sheet["Connection Manager"].values()
    assert [(one[12], one[:2], one[2:8], one[14]) for one in entries] == [
        (
            *('"Exclusive Owner"', ["0x04010002", "0x44640405"]),
            *(["Param1", "Param2", "Assem150", *reads], '"20 04 24 01 2C 96 2C 64"'),
        ),
        ('"Input Only"', ["0x02010002", "0x44640305"], only, '"20 04 24 01 2C 03 2C 64"'),
        ('"Listen Only"', ["0x01010002", "0x44640305"], only, '"20 04 24 01 2C 04 2C 64"'),
    ]
    assert {len(entry) for entry in entries} == {15}


@pytest.mark.parametrize("size", [48, pytest.param(256, marks=pytest.mark.exhaustive)])
def test_the_adapter_takes_every_connection_of_the_sheet(size: int) -> None:
    """The adapter opens each connection with the path, sizes, types and interval of the file."""
    sheet = read(eds_text(size))
    interval = int(sheet["Params"]["Param1"][11])
    sizes = {key: int(fields[11]) for key, fields in sheet["Params"].items() if len(fields) > 11}
    with Adapter(size, cyclic=0) as adapter, Client(*adapter.address) as client:
        for serial, entry in enumerate(sheet["Connection Manager"].values(), 1):
            path = bytes.fromhex(entry[14].strip('"'))
            header = 4 if int(entry[1], 16) >> 8 & 7 == 4 else 0
            to_robot = sizes.get(entry[3], 0) + header + 2
            request = forward_open(
                serial=serial,
                rpi_us=interval,
                sizes=(to_robot, sizes[entry[6]] + 2),
                points=(path[5], path[7]),
                transport=(int(entry[0], 16) & 0xFFFF).bit_length() - 1,
            )
            assert request.endswith(path)
            reply, _ = client.exchange(request)
            assert reply.status == 0, f"{entry[12]}: {reply}"


def test_the_file_has_the_limits_of_the_adapters_options() -> None:
    options = AdapterOptions(rpi_min_us=20_000)
    sheet = read(eds_text(options=options))
    assert sheet["Params"]["Param1"][9:12] == ["20000", "3200000", "20000"]


def test_the_file_says_that_it_is_for_the_virtual_controller() -> None:
    """The EDS file says that it is for a simulation, and does not contain the vendor's name."""
    text = eds_text()
    comments = "\n".join(line for line in text.splitlines() if line.startswith("$"))
    assert "virtual controller (a simulation)" in comments
    assert "not the vendor's" in comments
    assert "yamaha" not in text.lower()
    assert text.isascii()


def test_the_sheet_is_printed(capsys: Captured) -> None:
    assert main(["eds", "--size", "256"]) == 0
    assert capsys.readouterr().out == eds_text(256)


def test_the_sheet_is_written_to_a_file_and_missing_folders_are_made(
    tmp_path: Path, capsys: Captured
) -> None:
    file = tmp_path / "missing" / "too" / "rcx3.eds"
    assert main(["eds", str(file)]) == 0
    assert file.read_bytes() == eds_text().encode("ascii")
    assert capsys.readouterr().out == f"written: {file}\n"


def test_the_options_of_the_command_are_in_the_file(capsys: Captured) -> None:
    options = ["--product-code", "77", "--revision", "3.9", "--rpi-min", "1ms"]
    assert main(["eds", *options]) == 0
    sheet = read(capsys.readouterr().out)
    device = sheet["Device"]
    assert [device[key] for key in ("ProdCode", "MajRev", "MinRev")] == [["77"], ["3"], ["9"]]
    assert sheet["Params"]["Param1"][9:12] == ["1000", "3200000", "10000"]


@pytest.mark.parametrize("options", [["--revision", "3"], ["--rpi-min", "10us"]])
def test_invalid_options_are_bad_input(options: list[str], capsys: Captured) -> None:
    assert main(["eds", *options]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_another_size_is_bad_input(capsys: Captured) -> None:
    with pytest.raises(InputError, match="64 bytes"):
        eds_text(64)
    assert main(["eds", "--size", "64"]) == 2
    assert capsys.readouterr().err.startswith("rcx: an area of 64 bytes does not exist; ")


def test_a_file_that_cannot_be_written_is_bad_input(capsys: Captured) -> None:
    assert main(["eds", "/proc/rcx3.eds"]) == 2
    assert capsys.readouterr().err.startswith("rcx: /proc/rcx3.eds: cannot be written: ")


def test_an_existing_sheet_is_replaced_only_with_force(tmp_path: Path, capsys: Captured) -> None:
    file = tmp_path / "main.st"
    file.write_text("mine")
    assert main(["eds", str(file)]) == 2
    assert capsys.readouterr().err == (
        f"rcx: {file}: already exists; use --force to overwrite it\n"
    )
    assert file.read_text() == "mine"
    assert main(["eds", str(file), "--force"]) == 2, "the command does not replace a sheet"
    assert file.read_text() == "mine"
    sheet = tmp_path / "rcx3.eds"
    assert main(["eds", str(sheet)]) == 0
    sheet.write_text(sheet.read_text() + "$ an older one")
    assert main(["eds", str(sheet), "--force"]) == 0
    assert sheet.read_text() == eds_text()


def test_the_commands_of_the_page_can_be_typed_one_after_the_other(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The `rcx eds` commands of the page work one after the other.

    Source: docs/how-to/network.md.
    """
    lines = (repository / "docs/how-to/network.md").read_text(encoding="utf-8").splitlines()
    commands = [line.partition("#")[0].split()[1:] for line in lines if line.startswith("rcx eds ")]
    monkeypatch.chdir(tmp_path)
    assert [main(command) for command in commands] == [0, 0]
