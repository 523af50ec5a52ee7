"""The elements of an L5X file: data types, Add-On Instructions, a program."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime, timedelta, timezone
from xml.sax.saxutils import quoteattr

from structured_text.errors import COMMAND
from structured_text.export.l5x.blocks import FBD_TIMER
from structured_text.export.l5x.model import Aoi, Data, Images, Tag, check_name, data_of
from structured_text.language.scalars import string_literal
from structured_text.language.types import ElementaryType, StructType

__all__ = ["SOFTWARE", "aoi_element", "data_type", "document", "program_element"]

#: The version of Studio 5000 Logix Designer that the file states.
SOFTWARE = "33.00"

_LONGEST_DESCRIPTION = 512
_EPOCH = datetime(2026, 1, 1, tzinfo=timezone.utc)


def document(
    target: str,
    name: str,
    types: Iterable[str],
    aois: Iterable[str],
    rest: str = "",
    *,
    controller: str,
) -> str:
    """Return the whole file.

    `target` is the kind of component to import: Program or AddOnInstructionDefinition. Each Add-On
    Instruction (AOI) is written after the AOIs that it uses. `rest` are the elements that follow
    all AOIs.
    """
    head = _opened(
        "RSLogix5000Content",
        SchemaRevision="1.0",
        SoftwareRevision=SOFTWARE,
        TargetName=name,
        TargetType=target,
        ContainsContext="true",
        ExportDate=_EPOCH.strftime("%a %b %d %H:%M:%S %Y"),
        ExportOptions="References NoRawData DecoratedData Context Dependencies AllProjDocTrans",
    )
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>',
            head,
            f'<Controller Use="Context" Name="{controller}">',
            '<DataTypes Use="Context">',
            *types,
            "</DataTypes>",
            '<AddOnInstructionDefinitions Use="Context">',
            *aois,
            "</AddOnInstructionDefinitions>",
            *filter(None, [rest]),
            "</Controller>",
            "</RSLogix5000Content>",
            "",
        ]
    )


def data_type(kind: StructType, header: str, notes: Mapping[str, str], images: Images) -> str:
    """Return a structure; as in Studio 5000, its BOOLs are bits of hidden SINTs."""
    lines = [_opened("DataType", Name=check_name(kind.name), Family="NoFamily", Class="User")]
    lines += [*_described(header.split("\n\n")[0]), "<Members>"]
    used: dict[str, None] = {}
    hidden, bit = "", 8
    for place, (name, field) in enumerate(kind.fields):
        note = notes.get(name.upper(), "")
        if field == ElementaryType("BOOL"):
            if bit == 8:
                hidden, bit = f"ZZZZZZZZZZ{kind.name[:10]}{place}", 0
                lines.append(_member(hidden, Data("SINT"), "true", ""))
            bits = {"Target": hidden, "BitNumber": str(bit)}
            lines.append(_member(check_name(name), Data("BIT"), "false", note, **bits))
            bit += 1
            continue
        bit, data = 8, data_of(field, images)
        if data.type not in ("DINT", "REAL", "STRING", "SINT", "INT"):
            used[data.type] = None
        lines.append(_member(check_name(name), data, "false", note))
    lines.append("</Members>")
    lines += _dependencies(dict.fromkeys(used, "DataType"))
    return "\n".join([*lines, "</DataType>"])


def aoi_element(aoi: Aoi, blocks: Mapping[str, Aoi], *, target: bool = False) -> str:
    """Return an Add-On Instruction.

    `blocks` are the instructions by name; nested instructions get their initial values from them.
    `target` marks the component to import.
    """
    inside = "\n".join(_inside(aoi, blocks))
    # Studio 5000 replaces an instruction of the project only if its edit time differs, so the time
    # is derived from the contents.
    edited = _EPOCH + timedelta(milliseconds=zlib.crc32(inside.encode()))
    use = {"Use": "Target"} if target else {}
    head = _opened(
        "AddOnInstructionDefinition",
        **use,
        Name=aoi.name,
        Revision="1.0",
        ExecutePrescan="true" if aoi.prescan else "false",
        ExecutePostscan="false",
        ExecuteEnableInFalse="false",
        CreatedDate=_moment(_EPOCH),
        CreatedBy=f"{COMMAND} export",
        EditedDate=_moment(edited),
        EditedBy=f"{COMMAND} export",
        SoftwareRevision=f"v{SOFTWARE}",
    )
    return f"{head}\n{inside}\n</AddOnInstructionDefinition>"


def program_element(program: Aoi, blocks: Mapping[str, Aoi]) -> str:
    """Return a program with its tags and its one routine."""
    tags = [line for tag in program.locals for line in _tag("Tag", tag, blocks)]
    return "\n".join(
        [
            '<Programs Use="Context">',
            _opened(
                "Program",
                Use="Target",
                Name=program.name,
                TestEdits="false",
                MainRoutineName="Main",
                Disabled="false",
                UseAsFolder="false",
            ),
            *_described(program.header),
            "<Tags>",
            *tags,
            "</Tags>",
            "<Routines>",
            *_routine("Main", program.logic),
            "</Routines>",
            "</Program>",
            "</Programs>",
        ]
    )


def _inside(aoi: Aoi, blocks: Mapping[str, Aoi]) -> Iterator[str]:
    yield from _described(aoi.header.split("\n\n")[0])
    if aoi.header:
        yield _text("AdditionalHelpText", aoi.header)
    yield "<Parameters>"
    for name, usage in (("EnableIn", "Input"), ("EnableOut", "Output")):
        yield from _parameter(Tag(name, Data("BOOL"), usage, None), "false")
    for tag in aoi.parameters:
        yield from _parameter(tag, "true")
    yield "</Parameters>"
    yield "<LocalTags>"
    for tag in aoi.locals:
        yield from _tag("LocalTag", tag, blocks)
    yield "</LocalTags>"
    yield "<Routines>"
    yield from _routine("Logic", aoi.logic)
    if aoi.prescan:
        yield from _routine("Prescan", aoi.prescan)
    yield "</Routines>"
    used = dict.fromkeys(aoi.types, "DataType")
    yield from _dependencies(used | dict.fromkeys(aoi.blocks, "AddOnInstructionDefinition"))


def _parameter(tag: Tag, visible: str) -> Iterator[str]:
    by_reference = tag.usage == "InOut"
    attributes = {"Name": tag.name, "TagType": "Base", "DataType": tag.data.type}
    if tag.data.size:
        attributes["Dimensions"] = str(tag.data.size)
    attributes["Usage"] = tag.usage
    attributes |= _radix(tag.data)
    attributes |= {"Required": "true" if by_reference else "false", "Visible": visible}
    if by_reference:
        attributes["Constant"] = "false"
    else:
        changed = tag.usage == "Input" and tag.initial is not None
        attributes["ExternalAccess"] = "Read/Write" if changed else "Read Only"
    head = _opened("Parameter", **attributes)
    yield from (head, *_described(tag.note))
    if tag.initial is not None:
        yield from _decorated("DefaultData", _value("DataValue", tag, {}))
    yield "</Parameter>"


def _tag(element: str, tag: Tag, blocks: Mapping[str, Aoi]) -> Iterator[str]:
    attributes = {"Name": tag.name}
    if element == "Tag":
        attributes["TagType"] = "Base"
    attributes["DataType"] = tag.data.type
    if tag.data.size:
        attributes["Dimensions"] = str(tag.data.size)
    attributes |= _radix(tag.data)
    if element == "Tag":
        attributes["Constant"] = "false"
    attributes["ExternalAccess"] = "Read/Write" if element == "Tag" else "None"
    yield _opened(element, **attributes)
    yield from _described(tag.note)
    holder = "Data" if element == "Tag" else "DefaultData"
    if tag.is_block:
        yield from _decorated(holder, *_structure(blocks[tag.data.type]))
    elif tag.data.type == "FBD_TIMER":
        yield from _decorated(holder, *_timer())
    elif tag.data == Data("STRING") and tag.initial is not None:
        length = str(len(string_literal(tag.initial)))
        yield _text(holder, tag.initial, Format="String", Length=length)
    elif not tag.data.is_aggregate:
        yield from _decorated(holder, _value("DataValue", tag, {}))
    yield f"</{element}>"


def _structure(aoi: Aoi) -> Iterator[str]:
    """Yield the members of a nested instruction, with their initial values."""
    yield _opened("Structure", DataType=aoi.name)
    yield '<DataValueMember Name="EnableIn" DataType="BOOL" Value="1"/>'
    yield '<DataValueMember Name="EnableOut" DataType="BOOL" Value="0"/>'
    for tag in aoi.parameters:
        if tag.usage != "InOut":
            yield _value("DataValueMember", tag, {"Name": tag.name})
    yield "</Structure>"


def _timer() -> Iterator[str]:
    yield _opened("Structure", DataType="FBD_TIMER")
    for name, data in FBD_TIMER.items():
        initial = "1" if name == "EnableIn" else "0"
        yield _value("DataValueMember", Tag(name, Data(data), "Local", initial), {"Name": name})
    yield "</Structure>"


def _value(element: str, tag: Tag, name: dict[str, str]) -> str:
    number = str(tag.initial).partition("(*")[0]
    if number.startswith("16#"):
        bits = int(number[3:], 16)
        number = str(bits - (1 << 32) if bits >= 1 << 31 else bits)
    if tag.data.type == "REAL" and "." not in number:
        number += ".0"
    radix = _radix(tag.data) if tag.data.type != "BOOL" or not name else {}
    return _opened(element, **name, DataType=tag.data.type, **radix, Value=number)[:-1] + "/>"


def _decorated(holder: str, *lines: str) -> Iterator[str]:
    yield from (f'<{holder} Format="Decorated">', *lines, f"</{holder}>")


def _radix(data: Data) -> dict[str, str]:
    found = {"BOOL": "Decimal", "DINT": "Decimal", "SINT": "Hex", "INT": "Hex", "REAL": "Float"}
    return {"Radix": found[data.type]} if data.type in found else {}


def _member(name: str, data: Data, hidden: str, note: str, **bits: str) -> str:
    bit = data.type == "BIT" or hidden == "true"
    radix = {"Radix": "Decimal"} if bit else _radix(data) or {"Radix": "NullType"}
    head = _opened(
        "Member",
        Name=name,
        DataType=data.type,
        Dimension=str(data.size),
        **radix,
        Hidden=hidden,
        **bits,
        ExternalAccess="Read/Write",
    )
    return "\n".join([head, *_described(note), "</Member>"])


def _routine(name: str, lines: list[str]) -> Iterator[str]:
    yield from (_opened("Routine", Name=name, Type="ST"), "<STContent>")
    for number, line in enumerate(lines):
        yield _text("Line", line, Number=str(number))
    yield from ("</STContent>", "</Routine>")


def _dependencies(used: Mapping[str, str]) -> Iterator[str]:
    if used:
        yield "<Dependencies>"
        for name, kind in used.items():
            yield _opened("Dependency", Type=kind, Name=name)[:-1] + "/>"
        yield "</Dependencies>"


def _described(text: str) -> Iterator[str]:
    said = " ".join(text.split())
    if said:
        long = len(said) > _LONGEST_DESCRIPTION
        yield _text("Description", said[: _LONGEST_DESCRIPTION - 3] + "..." if long else said)


def _text(element: str, text: str, **attributes: str) -> str:
    if "]]>" in text:
        raise AssertionError("CDATA would end")
    return f"{_opened(element, **attributes)}\n<![CDATA[{text}]]>\n</{element}>"


def _opened(element: str, **attributes: str) -> str:
    return f"<{element}{''.join(f' {name}={quoteattr(v)}' for name, v in attributes.items())}>"


def _moment(time: datetime) -> str:
    return f"{time:%Y-%m-%dT%H:%M:%S}.{time.microsecond // 1000:03d}Z"
