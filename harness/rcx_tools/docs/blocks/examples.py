"""The examples of the block pages: entries of snippets.toml, and the programs made from them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from rcx_tools.docs.blocks.source import ROOT, Pin, Pou, kinds, pous
from rcx_tools.library import library
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml

__all__ = [
    "FOLDER",
    "ROBOT",
    "START_US",
    "Snippet",
    "Step",
    "own_pins",
    "program",
    "shows_all",
    "snippets",
    "stimulus",
]
__all__ += ["without"]

FOLDER = ROOT / "docs/reference/blocks"
_FILE = FOLDER / "snippets.toml"

#: Name of the robot file of most examples, in programs/.
ROBOT = "robot.toml"
#: Time at which `Start` becomes TRUE. At this time the controller runs, and SI(00) and SI(06) are
#: ON.
START_US = 600_000

_WIDTH = 100


@dataclass(frozen=True)
class Step:
    """A block in the program of an example.

    Attributes:
        instance: Name of the instance.
        block: The type of the instance.
        inputs: Values of the inputs in ST. A list fills an array, a table fills a structure.
        end: The output of the block that starts the next block.
        after: Whether the block is called after FB_WriteArea.
    """

    instance: str
    block: str
    inputs: Mapping[str, Any]
    end: str = "Done"
    after: bool = False


@dataclass(frozen=True)
class Snippet:
    """One example.

    Attributes:
        pou: The block that the example shows.
        call: The call of the block. None if the example is only the frame of the program.
        before: Blocks that run before the block. The end of each block starts the next block.
        about: A sentence for the page.
        events: Events in addition to the start, as tables of a stimulus file.
        stop: Time at which `Start` becomes FALSE again, as text. Empty if it stays TRUE.
        size: Size of the areas [byte].
        frame: Inputs of FB_ReadArea and FB_WriteArea that differ from the defaults.
        show: Additional lanes of the chart: `SI06`, `n+34.0 SI(20)`, `m+4 SOW(2)`,
            `Main.Connected`.
        lanes: All lanes of the chart, as in plc/examples/charts.toml. With `lanes` the chart has a
            linear time axis. Without `lanes` it shows the pins and signals that change, with one
            column for each change.
        buttons: Push buttons in addition to Start. The events set these buttons.
        last: Whether outputs are read at the end of the run, and not at the end of the block.
        robot: Name of the robot file in programs/.
    """

    pou: Pou
    call: Step | None
    before: tuple[Step, ...]
    about: str = ""
    events: tuple[Mapping[str, Any], ...] = ()
    stop: str = ""
    size: int = 48
    frame: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    show: tuple[str, ...] = ()
    lanes: tuple[str, ...] = ()
    buttons: tuple[str, ...] = ()
    last: bool = False
    robot: str = ROBOT

    @property
    def steps(self) -> list[Step]:
        """Return all blocks that the example adds to the frame, in the order of their calls."""
        return [*self.before, *([self.call] if self.call else [])]

    @property
    def started(self) -> bool:
        """Return whether the program has the variable `Start`.

        Examples with the common stimulus always have it. Other examples have it only if they use
        it.
        """
        pins = self.call.inputs.values() if self.call else ()
        return (
            not self.events
            or self.call is None
            or bool(self.before)
            or any(self.pou.pin(name) for name in ("Execute", "Enable"))
            or "Start" in [*pins, *(one for given in self.frame.values() for one in given.values())]
        )

    @property
    def path(self) -> Path:
        """Return the path of the example's program."""
        return FOLDER / "programs" / f"{self.pou.name}.st"

    @property
    def stimulus_path(self) -> Path:
        """Return the path of the stimulus: the example's own file, or the common file."""
        own = self.events or self.stop
        return FOLDER / "programs" / f"{self.pou.name if own else 'start'}.toml"

    @property
    def words(self) -> bool:
        """Return whether the process image consists of words."""
        return any(pin.type == "RCX_IMAGE_WORDS" for pin in self.pou.pins)

    def command(self, seconds: str) -> str:
        """Return the command with which a user runs the example."""
        place = "docs/reference/blocks/programs"
        size = f" --size {self.size}" if self.size != 48 else ""
        return (
            f"rcx run {place}/{self.path.name} --robot {place}/{self.robot}{size} \\\n"
            f"  --stimulus {place}/{self.stimulus_path.name} --for {seconds}"
        )


