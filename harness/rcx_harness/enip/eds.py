"""The virtual controller's electronic data sheet (EDS), written from the harness's own data.

A PLC's configuration tool reads such a file to know the device and the connections it takes. The
format is that of the Common Industrial Protocol, volume 1, chapter 7: sections of entries, each
entry a list of fields, a comment from `$` to the end of the line. The vendor's own file belongs to
the real controller; nothing of it is in here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rcx_harness.enip.codec.cip import REVISIONS, ClassId, encode_segment
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.enip.target.connection_manager import MAX_CYCLIC, MAX_EXPLICIT
from rcx_harness.spec.wire import EXTENDED_SIZE, SIZE, TO_MASTER, TO_ROBOT, check_size

__all__ = ["eds_text"]

_USUAL_RPI_US = 10_000

#: Edition of the text below and its date: the sheet says the same whenever it is written.
_EDITION, _DATE, _TIME = "1.1", "11-21-2026", "12:00:00"

# Trigger and transport (a bit field): class 1, cyclic, and who owns the outputs.
_CLASS_1, _CYCLIC = 1 << 1, 1 << 16
_OWNERSHIP = {"listen": 1 << 24, "input": 1 << 25, "owner": 1 << 26}
# Connection parameters: fixed sizes; the real time format of each direction; the types, and
# "scheduled" as priority, for both directions.
_FIXED_SIZES = 1 << 0 | 1 << 2
_HEARTBEAT, _RUN_IDLE_HEADER = 3 << 8, 4 << 8  # O->T; modeless T->O is 0
_POINT_TO_POINT = 1 << 18
_MULTICAST_BACK, _POINT_TO_POINT_BACK = 1 << 21, 1 << 22
_SCHEDULED = 1 << 26 | 1 << 30

_UINT, _UDINT = "0xC7", "0xC8"
_ENUMERATED = "0x0002"


@dataclass(frozen=True)
class _Entry:
    """An entry: its keyword, and its fields with a comment each."""

    key: str
    fields: tuple[tuple[str, str], ...]

    def lines(self) -> Iterator[str]:
        """Yield `key = field;`, or one line per field for several fields."""
        if len(self.fields) == 1:
            value, note = self.fields[0]
            yield _noted(f"        {self.key} = {value};", note)
            return
        yield f"        {self.key} ="
        for number, (value, note) in enumerate(self.fields, 1):
            end = ";" if number == len(self.fields) else ","
            yield _noted(f"                {value}{end}", note)


def eds_text(
    size: int = SIZE, identity: Identity | None = None, options: AdapterOptions | None = None
) -> str:
    """Return the complete sheet.

    `size` is the size of each area that a tool proposes first; both sizes can be chosen in it.

    Returns:
        ASCII text with LF line ends.
    """
    check_size(size)
    options = options or AdapterOptions()
    sections = {
        "File": _file(),
        "Device": _device(identity or Identity()),
        "Device Classification": [_one("Class1", "EtherNetIP")],
        "Params": _parameters(size, options),
        "Assembly": _assemblies(),
        "Connection Manager": _connections(options),
        "Capacity": _capacity(),
        "TCP/IP Interface Class": _class("TCP/IP Interface Object", ClassId.TCP_IP),
        "Ethernet Link Class": _class("Ethernet Link Object", ClassId.ETHERNET_LINK),
        "QoS Class": _class("QoS Object", ClassId.QOS),
        "Port": _port(),
    }
    lines = [
        "$ Electronic data sheet of the virtual controller (a simulation) of rcx-harness,",
        "$ written by `rcx eds`. It is not the vendor's sheet: connect a real controller with the",
        "$ file that its vendor gives out. Vendor code and device type are those of the controller",
        "$ it stands for. Product code, revision, packet intervals and the connection points of",
        "$ readers are assumed.",
    ]
    for name, entries in sections.items():
        lines += ["", f"[{name}]"]
        for entry in entries:
            lines += entry.lines()
    return "\n".join(lines) + "\n"


def _file() -> list[_Entry]:
    return [
        _one("DescText", _text("Virtual RCX340/RCX320 controller of rcx-harness")),
        _one("CreateDate", _DATE),
        _one("CreateTime", _TIME),
        _one("ModDate", _DATE),
        _one("ModTime", _TIME),
        _one("Revision", _EDITION),
    ]


def _device(identity: Identity) -> list[_Entry]:
    return [
        _one("VendCode", str(identity.vendor)),
        _one("VendName", _text("simulated by rcx-harness")),
        _one("ProdType", str(identity.device_type), "the manual's chapter 5, section 4"),
        _one("ProdTypeStr", _text("Generic Device")),
        _one("ProdCode", str(identity.product_code)),
        _one("MajRev", str(identity.major_revision)),
        _one("MinRev", str(identity.minor_revision)),
        _one("ProdName", _text(identity.product_name)),
    ]


def _parameters(size: int, options: AdapterOptions) -> list[_Entry]:
    usual = min(max(_USUAL_RPI_US, options.rpi_min_us), options.rpi_max_us)
    limits = f"{options.rpi_min_us},{options.rpi_max_us},{usual}"
    entries = [_parameter(1, "RPI", "us", "Requested packet interval", (_UDINT, "4"), limits)]
    for number, way, instance in ((2, "Output", TO_ROBOT), (3, "Input", TO_MASTER)):
        help_text = f"Bytes of assembly {instance}, as set at the controller"
        limits = f"{SIZE},{EXTENDED_SIZE},{size}"
        kind = (_UINT, "2")
        entries.append(_parameter(number, f"{way} Size", "bytes", help_text, kind, limits))
        entries.append(
            _Entry(
                f"Enum{number}",
                (
                    (f"{SIZE},{_text(f'{SIZE} bytes')}", "as delivered"),
                    (
                        f"{EXTENDED_SIZE},{_text(f'{EXTENDED_SIZE} bytes')}",
                        "with the controller's word extension",
                    ),
                ),
            )
        )
    return entries


def _parameter(
    number: int, name: str, unit: str, help_text: str, kind: tuple[str, str], limits: str
) -> _Entry:
    data_type, data_size = kind
    return _Entry(
        f"Param{number}",
        (
            ("0", "reserved"),
            (",", "no link path"),
            (_ENUMERATED if data_type == _UINT else "0x0000", "descriptor"),
            (data_type, "data type"),
            (data_size, "data size"),
            (_text(name), "name"),
            (_text(unit), "unit"),
            (_text(help_text), "help"),
            (limits, "least, greatest, default"),
            (",,,", "scaling"),
            (",,,", "scaling links"),
            ("", "decimal places"),
        ),
    )


def _assemblies() -> list[_Entry]:
    areas = (
        (TO_MASTER, "Inputs of the master: m, robot to master"),
        (TO_ROBOT, "Outputs of the master: n, master to robot"),
    )
    return [
        _Entry(
            f"Assem{instance}",
            (
                (_text(name), "name"),
                (_text(f"20 04 24 {instance:02X} 30 03"), "path"),
                ("", "size: chosen in the connection"),
                ("0x0000", "descriptor"),
                (",", "reserved"),
                (",", "one member: all of it"),
            ),
        )
        for instance, name in areas
    ]


def _connections(options: AdapterOptions) -> list[_Entry]:
    kinds = (
        ("owner", TO_ROBOT, "Exclusive Owner", "The PLC that drives the robot"),
        ("input", options.input_only, "Input Only", "Reads the robot and drives nothing"),
        ("listen", options.listen_only, "Listen Only", "Reads beside another connection"),
    )
    configuration = (
        _segment(0x24, options.configurations[0]) + " " if options.configurations else ""
    )
    return [
        _connection(
            number,
            kind,
            (name, help_text),
            f"20 04 {configuration}{_segment(0x2C, point)} {_segment(0x2C, TO_MASTER)}",
        )
        for number, (kind, point, name, help_text) in enumerate(kinds, 1)
    ]


def _connection(number: int, kind: str, names: tuple[str, str], path: str) -> _Entry:
    owner = kind == "owner"
    parameters = _FIXED_SIZES | (_RUN_IDLE_HEADER if owner else _HEARTBEAT)
    parameters |= _POINT_TO_POINT | _MULTICAST_BACK | _POINT_TO_POINT_BACK | _SCHEDULED
    to_robot = f"Param1,Param2,Assem{TO_ROBOT}" if owner else "Param1,0,"
    to_robot_note = "32 bit run/idle header" if owner else "heartbeat"
    return _Entry(
        f"Connection{number}",
        (
            (f"0x{_OWNERSHIP[kind] | _CYCLIC | _CLASS_1:08X}", "class 1, cyclic"),
            (f"0x{parameters:08X}", "fixed sizes, formats, types of both directions"),
            (to_robot, f"O->T RPI, size, format; {to_robot_note}"),
            (f"Param1,Param3,Assem{TO_MASTER}", "T->O RPI, size, format; modeless"),
            (",", "no configuration of a proxy"),
            ("0,", "no configuration data"),
            (_text(names[0]), "name"),
            (_text(names[1]), "help"),
            (_text(path), "path"),
        ),
    )


def _segment(kind: int, number: int) -> str:
    """Return a logical segment in the notation of the format."""
    return encode_segment(kind, number).hex(" ").upper()


def _capacity() -> list[_Entry]:
    return [
        _one("MaxIOConnections", str(sum(MAX_CYCLIC.values()))),
        _one("MaxMsgConnections", str(MAX_EXPLICIT)),
    ]


def _class(name: str, class_id: ClassId) -> list[_Entry]:
    return [
        _one("Revision", str(REVISIONS[class_id])),
        _one("Object_Name", _text(name)),
        _one("Object_Class_Code", f"0x{class_id:02X}"),
        _one("MaxInst", "1"),
        _one("Number_Of_Static_Instances", "1"),
        _one("Max_Number_Of_Dynamic_Instances", "0"),
    ]


def _port() -> list[_Entry]:
    return [
        _Entry(
            "Port1",
            (
                ("TCP", "type"),
                (_text("EtherNet/IP"), "name"),
                (_text("20 F5 24 01"), "TCP/IP Interface object"),
                ("2", "number of the port"),
            ),
        )
    ]


def _one(key: str, value: str, note: str = "") -> _Entry:
    return _Entry(key, ((value, note),))


def _text(text: str) -> str:
    return f'"{text}"'


def _noted(line: str, note: str) -> str:
    return f"{line:<47} $ {note}" if note else line
