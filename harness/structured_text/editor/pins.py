"""The pins of what a call executes, and the call as a snippet with the required inputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from structured_text.editor.index import Index
from structured_text.editor.lookup import Callee
from structured_text.editor.names import Definition
from structured_text.editor.writing import declaration, signature_text, spec_shown
from structured_text.language.standard import BLOCKS, FUNCTIONS
from structured_text.language.values import describe

__all__ = ["Pin", "call_snippet", "callee_title", "pins_of_callee", "required", "result_of"]

_INPUTS = ("VAR_INPUT", "VAR_IN_OUT")


@dataclass(frozen=True)
class Pin:
    """A pin of a block, function or method.

    Attributes:
        section: VAR_INPUT, VAR_IN_OUT or VAR_OUTPUT.
        type: Its type as written.
        default: Its initial value as written; empty if it has none.
        definition: Its declaration; None for the standard.
    """

    name: str
    section: str
    type: str
    default: str = ""
    definition: Definition | None = None

    @property
    def sign(self) -> str:
        """Return the sign between pin and argument in a call."""
        return "=>" if self.section == "VAR_OUTPUT" else ":="

    @property
    def text(self) -> str:
        """Return the pin with its type and initial value."""
        if self.section == "VAR_OUTPUT":
            return f"{self.name} => {self.type}"
        return f"{self.name} : {self.type}" + (f" := {self.default}" if self.default else "")


def pins_of_callee(index: Index, callee: Callee) -> list[Pin]:
    """Return the pins in the order of arguments without names: inputs and in-outs, then outputs."""
    if callee.definition is not None:
        pins = _declared(index, callee.key)
    elif callee.key in BLOCKS:
        pins = [
            Pin(one.name, one.section, describe(one.type)) for one in BLOCKS[callee.key].variables
        ]
    elif callee.key in FUNCTIONS:
        signature = FUNCTIONS[callee.key]
        group = signature.group[0] if len(signature.group) == 1 else "ANY"
        pins = [
            Pin(name, "VAR_INPUT", group if kind == "T" else kind) for name, kind in signature.pins
        ]
    else:
        pins = []
    inputs = [one for one in pins if one.section in _INPUTS]
    return inputs + [one for one in pins if one.section == "VAR_OUTPUT"]


def _declared(index: Index, key: str) -> list[Pin]:
    found: dict[str, Pin] = {}
    for owner in reversed(index.names.lineage(key)):
        for one in index.names.inside(owner):
            section = one.section.kind if one.section is not None else ""
            if section in (*_INPUTS, "VAR_OUTPUT"):
                default = declaration(index, one).partition(":=")[2].strip()
                kind = spec_shown(one.node.spec)
                found.setdefault(one.name.upper(), Pin(one.name, section, kind, default, one))
    return list(found.values())


def callee_title(index: Index, callee: Callee) -> str:
    """Return the name of what is called, as declared."""
    return callee.definition.name if callee.definition is not None else callee.key


def result_of(callee: Callee) -> str:
    """Return the type of the result of a function or method; empty if it has none."""
    if callee.definition is not None:
        result = getattr(callee.definition.node, "result", None)
        return spec_shown(result) if result is not None else ""
    if callee.key in FUNCTIONS:
        return signature_text(callee.key).rpartition(" : ")[2]
    return ""


def required(pins: Sequence[Pin]) -> list[Pin]:
    """Return the pins that a call should give: in-outs, and inputs without an initial value."""
    return [one for one in pins if one.section in _INPUTS and not one.default]


def call_snippet(name: str, pins: Sequence[Pin], *, named: bool = True) -> str:
    """Return a call as a snippet, with a placeholder for each required input."""
    given = [
        (f"{one.name} := " if named else "") + f"${{{number}:{_escaped(one.type)}}}"
        for number, one in enumerate(required(pins), 1)
    ]
    return f"{_escaped(name)}({', '.join(given)})"


def _escaped(text: str) -> str:
    for sign in ("\\", "$", "}"):
        text = text.replace(sign, f"\\{sign}")
    return text