@cache
def snippets(file: Path = _FILE) -> dict[str, Snippet]:
    """Return the examples of a file by block.

    A generated command block has an example even if the file does not contain the block, because
    the default values are sufficient. Every other block needs an entry.

    Raises:
        InputError: an entry is wrong.
    """
    table = load_toml(file)
    named: dict[str, dict[str, Any]] = {}
    for entry in table["block"]:
        for name in entry.pop("names", None) or [entry.pop("name", "")]:
            if name not in pous():
                raise InputError(f"there is no block {name!r}", file=file)
            named[name] = entry
    found = {}
    for name, pou in pous().items():
        entry = library().blocks.get(name)
        generic = entry is not None and not entry.handwritten
        if name in named or (generic and not pou.internal):
            try:
                found[name] = _snippet(pou, table["before"], **named.get(name, {}))
            except (KeyError, TypeError) as error:
                raise InputError(f"{name}: {error}", file=file) from None
    return found


def without() -> dict[str, str]:
    """Return the blocks that need no example, each with the reason."""
    reasons: dict[str, str] = load_toml(_FILE).get("without", {})
    return reasons


def _snippet(
    pou: Pou,
    steps: Mapping[str, Mapping[str, Any]],
    *,
    inputs: Mapping[str, Any] | None = None,
    before: Sequence[str] = (),
    events: Sequence[Mapping[str, Any]] = (),
    show: Sequence[str] = (),
    lanes: Sequence[str] = (),
    buttons: Sequence[str] = (),
    after: bool = False,
    instance: str = "",
    **rest: Any,
) -> Snippet:
    name = instance or pou.name.removeprefix("FB_")
    areas = ("ReadArea", "WriteArea", "ReadAreaWords", "WriteAreaWords")
    call = None if name in areas else Step(name, pou.name, inputs or {}, after=after)
    first = tuple(Step(**{"inputs": {}, **steps[one]}) for one in before)
    return Snippet(
        pou,
        call,
        first,
        events=tuple(events),
        show=tuple(show),
        lanes=tuple(lanes),
        buttons=tuple(buttons),
        **rest,
    )


def shows_all(snippet: Snippet) -> bool:
    """Return whether the page of a block shows the whole program.

    Otherwise it leaves out the calls of FB_ReadArea and FB_WriteArea.
    """
    return not snippet.steps or any(step.after for step in snippet.steps)


def program(snippet: Snippet) -> str:
    """Return the program of an example as ST text."""
    name = snippet.pou.name.removeprefix("FB_")
    steps = snippet.steps
    head = [
        "(*",
        f" * Example of {snippet.pou.name}, shown and run on its page docs/reference/blocks.",
        " *",
        " * Generated from docs/reference/blocks/snippets.toml by `make docs`.",
        " *)",
        f"PROGRAM {name}Example",
    ]
    body = list(_body(snippet, steps))
    lines = [f"  {one}".rstrip() for one in body]
    return "\n".join([*head, *_variables(snippet, steps), "", *lines, "END_PROGRAM", ""])


def stimulus(snippet: Snippet) -> str:
    """Return the text of the example's own stimulus file, or of the common stimulus file.

    The stimulus sets CellSafe at time 0. The programs do not set CellSafe, because users copy them.
    """
    at: list[dict[str, Any]] = []
    if snippet.started:
        at.append({"time": f"{START_US // 1000}ms", "set": {"Main.Start": True}})
    if snippet.stop and snippet.started:
        at.append({"time": snippet.stop, "set": {"Main.Start": False}})
    lines = ["# Generated from docs/reference/blocks/snippets.toml by `make docs`."]
    safe = {"time": "0ms", "set": {"Main.CellSafe": True}}
    for entry in [safe, *snippet.events, *at]:
        lines += ["", "[[at]]", *(f"{key} = {_toml(value)}" for key, value in entry.items())]
    return "\n".join([*lines, ""])


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else str(value)


def _key(key: str) -> str:
    return key if re.fullmatch(r"\w+", key) else f'"{key}"'


def _body(snippet: Snippet, steps: Sequence[Step]) -> Iterator[str]:
    kind = "Words" if snippet.words else ""
    size = {"Size": snippet.size} if snippet.size != 48 else {}
    read = {"Robot": "Robot", "Image": "InputArea", **size, "Connected": "Connected"}
    write = {"Robot": "Robot", "Image": "OutputArea", **size, "Margin": "T#20ms"}
    write |= {"EmergencyStopOk": "CellSafe", "StopOk": "CellSafe"}
    yield from _call(f"ReadArea{kind}", read | dict(snippet.frame.get("read", {})))
    yield ""
    start = "Start"
    between = [step for step in steps if not step.after]
    for step in between:
        yield from _step(step, start)
        start = f"{step.instance}.{step.end}"
    if between:
        yield ""
    yield from _call(f"WriteArea{kind}", write | dict(snippet.frame.get("write", {})))
    if len(between) < len(steps):
        yield ""
    for step in steps[len(between) :]:
        yield from _step(step, start)


