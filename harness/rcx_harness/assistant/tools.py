"""The tools of the server: their descriptions, their parameters and their results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from rcx_harness.assistant.call import Answer, Call
from rcx_harness.assistant.limits import MOST_SEEDS, MOST_VIRTUAL
from rcx_harness.assistant.schema import (
    FOLDER,
    array,
    choice,
    duration,
    integer,
    paths,
    record,
    text,
)
from structured_text.export.refused import tools as plc_tools

__all__ = ["TOOLS", "Tool"]

Schema = dict[str, Any]
_STIMULUS = 1 << 20
_BOOL = {"type": "boolean", "default": False}


@dataclass(frozen=True)
class Tool:
    """A tool of the server.

    Attributes:
        title: Its name for people.
        about: What it does, when to use it, and what it writes.
        given: JSON Schema of its parameters.
        answer: JSON Schema of its result.
        home: Module of this folder with the function of the tool's name.
        writes: Whether it writes files.
        of_library: Whether it shows the library only, so that it needs no process of its own.
    """

    name: str
    title: str
    about: str
    given: Schema
    answer: Schema
    home: str
    writes: bool = False
    of_library: bool = False

    def run(self, call: Call) -> Answer:
        """Answer a call. The module of the tool is imported on first use."""
        function: Callable[[Call], Answer] = getattr(
            import_module(f"rcx_harness.assistant.{self.home}"), self.name
        )
        return function(call)


_FILES = paths("ST files, projects (PLCopen XML, TwinCAT, L5X, SCL) or folders of the program.", 1)
_ROBOT = paths("Robot files (TOML), one for each controller. Default: a robot without settings.")
_PROPERTIES = paths("Files with operator actions and required properties: .toml or .py.")
_DIALECT = text("PLC tool whose behaviour the program gets, such as codesys or tia.", 40)
_SCAN = duration("Period of the PLC, such as 10ms. Default: the interval of its task, or 10ms.")
_CODE = integer("Exit code of the command: 0 good, 1 something was found, 2 errors.", 0, 3)
_COUNT = {"type": "integer", "minimum": 0}
_WORD, _WORDS = {"type": "string"}, {"type": "array", "items": {"type": "string"}}

_FINDING = record(
    {
        "level": choice("How serious it is.", ["error", "rule", "warning"]),
        "rule": _WORD,
        "text": _WORD,
        "file": _WORD,
        "line": _COUNT,
        "column": _COUNT,
        "hint": _WORD,
    }
)
_CHECK = Tool(
    "check",
    "Check a program",
    "Check Structured Text: syntax, types, portability, the call order of the robot's blocks and "
    "common first mistakes. Robot programs (.PGM, .ALL) are checked as well. With `for` it also "
    "lists what this PLC tool refuses. Nothing is written. Call it after each change of a source.",
    record(
        {"files": _FILES},
        {
            "for": choice("PLC tool that must accept the program.", sorted(plc_tools())),
            "dialect": _DIALECT,
            "folder": FOLDER,
        },
    ),
    record({"exit_code": _CODE, "findings": array("The findings.", _FINDING), "summary": _WORD}),
    "checking",
)

_VIOLATION = record({"t_us": _COUNT, "rule": _WORD, "text": _WORD})
_RUN = Tool(
    "run",
    "Run a program against the virtual robot",
    "Run a program with a virtual robot controller in virtual time on the built-in engine, and "
    "report broken rules, the last values of watched variables, the signals that are ON at the "
    "end, and the path of the trace for explain_trace. The same call gives the same run. Inputs "
    "come from `stimulus`; without it the inputs keep their initial values, and the robot usually "
    "stays in emergency stop.",
    record(
        {"files": _FILES},
        {
            "stimulus": text(
                'Inputs and events over time as TOML: [[at]] with time = "100ms" and set = '
                '{ "Main.Start" = true }, event = "..." or expect = "...".',
                _STIMULUS,
            ),
            "robot": _ROBOT,
            "properties": _PROPERTIES,
            "duration": duration(f"Virtual time to run, at most {MOST_VIRTUAL}.", "5s"),
            "scan": _SCAN,
            "seed": integer("Seed of the random numbers.", 0, 2**63 - 1, 0),
            "watch": {
                **array("Variables to record, such as Main.Step or Main.Hmi.*"),
                "maxItems": 100,
            },
            "size": {"type": "integer", "enum": [48, 256], "description": "Bytes of the areas."},
            "rpi": duration("Packet interval.", "10ms"),
            "jitter": duration("Longest delay of a packet.", "0ms"),
            "no_robot": {**_BOOL, "description": "Run the program alone, without a robot."},
            "dialect": _DIALECT,
            "folder": FOLDER,
        },
    ),
    record(
        {
            "exit_code": _CODE,
            "end_us": _COUNT,
            "engine": _WORD,
            "violation_count": _COUNT,
            "violations": array("The first broken rules, in order of time.", _VIOLATION),
            "watched": {"type": "object", "additionalProperties": _WORD},
            "signals_on": _WORDS,
            "report": _WORDS,
            "trace": _WORD,
            "replay": _WORD,
        }
    ),
    "running",
    writes=True,
)

_STATE = record(
    {
        "signals_on": _WORDS,
        "tasks": _WORDS,
        "watched": {"type": "object", "additionalProperties": _WORD},
    }
)
_EXPLAIN = Tool(
    "explain_trace",
    "Explain a recording",
    "Explain a trace of `run`, of rcx serve or rcx scan: signals, remote commands with their "
    "answers and alarms in plain language, changes of watched variables, states of robot "
    "programs and broken rules. With `at` only the events around this time are listed, and the "
    "state at this time. `missing_signals` names signals that were needed and never ON.",
    record(
        {"trace": text("The trace (jsonl), relative to the folder.")},
        {
            "at": duration("Time of interest, such as 1.25s. Default: the whole recording."),
            "window": duration("Time before and after `at`.", "1s"),
            "folder": FOLDER,
        },
    ),
    record(
        {
            "controllers": {"type": "array", "items": _COUNT},
            "end_us": _COUNT,
            "events": array("The events.", record({"t_us": _COUNT, "text": _WORD})),
            "events_left_out": _COUNT,
            "missing_signals": _WORDS,
            "state": _STATE,
            "state_at_us": _COUNT,
            "trace": _WORD,
            "violation_count": _COUNT,
        }
    ),
    "explaining",
)

_PROPERTY = record(
    {
        "name": _WORD,
        "says": _WORD,
        "at": _WORD,
        "status": choice("The result.", ["proved", "refuted", "unknown", "noted"]),
        "assumes": _WORDS,
        "note": _WORD,
        "replay": _WORD,
        "command": _WORD,
    }
)
_PROVE = Tool(
    "prove",
    "Prove properties of a program",
    "Prove for every run, every answer of the robot and every input: no statement stops the PLC "
    "(division by zero, index outside of an array), the blocks of the library are called once and "
    "while they are busy, and your assertions hold; an assertion is a comment such as (* prove: "
    "Count <= 20 *). A refuted property has a replay: a stimulus file and its command. Unknown is "
    "not proved.",
    record(
        {"files": _FILES},
        {
            "properties": array(
                "Only properties whose name, sentence or place contains one of these texts."
            ),
            "limit": duration("Time for each property.", "20s"),
            "scan": duration("Period of the PLC in the runs that break a property.", "10ms"),
            "overflow": {**_BOOL, "description": "Also require that arithmetic keeps its type."},
            "no_robot": {**_BOOL, "description": "Prove the program alone, without a robot."},
            "dialect": _DIALECT,
            "folder": FOLDER,
        },
    ),
    record(
        {
            "exit_code": _CODE,
            "inputs": _WORDS,
            "properties": array("The properties.", _PROPERTY),
            "summary": _WORD,
        }
    ),
    "checking",
    writes=True,
)

_FAILURE = record(
    {
        "kind": _WORD,
        "says": _WORD,
        "seeds": {"type": "array", "items": _COUNT},
        "causes": _WORDS,
        "replay": _WORD,
        "chart": _WORD,
        "command": _WORD,
        "fails_again": {"type": "boolean"},
    }
)
_CAMPAIGN = Tool(
    "campaign",
    "Run a cell with random faults",
    "Run a cell many times with random faults of network, robot, PLC and operator, and report "
    "which rules and properties break. Each class of failures has the shortest run as a replay: "
    "a stimulus file with its chart. Start with few seeds, since each takes a second or more.",
    record(
        {"files": _FILES},
        {
            "robot": _ROBOT,
            "properties": _PROPERTIES,
            "stimulus": text("Stimulus file of a good run (TOML), to which faults are added."),
            "seeds": integer("Number of random runs.", 1, MOST_SEEDS, 20),
            "seed_from": integer("The first seed.", 0, 2**63 - 1, 0),
            "duration": duration(f"Longest virtual time of a run, at most {MOST_VIRTUAL}."),
            "scan": _SCAN,
            "folder": FOLDER,
        },
    ),
    record(
        {
            "exit_code": _CODE,
            "seeds": record({"first": _COUNT, "count": _COUNT}),
            "events": _COUNT,
            "scans": _COUNT,
            "virtual_us": _COUNT,
            "failures": array("The classes of failures.", _FAILURE),
            "notice": _WORD,
        }
    ),
    "searching",
    writes=True,
)

_SURVIVOR = record(
    {"file": _WORD, "line": _COUNT, "operator": _WORD, "before": _WORD, "after": _WORD}
)
_MUTANTS = Tool(
    "mutants",
    "Check the tests of a program with small mistakes",
    "Put small mistakes into a program, one at a time, and report which of them its pytest tests "
    "do not find. The tests of the folder are executed: this is Python code of the project. If "
    "the time limit ends the call, the same call continues with the mutants that remain.",
    record(
        {"files": _FILES},
        {
            "tests": paths("Test files or folders for pytest. Default: as pytest finds them."),
            "folder": FOLDER,
        },
    ),
    record(
        {
            "exit_code": _CODE,
            "mutants": _COUNT,
            "killed": _COUNT,
            "not_compiling": _COUNT,
            "score": {"type": "number"},
            "survivors": array("The first surviving mutants.", _SURVIVOR),
            "survivor_count": _COUNT,
            "results": _WORD,
        }
    ),
    "searching",
    writes=True,
)

_BLOCK = record(
    {
        "name": _WORD,
        "folder": _WORD,
        "purpose": _WORD,
        "section": _WORD,
        "returns": _WORD,
        "inputs": _WORDS,
        "outputs": _WORDS,
    }
)
_LIST_BLOCKS = Tool(
    "list_blocks",
    "List the blocks of the library",
    "List the function blocks and functions of the library with their purposes and the names of "
    "their pins. Use block_page for a block's types, ranges, errors and source.",
    record(
        {},
        {
            "search": text("Only blocks whose name, folder or purpose contains this text.", 100),
            "internal": {**_BOOL, "description": "Also list parts that programs do not call."},
        },
    ),
    record({"blocks": array("The blocks.", _BLOCK)}),
    "blocks",
    of_library=True,
)

_PIN = record({"section": _WORD, "name": _WORD, "type": _WORD, "default": _WORD, "meaning": _WORD})
_BLOCK_PAGE = Tool(
    "block_page",
    "Show the page of a block",
    "Show what a block of the library does, its pins with types, defaults and meanings, its "
    "errors with remedies, and its source. The resource rcx://blocks/NAME has the same text.",
    record({"name": text("Name of the block, such as FB_ServoOn.", 100)}),
    record({"name": _WORD, "purpose": _WORD, "pins": array("The pins.", _PIN), "page": _WORD}),
    "blocks",
    of_library=True,
)

TOOLS = {
    tool.name: tool
    for tool in (
        _CHECK,
        _RUN,
        _EXPLAIN,
        _PROVE,
        _CAMPAIGN,
        _MUTANTS,
        _LIST_BLOCKS,
        _BLOCK_PAGE,
    )
}
