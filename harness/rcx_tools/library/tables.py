"""Reader of spec/blocks.toml: the command blocks, their pins, and the types of the pins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import lru_cache
from typing import Any

from rcx_harness import spec
from rcx_harness.spec.telegram import Command, Field
from structured_text.errors import InputError, did_you_mean
from structured_text.output.toml_files import load_toml

__all__ = [
    "CATEGORIES",
    "Array",
    "Block",
    "Enumeration",
    "Input",
    "Library",
    "Member",
    "Output",
    "library",
]

#: Maps each category of remote commands in the guide to the folder of its blocks and to its title.
CATEGORIES = {
    1: ("movement", "movement"),
    2: ("definition", "definition and reference"),
    3: ("arithmetic", "arithmetic"),
    4: ("ports", "I/O ports"),
    5: ("programs", "program operation"),
    6: ("data", "data handling"),
    7: ("utility", "utility mode"),
    8: ("realtime", "real time output"),
}

#: A condition: the name of a field, with the lowest and highest value for which a pin is used.
When = tuple[str, int, int]


@dataclass(frozen=True)
class Member:
    """A member of an enumeration. `value` is its value in the telegram."""

    name: str
    value: int
    meaning: str


@dataclass(frozen=True)
class Enumeration:
    """An enumerated type in spec/blocks.toml."""

    name: str
    does: str
    section: str
    members: tuple[Member, ...]


@dataclass(frozen=True)
class Array:
    """An array type, `ARRAY [1..count] OF of`."""

    name: str
    of: str
    count: int
    does: str
    section: str


@dataclass(frozen=True)
class Input:
    """An input pin. The head of spec/blocks.toml explains the keys."""

    pin: str
    type: str
    comment: str
    to: tuple[str, ...] = ()
    default: str = ""
    flag: str = ""
    scale: float = 0
    scale_by: Mapping[int, float] = field(default_factory=dict)
    when: When | None = None
    signed: bool = False
    range: tuple[int, int] | None = None
    encoding: str = ""
    error: str = ""


@dataclass(frozen=True)
class Output:
    """An output pin. The head of spec/blocks.toml explains the keys."""

    pin: str
    type: str
    comment: str
    source: str
    scale: float = 0
    when: When | None = None
    encoding: str = ""


@dataclass(frozen=True)
class Block:
    """A command block.

    If the block has several commands, member k of the type of pin `select` chooses command k.
    `zero` has fields of the request that stay 0, because another block of the same command uses
    them. `only` has the values of a field that the block sends. `echo` has fields of the response
    that are not shown, because they repeat the request.
    """

    name: str
    does: str
    commands: tuple[Command, ...]
    about: str = ""
    done: str = ""
    timeout: str = ""
    select: Input | None = None
    inputs: tuple[Input, ...] = ()
    outputs: tuple[Output, ...] = ()
    zero: tuple[str, ...] = ()
    only: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    echo: tuple[str, ...] = ()
    handwritten: bool = False

    @property
    def file(self) -> str:
        """Return the path of the block in the repository.

        The folder belongs to the category of the block.
        """
        folder, _ = CATEGORIES[self.commands[0].category]
        return f"plc/lib/command/{folder}/{self.name}.st"

    @property
    def requests(self) -> Mapping[str, Field]:
        """Return the fields of the request by name, limited to the values that the block sends.

        All commands of a block have the same fields.
        """
        every = {part.name: part for part in self.commands[0].request}
        for name, sent in self.only.items():
            every[name] = replace(every[name], values={k: every[name].values[k] for k in sent})
        return every

    @property
    def responses(self) -> Mapping[str, Field]:
        """Return the fields of the response by name."""
        return {part.name: part for part in self.commands[0].response}


@dataclass(frozen=True)
class Library:
    """All blocks and types of the tables by name."""

    enumerations: Mapping[str, Enumeration]
    arrays: Mapping[str, Array]
    blocks: Mapping[str, Block]


@lru_cache(maxsize=1)
def library() -> Library:
    """Read the tables, check them, and return them.

    Raises:
        InputError: a name is unknown, or no pin fills a field.
    """
    path = spec.folder() / "blocks.toml"
    tables = load_toml(path)
    shared = {entry["pin"]: entry for entry in tables["pin"]}
    blocks = {}
    for entry in tables["block"]:
        try:
            blocks[entry["name"]] = _block(shared, **entry)
        except (InputError, KeyError, TypeError) as error:
            raise InputError(f"{entry.get('name')}: {error}", file=path) from error
    return Library(
        enumerations={one["name"]: _enumeration(**one) for one in tables["enumeration"]},
        arrays={one["name"]: Array(**one) for one in tables["array"]},
        blocks=blocks,
    )


def _enumeration(members: list[list[Any]], **entry: Any) -> Enumeration:
    return Enumeration(**entry, members=tuple(Member(*member) for member in members))


def _block(shared: Mapping[str, dict[str, Any]], **entry: Any) -> Block:
    entry["commands"] = tuple(spec.command(name) for name in entry["commands"])
    entry["zero"], entry["echo"] = tuple(entry.get("zero", ())), tuple(entry.get("echo", ()))
    entry["only"] = {name: tuple(sent) for name, sent in entry.get("only", {}).items()}
    if "select" in entry:
        entry["select"] = _input(**entry["select"])
    entry["inputs"] = tuple(_input(**_pin(shared, one)) for one in entry.get("inputs", ()))
    entry["outputs"] = tuple(_output(**_pin(shared, one)) for one in entry.get("outputs", ()))
    block = Block(**entry)
    if not block.handwritten:
        _check(block)
    return block


def _pin(shared: Mapping[str, dict[str, Any]], entry: str | dict[str, Any]) -> dict[str, Any]:
    if isinstance(entry, dict):
        return dict(entry)
    if entry not in shared:
        hint = did_you_mean(get_close_matches(entry, shared))
        raise InputError(f"there is no pin {entry!r}", hint=hint)
    return dict(shared[entry])


def _input(**entry: Any) -> Input:
    to = entry.pop("to", ())
    by = dict(entry.pop("scale_by", {}))
    by.pop("field", None)
    when = _when(entry.pop("when", None))
    if "range" in entry:
        entry["range"] = tuple(entry["range"])
    return Input(
        to=(to,) if isinstance(to, str) else tuple(to),
        scale_by={int(value): scale for value, scale in by.items()},
        when=when,
        **entry,
    )


def _output(**entry: Any) -> Output:
    source, when = entry.pop("from"), _when(entry.pop("when", None))
    return Output(source=source, when=when, **entry)


def _when(entry: list[Any] | None) -> When | None:
    if entry is None:
        return None
    name, value = entry
    low, high = value if isinstance(value, list) else (value, value)
    return (name, low, high)


def _check(block: Block) -> None:
    """Check that fields and pins match, and that the commands differ only in their codes."""
    first = block.commands[0]
    for command in block.commands:
        same = (command.request, command.response, command.robot, command.product)
        if same != (first.request, first.response, first.robot, first.product):
            raise InputError(f"the fields of {command.name} and {first.name} differ")
    if (len(block.commands) > 1) != (block.select is not None):
        raise InputError("several commands need `select`; a single command must not have it")
    fields = {part.name: part for part in first.request}
    for name, sent in block.only.items():
        known = sorted(fields[name].values) if name in fields else []
        if not sent or not set(sent) <= set(known):
            raise InputError(f"`only`: {list(sent)} are not values of {name}, which has {known}")
    free = {name for name, part in block.requests.items() if part.fixed is not None}
    filled = {name for pin in block.inputs for name in (*pin.to, pin.flag) if name}
    shown = {one.source for one in block.outputs}
    unknown = (filled - set(block.requests)) | (shown - set(block.responses))
    if unknown:
        raise InputError(f"there is no field {', '.join(sorted(unknown))}")
    not_asked = set(block.echo) - (filled & set(block.responses))
    if not_asked:
        raise InputError(f"`echo`: no pin requests {', '.join(sorted(not_asked))}")
    missing = set(block.requests) - filled - free - set(block.zero)
    missing |= set(block.responses) - shown - set(block.echo) - _NOT_SHOWN
    if missing:
        raise InputError(f"no pin for {', '.join(sorted(missing))}")


#: Fields without a meaning: bit 0 of m+6 in the response to 0x506 (guide 4.7.4).
_NOT_SHOWN = {"flag_bit0"}
