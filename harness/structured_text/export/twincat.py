"""Export for TwinCAT 3: a `.TcPOU` or `.TcDUT` per declaration, and parts of a `.plcproj`."""

from __future__ import annotations

import re
from collections.abc import Iterable
from uuid import UUID, uuid5
from xml.sax.saxutils import escape, quoteattr

from structured_text.export.body import Body, Scope
from structured_text.export.losses import lost_configuration
from structured_text.export.output import Missing, Output
from structured_text.export.parts import Part, Sources, comment
from structured_text.export.words import unwritten, words
from structured_text.language import syntax as s
from structured_text.language.lexer import tokens

__all__ = ["to_twincat"]

#: Namespace for the identifiers of objects. The same name always gives the same identifier.
_SPACE = UUID("5b0f6a2e-7c0d-5f0e-9d0e-52435833f0b1")

_OBJECT = """\
<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1" ProductVersion="3.1.4024.0">
  <{kind} Name={name} Id="{{{id}}}"{body[0]}>
    <Declaration><![CDATA[{declaration}
]]></Declaration>{body[1]}
  </{kind}>
</TcPlcObject>
"""
_BODY = """
    <Implementation>
      <ST><![CDATA[{}
]]></ST>
    </Implementation>"""
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


def to_twincat(sources: Sources) -> Output:
    """Write a folder of objects, and a project with the item groups that list them.

    Only the global variables of a CONFIGURATION are exported. In TwinCAT, tasks are objects of the
    project that call programs by the names of their types.
    """
    files, lost = {}, list[Missing]()
    # The folder of the objects has the same name in the project and on the disk.
    root = sources.names.project
    barred = unwritten(sources.parts, words("twincat"))
    for part in sources.parts:
        if part.kind == "CONFIGURATION":
            todo = "make a task in the project and let it call the program"
            lost.append(lost_configuration(part, todo, without_globals=True))
            if globals_ := _globals(part):
                files[f"{root}/{part.folder}/{part.name}.TcGVL"] = globals_
            continue
        if part.name.upper() in barred:
            lost.append(barred[part.name.upper()])
            continue
        ending = "TcDUT" if part.kind == "TYPE" else "TcPOU"
        text = _dut(part) if part.kind == "TYPE" else _pou(part, sources)
        files[f"{root}/{part.folder}/{part.name}.{ending}"] = text
    project = _PROJECT.format(
        notice=sources.notice,
        root=root,
        compile="\n".join(_COMPILE.format(_windows(path)) for path in sorted(files)),
        folders="\n".join(_FOLDER.format(_windows(path)) for path in _folders(files)),
    )
    return Output({f"{root}.plcproj": project, **files}, tuple(lost), newline="\r\n")


def _globals(part: Part) -> str:
    """Return a CONFIGURATION's global variables as a TwinCAT GVL; empty if it has none."""
    assert isinstance(part.node, s.Configuration)
    if not part.node.globals:
        return ""
    found = list(tokens(part.head, part.file))
    begins = [one for one in found if one.type == "VAR_GLOBAL"]
    ends = [one for one in found if one.type == "END_VAR"]
    texts = [
        part.head[first.start_pos : (last.start_pos or 0) + len(last)]
        for first, last in zip(begins, ends, strict=True)
    ]
    return _object("GVL", part, "\n".join(_retained(text, part) for text in texts))


def _retained(text: str, part: Part) -> str:
    """Return a head without the word NON_RETAIN, which TwinCAT lacks and does not need."""
    for one in reversed([one for one in tokens(text, part.file) if one.type == "NON_RETAIN"]):
        at = one.start_pos or 0
        text = f"{text[:at].rstrip(' ')}{text[at + len(one) :]}"
    return text


def _pou(part: Part, sources: Sources) -> str:
    head = _retained(part.head, part)
    declaration = f"{comment(part.header)}\n{head}" if part.header else head
    body = _data(Body(part.body, Scope.of(part, sources), words("twincat")).all())
    return _object("POU", part, declaration, (' SpecialFunc="None"', _BODY.format(body)))


def _dut(part: Part) -> str:
    text = f"{comment(part.header)}\n{part.head}" if part.header else part.head
    return _object("DUT", part, re.sub(r"\bEND_STRUCT\s*;", "END_STRUCT", text))


def _object(kind: str, part: Part, declaration: str, body: tuple[str, str] = ("", "")) -> str:
    """Return the text of an object's file; `body` contains the parts that only a POU has."""
    return _OBJECT.format(
        kind=kind,
        name=quoteattr(part.name),
        id=uuid5(_SPACE, f"{part.kind} {part.name.upper()}"),
        declaration=_data(declaration),
        body=body,
    )


def _data(text: str) -> str:
    """Return a text for use inside CDATA; an end mark `]]>` in the text is split."""
    return text.replace("]]>", "]]]]><![CDATA[>")


def _windows(path: str) -> str:
    return escape(path.replace("/", "\\"))


def _folders(files: Iterable[str]) -> list[str]:
    found = {path.rpartition("/")[0] for path in files}
    parents = {"/".join(path.split("/")[:end]) for path in found for end in range(1, 9)}
    return sorted(found | parents)