def _step(step: Step, start: str) -> Iterator[str]:
    pou = pous()[step.block]
    given: dict[str, Any] = {}
    for pin in pou.pins:
        if pin.section == "VAR_OUTPUT":
            continue
        if pin.name == "Image":
            given[pin.name] = "InputArea" if pou.pin("m") else "OutputArea"
        elif pin.section == "VAR_IN_OUT" and pin.name not in step.inputs:
            given[pin.name] = pin.name
        elif pin.name in ("Execute", "Enable"):
            given[pin.name] = step.inputs.get(pin.name, start)
        elif pin.name in step.inputs:
            given[pin.name] = step.inputs[pin.name]
    unknown = step.inputs.keys() - given.keys()
    if unknown:
        raise InputError(f"{step.block} has no input {', '.join(sorted(unknown))}", file=_FILE)
    types = {pin.name: pin.type for pin in pou.pins}
    for name, value in given.items():
        if isinstance(value, (list, Mapping)):
            yield from _filled(name, value, types[name])
            given[name] = name
    texts = {name: _literal(value, types[name]) for name, value in given.items()}
    yield from _call(step.instance, texts)


def _filled(name: str, value: Any, kind: str) -> Iterator[str]:
    """Yield assignments that give a variable its value. Zero values need no assignment."""
    if isinstance(value, list):
        for k, one in enumerate(value, 1):
            yield from _filled(f"{name}[{k}]", one, kinds()[kind].element)
    elif isinstance(value, Mapping):
        for field, one in value.items():
            yield from _filled(f"{name}.{field}", one, kinds()[kind].fields[field])
    elif value not in (0, "WORD#16#0000"):
        yield f"{name} := {_literal(value, kind)};"


def _literal(value: Any, kind: str) -> str:
    if isinstance(value, bool):
        return str(value).upper()
    if kind == "REAL" and isinstance(value, (int, float)):
        return str(float(value))
    return str(value)


def _call(instance: str, inputs: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a call with named arguments, wrapped to the line width."""
    line = f"{instance}("
    indent = " " * len(line)
    parts = [f"{name} := {value}" for name, value in inputs.items()]
    for k, part in enumerate(parts):
        end = "," if k + 1 < len(parts) else ");"
        if len(line) + len(part) + len(end) + 3 > _WIDTH:
            yield line.rstrip()
            line = indent
        line += f"{part}{end} "
    yield line.rstrip()


def own_pins(block: str) -> list[Pin]:
    """Return the in-out pins except robot and image; each needs a variable of the program."""
    pins = pous()[block].of("VAR_IN_OUT")
    return [pin for pin in pins if pin.name not in ("Robot", "Image")]


def _variables(snippet: Snippet, steps: Sequence[Step]) -> Iterator[str]:
    words = "_WORDS" if snippet.words else ""
    kind = "Words" if snippet.words else ""
    buttons = [*(["Start"] if snippet.started else []), *snippet.buttons]
    rows = [
        ("InputArea", f"RCX_IMAGE{words}", "robot to PLC, filled by your scanner"),
        ("OutputArea", f"RCX_IMAGE{words}", "PLC to robot, sent by your scanner"),
        ("Connected", "BOOL", "your scanner's status"),
        ("CellSafe", "BOOL", "status of your safety circuit: must be wired"),
        *((name, "BOOL", "push button") for name in buttons),
        ("Robot", "RCX_REF", ""),
        (f"ReadArea{kind}", f"FB_ReadArea{kind}", ""),
        (f"WriteArea{kind}", f"FB_WriteArea{kind}", ""),
    ]
    for step in steps:
        rows.append((step.instance, step.block, ""))
        filled = {name for name, one in step.inputs.items() if isinstance(one, (list, Mapping))}
        own = [pin.name for pin in own_pins(step.block) if pin.name not in step.inputs]
        for pin in pous()[step.block].pins:
            known = any(pin.name == name for name, _, _ in rows)
            if not known and pin.name in (*own, *filled):
                rows.append((pin.name, pin.type, ""))
    width = max(len(name) for name, _, _ in rows)
    column = max(len(kind) for _, kind, said in rows if said) + 2
    yield "  VAR"
    for name, kind, said in rows:
        text = f"    {name:<{width}} : {kind + ';':<{column}} "
        yield f"{text}(* {said} *)" if said else text.rstrip()
    yield "  END_VAR"
