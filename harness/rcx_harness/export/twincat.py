"""TwinCAT 3: a `.TcPOU` or `.TcDUT` for each declaration, and what the `.plcproj` needs."""

from __future__ import annotations

import re
from collections.abc import Iterable
from uuid import UUID, uuid5
from xml.sax.saxutils import escape, quoteattr

from rcx_harness.export.body import Body, Scope
from rcx_harness.export.output import NOTICE, Output
from rcx_harness.export.parts import Part, Sources, comment
from rcx_harness.export.words import unwritten, words

__all__ = ["to_twincat"]

#: Of the identifiers of all objects; with the name of the object it gives the same one each time.
_SPACE = UUID("5b0f6a2e-7c0d-5f0e-9d0e-52435833f0b1")

_OBJECT = """\
<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1" ProductVersion="3.1.4024.0">
  {element}
</TcPlcObject>
"""
_POU = """\
<POU Name={name} Id="{{{id}}}" SpecialFunc="None">
    <Declaration><![CDATA[{declaration}
]]></Declaration>
    <Implementation>
      <ST><![CDATA[{body}
]]></ST>
    </Implementation>
  </POU>"""
_DUT = """\
<DUT Name={name} Id="{{{id}}}">
    <Declaration><![CDATA[{declaration}
]]></Declaration>
  </DUT>"""
_PROJECT = """\
<?xml version="1.0" encoding="utf-8"?>
<!--
{notice}

Copy these item groups into the .plcproj of your PLC project, and the folder {root} beside it.
-->
<Project DefaultTargets="Build" xmlns="http://schemas.microsoft.com/developer/msbuild/2003">
  <ItemGroup>
{compile}
  </ItemGroup>
  <ItemGroup>
{folders}
  </ItemGroup>
  <ItemGroup>
    <PlaceholderReference Include="Tc2_Standard">
      <DefaultResolution>Tc2_Standard, * (Beckhoff Automation GmbH)</DefaultResolution>
      <Namespace>Tc2_Standard</Namespace>
    </PlaceholderReference>
  </ItemGroup>
</Project>
"""
_COMPILE = '    <Compile Include="{}">\n      <SubType>Code</SubType>\n    </Compile>'
_FOLDER = '    <Folder Include="{}" />'

#: Folder of the objects, in the project and on the disk.
_ROOT = "RCX3"


def to_twincat(sources: Sources) -> Output:
    """A folder of objects, and `RCX3.plcproj` with the item groups that name them.

    A CONFIGURATION has no counterpart: in TwinCAT, tasks are objects of the project that call
    programs by their type's name.
    """
    files, left_out = {}, []
    barred = unwritten(sources.parts, words("twincat"))
    for part in sources.parts:
        if part.kind == "CONFIGURATION":
            left_out.append(
                f"CONFIGURATION {part.name}: make a task in the project and let it call the program"
            )
            continue
        if part.name.upper() in barred:
            left_out.append(f"{part.kind} {part.name}: {barred[part.name.upper()]}")
            continue
        ending = "TcDUT" if part.kind == "TYPE" else "TcPOU"
        element = _dut(part) if part.kind == "TYPE" else _pou(part, sources)
        files[f"{_ROOT}/{part.folder}/{part.name}.{ending}"] = _OBJECT.format(element=element)
    project = _PROJECT.format(
        notice=NOTICE,
        root=_ROOT,
        compile="\n".join(_COMPILE.format(_windows(path)) for path in sorted(files)),
        folders="\n".join(_FOLDER.format(_windows(path)) for path in _folders(files)),
    )
    return Output({f"{_ROOT}.plcproj": project, **files}, tuple(left_out), newline="\r\n")


def _pou(part: Part, sources: Sources) -> str:
    declaration = f"{comment(part.header)}\n{part.head}" if part.header else part.head
    return _POU.format(
        name=quoteattr(part.name),
        id=_identifier(part),
        declaration=_data(declaration),
        body=_data(Body(part.body, Scope.of(part, sources), words("twincat")).all()),
    )


def _dut(part: Part) -> str:
    text = f"{comment(part.header)}\n{part.head}" if part.header else part.head
    declaration = re.sub(r"\bEND_STRUCT\s*;", "END_STRUCT", text)
    return _DUT.format(
        name=quoteattr(part.name), id=_identifier(part), declaration=_data(declaration)
    )


def _identifier(part: Part) -> UUID:
    return uuid5(_SPACE, f"{part.kind} {part.name.upper()}")


def _data(text: str) -> str:
    """A text inside CDATA, which cannot hold its own end."""
    return text.replace("]]>", "]]]]><![CDATA[>")


def _windows(path: str) -> str:
    return escape(path.replace("/", "\\"))


def _folders(files: Iterable[str]) -> list[str]:
    found = {path.rpartition("/")[0] for path in files}
    parents = {"/".join(path.split("/")[:end]) for path in found for end in range(1, 9)}
    return sorted(found | parents)
