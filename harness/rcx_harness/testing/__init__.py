"""The pytest plugin for users who test their own PLC project: settings, cells, evidence.

This module lists the settings. pytest loads the module in every run, so it must not import other
modules of the harness.
"""

from __future__ import annotations

from typing import Any

__all__ = ["LISTS", "OPTIONS", "VALUES"]

#: Maps an ini key to its option of the command line. The default of each option is None.
OPTIONS: dict[str, dict[str, Any]] = {
    "engine": {
        "choices": ("auto", "matiec", "builtin", "strucpp"),
        "help": "engine of the PLC program",
    },
    "dialect": {
        "metavar": "NAME",
        "help": "the PLC tool whose behaviour the program gets, such as codesys or tia",
    },
    "device": {
        "metavar": "NAME",
        "help": "the device to read, if a project in PLCopen XML has several",
    },
    "link": {"choices": ("direct", "enip"), "help": "network; enip: real EtherNet/IP packets"},
    "seed": {"type": int, "metavar": "N", "help": "seed of all random values"},
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

#: Keys of the ini file with a list as value. All other keys have one value.
LISTS = {
    "sources": "ST files of the program: names, patterns or folders, one per line",
    "replace": "ST files for POUs of a project, POU=file.st, one per line",
}

#: Keys of the ini file that have one value, with their help texts.
VALUES = {
    "lib": "folder of the library; default: that of rcx-harness",
    "size": "bytes of the areas, 48 or 256; default: the robot's",
    "m": "where in the inputs the area begins; of several robots: 0 48",
    "n": "offset of the area in the outputs",
    "rpi": "packet interval",
    "jitter": "greatest delay of a packet",
    "positions": "charts and traces show the position of the robot in pulses or mm",
    "on_loss": "the PLC's inputs without a link: hold or clear",
}
