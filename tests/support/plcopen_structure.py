"""The order of elements and attributes in the schema of PLCopen TC6 XML 2.01."""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

from structured_text.errors import InputError
from structured_text.export.plcopen import ELEMENTARY, NAMESPACE, SECTIONS, XHTML

_DATA_TYPE = f"({'|'.join({**dict.fromkeys(ELEMENTARY.values())})}|array|derived|enum|struct),"
_LISTS = "|".join(SECTIONS.values())
_REMARKS = "(addData,)?(documentation,)?"

#: Objects of ladder, and the begin of a contact and a coil.
_OBJECTS = (
    *("comment", "leftPowerRail", "rightPowerRail", "contact", "coil"),
    *("inVariable", "outVariable", "block"),
)
_ENDS = "position,(connectionPointIn,)?(connectionPointOut,)?"
#: The children and attributes of a variable at a contact or coil, and at a pin of a block.
_VARIABLES = {
    **dict.fromkeys(("contact", "coil"), ("", "")),
    "inputVariables": (f"connectionPointIn,{_REMARKS}", "formalParameter"),
    "outputVariables": (f"connectionPointOut,{_REMARKS}", "formalParameter"),
}

#: The children of each element, in the order of the schema, as far as this project writes and reads
#: them. After them, the required attributes.
_CHILDREN: dict[str, tuple[str, str]] = {
    "project": (f"fileHeader,contentHeader,types,instances,{_REMARKS}", ""),
    "fileHeader": ("", "companyName productName productVersion creationDateTime"),
    "contentHeader": ("(Comment,)?coordinateInfo,(addDataInfo,)?(addData,)?", "name"),
    "coordinateInfo": ("(pageSize,)?fbd,ld,sfc,", ""),
    **dict.fromkeys(("fbd", "ld", "sfc"), ("scaling,", "")),
    "scaling": ("", "x y"),
    "types": ("dataTypes,pous,", ""),
    "dataTypes": ("(dataType,)*", ""),
    "dataType": (f"baseType,(initialValue,)?{_REMARKS}", "name"),
    "pous": ("(pou,)*", ""),
    "pou": (f"(interface,)?(body,)*{_REMARKS}", "name pouType"),
    "interface": (f"(returnType,)?(({_LISTS}),)*{_REMARKS}", ""),
    **dict.fromkeys(("returnType", "type", "baseType"), (_DATA_TYPE, "")),
    **dict.fromkeys((*SECTIONS.values(), "struct"), (f"(variable,)*{_REMARKS}", "")),
    "variable": (f"type,(initialValue,)?{_REMARKS}", "name"),
    "initialValue": ("((simpleValue|arrayValue|structValue),)", ""),
    "simpleValue": ("", ""),
    **dict.fromkeys(("arrayValue", "structValue"), ("(value,)*", "")),
    "array": ("(dimension,)+baseType,", ""),
    "dimension": ("", "lower upper"),
    "derived": ("(addData,)?", "name"),
    "enum": ("values,(baseType,)?", ""),
    "values": ("(value,)+", ""),
    "body": (f"(ST|LD),{_REMARKS}", ""),
    "LD": (f"(({'|'.join(_OBJECTS)}),)*", ""),
    "comment": (f"position,content,{_REMARKS}", "localId width height"),
    "content": ("xhtml,", ""),
    "leftPowerRail": (f"position,(connectionPointOut,)*{_REMARKS}", "localId"),
    "rightPowerRail": (f"position,(connectionPointIn,)*{_REMARKS}", "localId"),
    **dict.fromkeys(("contact", "coil"), (f"{_ENDS}variable,{_REMARKS}", "localId")),
    "inVariable": (f"position,(connectionPointOut,)?expression,{_REMARKS}", "localId"),
    "outVariable": (f"position,(connectionPointIn,)?expression,{_REMARKS}", "localId"),
    "block": (
        f"position,inputVariables,inOutVariables,outputVariables,{_REMARKS}",
        "localId typeName",
    ),
    **dict.fromkeys(("inputVariables", "inOutVariables", "outputVariables"), ("(variable,)*", "")),
    "connectionPointIn": ("(relPosition,)?((connection,)+|expression,)?(addData,)?", ""),
    "connectionPointOut": ("(relPosition,)?(expression,)?(addData,)?", ""),
    "connection": ("(position,)*(addData,)?", "refLocalId"),
    **dict.fromkeys(("position", "relPosition"), ("", "x y")),
    "expression": ("", ""),
    "instances": ("configurations,", ""),
    "configurations": ("(configuration,)*", ""),
    "configuration": (f"(resource,)*(globalVars,)*{_REMARKS}", "name"),
    "resource": (f"(task,)*(globalVars,)*(pouInstance,)*{_REMARKS}", "name"),
    "task": (f"(pouInstance,)*{_REMARKS}", "name priority"),
    "pouInstance": (_REMARKS, "name typeName"),
    **dict.fromkeys(("ST", "documentation"), ("xhtml,", "")),
    **dict.fromkeys(ELEMENTARY.values(), ("", "")),
}


def local(element: ET.Element) -> str:
    """Return an element's name without its namespace, or `xhtml` for any element of XHTML."""
    space, _, name = element.tag.rpartition("}")
    return "xhtml" if space == f"{{{XHTML}" else name


def check_structure(root: ET.Element) -> None:
    """Check that elements and attributes are where the schema of TC6 2.01 allows them.

    The check covers projects in Structured Text and in ladder. It refuses function block diagrams
    and other languages.

    Raises:
        InputError: the namespace is wrong, an element is unknown or misplaced, or an attribute is
        missing.
    """
    if root.tag != f"{{{NAMESPACE}}}project":
        raise InputError(f"<{root.tag}> is not a project of PLCopen TC6 XML 2.01")
    waiting = [(root, "")]
    while waiting:
        element, above = waiting.pop()
        name = local(element)
        path = f"{above}/{name}"
        known = _CHILDREN.get(name)
        if known is None or not element.tag.startswith(f"{{{NAMESPACE}}}"):
            raise InputError(f"{path}: <{name}> is not supported", hint="use ST or LD")
        parent = above.rpartition("/")[2]
        children, attributes = _VARIABLES.get(parent, known) if name == "variable" else known
        if name == "value":
            continue
        for attribute in attributes.split():
            if attribute not in element.attrib:
                raise InputError(f"{path}: the attribute {attribute} is missing")
        found = "".join(f"{local(child)}," for child in element)
        if not re.fullmatch(children, found):
            raise InputError(
                f"{path}: its elements are {found[:-1] or 'missing'}, expected {children}"
            )
        waiting += [
            (child, path)
            for child in element
            if local(child) not in ("xhtml", "addData", "addDataInfo", "Comment", "value")
        ]
