"""The order of elements and their attributes in the L5X files that we write and read.

The rules restate Rockwell's manual 1756-RM084 (Logix 5000 Controllers Import/Export) for data
types, Add-On Instructions and programs in Structured Text. The schema itself is not public.
"""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element

#: Children of each element in their order. Each child may be missing or repeated.
CHILDREN = {
    "RSLogix5000Content": ("Controller",),
    "Controller": ("DataTypes", "AddOnInstructionDefinitions", "Tags", "Programs", "Tasks"),
    "DataTypes": ("DataType",),
    "DataType": ("Description", "Members", "Dependencies"),
    "Members": ("Member",),
    "Member": ("Description",),
    "Dependencies": ("Dependency",),
    "AddOnInstructionDefinitions": ("AddOnInstructionDefinition",),
    "AddOnInstructionDefinition": (
        *("Description", "RevisionNote", "SignatureHistory", "AdditionalHelpText", "Parameters"),
        *("LocalTags", "Routines", "Dependencies"),
    ),
    "Parameters": ("Parameter",),
    "Parameter": ("Description", "DefaultData"),
    "LocalTags": ("LocalTag",),
    "LocalTag": ("Description", "DefaultData"),
    "Routines": ("Routine",),
    "Routine": ("Description", "STContent"),
    "STContent": ("Line",),
    "Programs": ("Program",),
    "Program": ("Description", "Tags", "Routines"),
    "Tags": ("Tag",),
    "Tag": ("Description", "Data"),
    "DefaultData": ("DataValue", "Structure"),
    "Data": ("DataValue", "Structure"),
    "Structure": ("DataValueMember",),
}

_LEAVES = ("Description", "AdditionalHelpText", "RevisionNote", "Line", "Dependency")
_VALUES = ("DataValue", "DataValueMember")

#: Attributes of each element in their order. Attributes in parentheses may be missing.
ORDER = {
    "RSLogix5000Content": "SchemaRevision SoftwareRevision TargetName TargetType (TargetRevision) "
    "(TargetLastEdited) ContainsContext (Owner) (ExportDate) (ExportOptions)",
    "Controller": "Use Name",
    "DataType": "(Use) Name Family Class",
    "Member": "Name DataType Dimension (Radix) Hidden (Target) (BitNumber) (ExternalAccess)",
    "Dependency": "Type Name",
    "AddOnInstructionDefinition": "(Use) Name Revision (Vendor) ExecutePrescan ExecutePostscan "
    "ExecuteEnableInFalse CreatedDate CreatedBy EditedDate EditedBy SoftwareRevision",
    "Parameter": "Name TagType DataType (Dimensions) Usage (Radix) Required Visible (Constant) "
    "(ExternalAccess)",
    "LocalTag": "Name DataType (Dimensions) (Radix) (ExternalAccess)",
    "Tag": "Name TagType DataType (Dimensions) (Radix) Constant (ExternalAccess)",
    "Routine": "Name Type",
    "Line": "Number",
    "Program": "Use Name TestEdits MainRoutineName Disabled UseAsFolder",
    "DefaultData": "Format (Length)",
    "Data": "Format (Length)",
    "Structure": "DataType",
    "DataValue": "DataType (Radix) Value",
    "DataValueMember": "Name DataType (Radix) Value",
}

_NAME = re.compile(r"(?!.*__)(?!.*_$)[A-Za-z_][A-Za-z0-9_]{0,39}")
_HIDDEN = "ZZZZZZZZZZ"


def faults(root: Element) -> list[str]:
    """Return the violations of the structure, each with the path of its element."""
    if root.tag != "RSLogix5000Content":
        return [f"the root is {root.tag}, not RSLogix5000Content"]
    return [*_below(root, root.tag)]


def _below(element: Element, path: str) -> list[str]:
    found = _attributes(element, path)
    allowed = CHILDREN.get(element.tag, ())
    last = 0
    for child in element:
        where = f"{path}/{child.tag}"
        if child.get("Name"):
            where += f" {child.get('Name')}"
        if child.tag not in allowed:
            found.append(f"{where}: this element is not allowed here")
            continue
        rank = allowed.index(child.tag)
        if rank < last:
            found.append(f"{where}: must come before {allowed[last]}")
        last = max(last, rank)
        found += _below(child, where)
    if element.tag in _VALUES and not re.fullmatch(r"-?[\d.E+-]+", element.get("Value", "")):
        found.append(f"{path}: {element.get('Value')} is not a number")
    return found


def _attributes(element: Element, path: str) -> list[str]:
    order = ORDER.get(element.tag, "(Use)" if element.tag not in _LEAVES else "").split()
    names = [name.strip("()") for name in order]
    given = list(element.attrib)
    found = [
        f"{path}: {name} is missing"
        for name in order
        if not name.startswith("(") and name not in given
    ]
    unknown = [name for name in given if name not in names]
    found += [f"{path}: there is no attribute {name}" for name in unknown]
    present = [names.index(name) for name in given if name in names]
    if present != sorted(present):
        found.append(f"{path}: the attributes are in the wrong order")
    name = element.get("Name", "X")
    if not name.startswith(_HIDDEN) and not _NAME.fullmatch(name):
        found.append(f"{path}: {name} is not a valid name")
    return found
