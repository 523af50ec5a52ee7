"""Export as PLCopen TC6 XML 2.01, for Beremiz, CODESYS, Machine Expert and others."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from xml.etree import ElementTree as ET

from structured_text.errors import COMMAND
from structured_text.export.body import Body, Scope
from structured_text.export.ladder.body import Ladder, ladder_of
from structured_text.export.ladder.drawing import write_diagram
from structured_text.export.output import Output
from structured_text.export.parts import Part, Sources
from structured_text.export.words import words
from structured_text.language import syntax as s
from structured_text.language.library import Names
from structured_text.language.printer import expression_text, init_text
from structured_text.output.exported import release
from structured_text.projects import plcopen

__all__ = ["ELEMENTARY", "NAMESPACE", "POU_KINDS", "SECTIONS", "XHTML", "to_ladder", "to_plcopen"]

NAMESPACE = "http://www.plcopen.org/xml/tc6_0201"
XHTML = "http://www.w3.org/1999/xhtml"

#: The XML element of each section of variables.
SECTIONS = {section: element for element, section in plcopen.SECTIONS.items()}

#: The `pouType` of each kind of POU.
POU_KINDS = {kind: name for name, kind in plcopen.KINDS.items()}

_PLAIN = (
    *("BOOL", "BYTE", "WORD", "DWORD", "LWORD", "SINT", "INT", "DINT", "LINT", "USINT", "UINT"),
    *("UDINT", "ULINT", "REAL", "LREAL", "TIME", "DATE", "DT", "TOD"),
)

#: The XML element of each elementary type.
ELEMENTARY = {
    **{name: name for name in _PLAIN},
    "DATE_AND_TIME": "DT",
    "TIME_OF_DAY": "TOD",
    "STRING": "string",
}

_PRODUCT = f"{COMMAND} export"
#: The schema requires a date. It is constant, so that the same sources give the same file.
_DATE = "2026-01-01T00:00:00"

_QUALIFIERS = {"CONSTANT": "constant", "RETAIN": "retain", "NON_RETAIN": "nonretain"}


def to_plcopen(sources: Sources) -> Output:
    """Write one project with all types, POUs and configurations.

    Interfaces are elements, with the comments as documentation. Bodies are the source's own text.
    The arguments of standard functions are passed by position, because tools differ in their names.
    The schema does not provide for comments of an enumeration's members. They are part of the
    documentation of the type.
    """
    return _project(sources, {})


def to_ladder(sources: Sources) -> Output:
    """Write one project in which the bodies of the user's programs and blocks are ladder.

    The library stays in Structured Text. So do functions.
    """
    users = [part for part in sources.of("PROGRAM", "FUNCTION_BLOCK") if part.folder == "program"]
    ladders = {part.name: ladder_of(part, sources) for part in users}
    notes = tuple(note for ladder in ladders.values() for note in ladder.notes)
    return replace(_project(sources, ladders), notes=notes)


def _project(sources: Sources, ladders: Mapping[str, Ladder]) -> Output:
    root = ET.Element("project", xmlns=NAMESPACE)
    root.set("xmlns:xhtml", XHTML)
    _headers(root, sources.names)
    types = ET.SubElement(root, "types")
    data_types = ET.SubElement(types, "dataTypes")
    for part in sources.of("TYPE"):
        _data_type(data_types, part)
    pous = ET.SubElement(types, "pous")
    for part in sources.of(*POU_KINDS):
        ladder = ladders.get(part.name, Ladder())
        for block in ladder.blocks:
            _pou(pous, block, sources, Ladder())
        _pou(pous, part, sources, ladder)
    configurations = ET.SubElement(ET.SubElement(root, "instances"), "configurations")
    for part in sources.of("CONFIGURATION"):
        _configuration(configurations, part)
    _document(root, sources.notice)
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode")
    head = '<?xml version="1.0" encoding="utf-8"?>'
    return Output({"": f"{head}\n{text}\n"}, mark=f'productName="{_PRODUCT}"')


def _headers(root: ET.Element, names: Names) -> None:
    ET.SubElement(
        root,
        "fileHeader",
        companyName=names.owner,
        productName=_PRODUCT,
        productVersion=release(),
        creationDateTime=_DATE,
    )
    content = ET.SubElement(root, "contentHeader", name=names.project, modificationDateTime=_DATE)
    coordinates = ET.SubElement(content, "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        ET.SubElement(ET.SubElement(coordinates, language), "scaling", x="1", y="1")


def _said(part: Part) -> str:
    """Return the header of a declaration, and its comments that belong to none of its names."""
    return "\n".join(filter(None, [part.header, part.notes.get("")]))


def _document(parent: ET.Element, text: str) -> None:
    if text:
        ET.SubElement(ET.SubElement(parent, "documentation"), "xhtml:p").text = text


def _data_type(parent: ET.Element, part: Part) -> None:
    node = part.node
    assert isinstance(node, s.TypeDecl)
    element = ET.SubElement(parent, "dataType", name=part.name)
    _type(ET.SubElement(element, "baseType"), node.spec, part)
    _initial(element, node.initial)
    notes = []
    if isinstance(node.spec, s.EnumSpec):
        said = ((member.text, part.notes.get(member.key)) for member in node.spec.members)
        notes = [f"{name}: {note}" for name, note in said if note]
    _document(element, "\n".join(filter(None, [_said(part), *notes])))


def _type(parent: ET.Element, spec: s.TypeSpec, part: Part) -> None:
    if isinstance(spec, s.NamedSpec):
        if plain := ELEMENTARY.get(spec.name.key):
            ET.SubElement(parent, plain)
        else:
            ET.SubElement(parent, "derived", name=spec.name.text)
    elif isinstance(spec, s.ArraySpec):
        array = ET.SubElement(parent, "array")
        for one in spec.dimensions:
            low, high = expression_text(one.low), expression_text(one.high)
            ET.SubElement(array, "dimension", lower=low, upper=high)
        _type(ET.SubElement(array, "baseType"), spec.element, part)
    elif isinstance(spec, s.EnumSpec):
        values = ET.SubElement(ET.SubElement(parent, "enum"), "values")
        for member in spec.members:
            ET.SubElement(values, "value", name=member.text)
    else:
        assert isinstance(spec, s.StructSpec)
        struct = ET.SubElement(parent, "struct")
        for field in spec.fields:
            _variables(struct, field, part)


def _variables(parent: ET.Element, declared: s.VarDecl, part: Part) -> None:
    for name in declared.names:
        element = ET.SubElement(parent, "variable", name=name.text)
        if declared.address is not None:
            element.set("address", declared.address.text)
        _type(ET.SubElement(element, "type"), declared.spec, part)
        _initial(element, declared.initial)
        _document(element, part.notes.get(name.key, ""))


def _initial(parent: ET.Element, init: s.Init | None) -> None:
    if init is not None:
        _value(ET.SubElement(parent, "initialValue"), init)


def _value(parent: ET.Element, init: s.Init) -> None:
    if isinstance(init, s.ArrayInit):
        array = ET.SubElement(parent, "arrayValue")
        for count, item in init.items:
            one = ET.SubElement(array, "value")
            if count is not None:
                one.set("repetitionValue", expression_text(count))
            _value(one, item)
    elif isinstance(init, s.StructInit):
        struct = ET.SubElement(parent, "structValue")
        for name, item in init.fields:
            _value(ET.SubElement(struct, "value", member=name.text), item)
    else:
        ET.SubElement(parent, "simpleValue", value=init_text(init))


def _pou(parent: ET.Element, part: Part, sources: Sources, ladder: Ladder) -> None:
    node = part.node
    assert isinstance(node, s.Pou)
    element = ET.SubElement(parent, "pou", name=part.name, pouType=POU_KINDS[part.kind])
    interface = ET.SubElement(element, "interface")
    if node.result is not None:
        _type(ET.SubElement(interface, "returnType"), node.result, part)
    for section in node.sections:
        _section(interface, section, part)
    if ladder.variables:
        _added(ET.SubElement(interface, SECTIONS["VAR"]), ladder)
    body = ET.SubElement(element, "body")
    scope = Scope.of(part, sources)
    if ladder.diagram is not None:
        write_diagram(body, ladder.diagram, lambda text: Body(text, scope, words("iec")).all())
    else:
        text = Body(part.body, scope, words("iec")).all()
        ET.SubElement(ET.SubElement(body, "ST"), "xhtml:p").text = text
    _document(element, _said(part))


def _added(parent: ET.Element, ladder: Ladder) -> None:
    """Add the variables that the rungs need in addition to those of the POU."""
    for name, kind in ladder.variables:
        element = ET.SubElement(ET.SubElement(parent, "variable", name=name), "type")
        if plain := ELEMENTARY.get(kind):
            ET.SubElement(element, plain)
        else:
            ET.SubElement(element, "derived", name=kind)


def _section(parent: ET.Element, section: s.Section, part: Part) -> None:
    element = ET.SubElement(parent, SECTIONS[section.kind])
    if section.qualifier:
        element.set(_QUALIFIERS[section.qualifier], "true")
    for declared in section.variables:
        _variables(element, declared, part)


def _configuration(parent: ET.Element, part: Part) -> None:
    node = part.node
    assert isinstance(node, s.Configuration)
    element = ET.SubElement(parent, "configuration", name=part.name)
    code = re.sub(r"\(\*.*?\*\)", " ", part.head, flags=re.DOTALL)
    named = re.search(r"\bRESOURCE\s+(\w+)\s+ON\b", code, re.IGNORECASE)
    resource = ET.SubElement(element, "resource", name=named[1] if named else "Resource0")
    for task in node.tasks:
        settings = {name.key: expression_text(value) for name, value in task.settings}
        one = ET.SubElement(resource, "task", name=task.name.text)
        if "INTERVAL" in settings:
            one.set("interval", settings["INTERVAL"])
        one.set("priority", settings.get("PRIORITY", "65535"))
        for program in node.programs:
            if program.task is not None and program.task.key == task.name.key:
                _instance(one, program, part)
        _document(one, part.notes.get(task.name.key, ""))
    for section in node.globals:
        _section(resource, section, part)
    for program in node.programs:
        if program.task is None:
            _instance(resource, program, part)
    _document(element, _said(part))


def _instance(parent: ET.Element, program: s.ProgramInstance, part: Part) -> None:
    names = {"name": program.name.text, "typeName": program.program.text}
    element = ET.SubElement(parent, "pouInstance", names)
    _document(element, part.notes.get(program.name.key, ""))
