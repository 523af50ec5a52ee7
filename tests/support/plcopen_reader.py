"""From PLCopen TC6 XML 2.01 back to Structured Text: a file per type, POU and configuration."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

from plcopen_structure import check_structure, local
from rcx_harness.errors import InputError
from rcx_harness.export.output import Output
from rcx_harness.export.parts import comment
from rcx_harness.export.plcopen import ELEMENTARY, NAMESPACE, POU_KINDS, SECTIONS

__all__ = ["read_plcopen"]

_TYPES = {element: name for name, element in reversed(ELEMENTARY.items())}
_KINDS = {element: kind for kind, element in POU_KINDS.items()}
_WORDS = {element: word for word, element in SECTIONS.items()}
_BREAK = "\n    "
_QUALIFIERS = {"constant": " CONSTANT", "retain": " RETAIN", "nonretain": " NON_RETAIN"}


def read_plcopen(file: Path) -> Output:
    """Read a project whose bodies are Structured Text.

    Args:
        file: The XML, of this project's exporter or another's.

    Returns:
        The ST files by their names.

    Raises:
        InputError: the file cannot be read, is no such project, or has a body in another
            language.
    """
    try:
        root = ET.fromstring(file.read_bytes())
    except OSError as error:
        raise InputError(f"cannot read the file: {error.strerror}", file=file) from None
    except ET.ParseError as error:
        line, column = error.position
        raise InputError("is no well-formed XML", file=file, line=line, column=column) from None
    try:
        check_structure(root)
    except InputError as error:
        raise InputError(error.message, file=file, hint=error.hint) from None
    files: dict[str, str] = {}
    for path, write in (
        ("types/dataTypes/dataType", _data_type),
        ("types/pous/pou", _pou),
        ("instances/configurations/configuration", _configuration),
    ):
        for element in root.findall("/".join(f"{{*}}{step}" for step in path.split("/"))):
            lines = [*_comment(_said(element)), *write(element)]
            files[f"{element.attrib['name']}.st"] = "\n".join(lines) + "\n"
    return Output(files)


def _child(element: ET.Element, name: str) -> ET.Element:
    found = element.find(f"{{{NAMESPACE}}}{name}")
    assert found is not None, name
    return found


def _children(element: ET.Element, name: str) -> list[ET.Element]:
    return element.findall(f"{{{NAMESPACE}}}{name}")


def _said(element: ET.Element) -> str:
    """The text of an element's documentation."""
    texts = ("".join(one.itertext()).strip() for one in _children(element, "documentation"))
    return "\n".join(texts).replace("*)", "* )")


def _comment(text: str) -> list[str]:
    return [comment(text)] if text else []


def _data_type(element: ET.Element) -> Iterator[str]:
    yield "TYPE"
    (base,) = _child(element, "baseType")
    if local(base) == "struct":
        yield f"  {element.attrib['name']} : STRUCT"
        for variable in _children(base, "variable"):
            yield _variable(variable, "    ")
        yield f"  END_STRUCT{_initial(element)};"
    else:
        yield f"  {element.attrib['name']} : {_type(base)}{_initial(element)};"
    yield "END_TYPE"


def _type(element: ET.Element) -> str:
    name = local(element)
    if name == "derived":
        return element.attrib["name"]
    if name == "array":
        bounds = (f"{one.attrib['lower']}..{one.attrib['upper']}" for one in element[:-1])
        return f"ARRAY [{', '.join(bounds)}] OF {_type(element[-1][0])}"
    if name == "enum":
        values = _child(element, "values")
        if any("value" in one.attrib for one in values):
            raise InputError("an enumeration with explicit values is not supported")
        return f"(\n    {(',' + _BREAK).join(one.attrib['name'] for one in values)}\n  )"
    if name == "struct":
        raise InputError("a structure inside a declaration is not supported", hint="name its type")
    if "length" in element.attrib:
        raise InputError("a string with a length is not supported", hint="use plain strings")
    return _TYPES[name]


def _initial(element: ET.Element) -> str:
    found = _children(element, "initialValue")
    return f" := {_value(found[0][0])}" if found else ""


def _value(element: ET.Element) -> str:
    name = local(element)
    if name == "simpleValue":
        return element.get("value", "")
    if name == "structValue":
        fields = (f"{one.attrib['member']} := {_value(one[0])}" for one in element)
        return f"({', '.join(fields)})"
    items = []
    for one in element:
        count, item = one.get("repetitionValue", "1"), _value(one[0])
        items.append(item if count == "1" else f"{count}({item})")
    return f"[{', '.join(items)}]"


def _variable(element: ET.Element, indent: str) -> str:
    address = f" AT {element.attrib['address']}" if "address" in element.attrib else ""
    kind = _type(_child(element, "type")[0])
    return _noted(
        f"{indent}{element.attrib['name']}{address} : {kind}{_initial(element)};", element
    )


def _section(element: ET.Element, indent: str) -> Iterator[str]:
    qualifier = "".join(
        word for name, word in _QUALIFIERS.items() if element.get(name) in ("true", "1")
    )
    yield f"{indent}{_WORDS[local(element)]}{qualifier}"
    for variable in _children(element, "variable"):
        yield _variable(variable, f"{indent}  ")
    yield f"{indent}END_VAR"


def _pou(element: ET.Element) -> Iterator[str]:
    kind = _KINDS[element.attrib["pouType"]]
    head = f"{kind} {element.attrib['name']}"
    lists: list[ET.Element] = []
    for interface in _children(element, "interface"):
        for result in _children(interface, "returnType"):
            head += f" : {_type(result[0])}"
        lists = [one for one in interface if local(one) in _WORDS]
    yield head
    for one in lists:
        yield from _section(one, "  ")
    for body in _children(element, "body"):
        yield "".join(_child(body, "ST")[0].itertext()).strip("\n")
    yield f"END_{kind}"


def _configuration(element: ET.Element) -> Iterator[str]:
    yield f"CONFIGURATION {element.attrib['name']}"
    for one in _children(element, "globalVars"):
        yield from _section(one, "  ")
    for resource in _children(element, "resource"):
        yield f"  RESOURCE {resource.attrib['name']} ON PLC"
        for one in _children(resource, "globalVars"):
            yield from _section(one, "    ")
        tasks = _children(resource, "task")
        for task in tasks:
            name, priority = task.attrib["name"], task.attrib["priority"]
            given = task.get("interval")
            interval = f"INTERVAL := {given}, " if given else ""
            yield _noted(f"    TASK {name}({interval}PRIORITY := {priority});", task)
        for task in tasks:
            for one in _children(task, "pouInstance"):
                yield _instance(one, f" WITH {task.attrib['name']}")
        for one in _children(resource, "pouInstance"):
            yield _instance(one, "")
        yield "  END_RESOURCE"
    yield "END_CONFIGURATION"


def _instance(element: ET.Element, task: str) -> str:
    text = f"    PROGRAM {element.attrib['name']}{task} : {element.attrib['typeName']};"
    return _noted(text, element)


def _noted(text: str, element: ET.Element) -> str:
    """A declaration with what is said of it."""
    return " ".join([text, *_comment(_said(element))])
