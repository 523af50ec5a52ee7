"""For users who test their own PLC project with pytest: plugin, settings, evidence of failures.

What a project can set stands here, since pytest loads the plugin in every run: nothing of the
harness may come with it.
"""

from __future__ import annotations

from typing import Any

__all__ = ["LISTS", "OPTIONS", "VALUES"]

#: Options of the command line, by the name of the ini key: default is None for each.
OPTIONS: dict[str, dict[str, Any]] = {
    "engine": {
        "choices": ("auto", "matiec", "builtin", "strucpp"),
        "help": "engine of the PLC program",
    },
    "link": {"choices": ("direct", "enip"), "help": "network; enip: real EtherNet/IP packets"},
    "seed": {"type": int, "metavar": "N", "help": "seed of all that is drawn"},
    "scan": {"metavar": "TIME", "help": "period of the PLC, as 10ms"},
    "robot": {
        "action": "append",
        "metavar": "FILE",
        "help": "properties of the robot (TOML); once for each robot",
    },
    "watch": {
        "action": "append",
        "metavar": "PATHS",
        "help": "variables that charts and traces show, as Main.Step,Main.Hmi.*",
    },
    "artifacts": {"metavar": "DIR", "help": "folder for charts and traces of failed tests"},
}

#: Keys of the ini file that are lists; all others are one value.
LISTS = {
    "sources": "ST files of the program: names, patterns or folders, one per line",
    "replace": "ST files for POUs of a project, POU=file.st, one per line",
}

#: The other keys of the ini file.
VALUES = {
    "lib": "folder of the library; default: that of rcx-harness",
    "size": "bytes of the areas, 48 or 256; default: the robot's",
    "m": "where in the inputs the area begins; of several robots: 0 48",
    "n": "where in the outputs the area begins",
    "rpi": "packet interval",
    "jitter": "greatest delay of a packet",
    "positions": "charts and traces show where the robot is: in pulses, or mm",
    "on_loss": "the PLC's inputs without a link: hold or clear",
}
