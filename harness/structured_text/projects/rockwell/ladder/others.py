"""Instructions for what is outside of the program: GSV and SSV, messages, and motion.

The destination of a GSV keeps its value, so that a test can set it. Other instructions of this kind
are refused by name.
"""

from __future__ import annotations

from structured_text.errors import COMMAND
from structured_text.projects.rockwell.ladder.call import Call, Entry

__all__ = ["OTHERS"]

#: Objects of the controller whose values no statement can compute.
_READ = (
    "CONTROLLER",
    "CONTROLLERDEVICE",
    "CST",
    "FAULTLOG",
    "MODULE",
    "PROGRAM",
    "TASK",
    "TIMESYNCHRONIZE",
    "WALLCLOCKTIME",
)


def _system(call: Call) -> None:
    name, kind = call.entry.name, call.raw(0).upper()
    if kind not in _READ:
        raise call.error(f"{name} of {call.raw(0)} is not supported", _hint())
    call.tag(3, written=name == "GSV", element=False)
    what = f"{call.raw(0)} {call.raw(1)}".strip() + f", {call.raw(2)}"
    effect = (
        f"does not read it, and {call.raw(3)} keeps its value; a test can set it"
        if name == "GSV"
        else "does not set it"
    )
    call.body.notes.append((call.instruction.at, f"{name} of {what} {effect}"))


def _event(call: Call) -> None:
    text = f"EVENT does not start the task {call.raw(0)}, because a task of events does not run"
    call.body.notes.append((call.instruction.at, text))


def _nothing(call: Call) -> None:
    """Do nothing."""
    del call


def _refused(call: Call) -> None:
    raise call.error(f"{call.entry.name} is not supported", _hint())


def _hint() -> str:
    return (
        f"write the routine in Structured Text with a block of your own instead: {COMMAND} "
        "--replace Program.Routine=file.st"
    )


#: Instructions that are refused by name: motion, communication, process control, and phases.
_REFUSED = """
MAAT MAFR MAG MAH MAHD MAJ MAM MAOC MAPC MAR MAS MASD MASR MATC MAW MCCD MCCM MCCP MCD MCLM MCS
MCSD MCSR MCSV MCT MDAC MDCC MDF MDO MDOC MDR MDS MDW MGS MGSD MGSP MGSR MRAT MRHD MRP MSF MSO
MSG ABL ACB ACL AHL ARD ARL AWA AWT
PID ALMA ALMD IOT SRT STD AVE SFP SFR FOR BRK DDT FBC DTR
PSC PFL PCMD PCLF PXRQ PRNP PPD PATT PDET POVR
"""
OTHERS = (
    Entry("GSV", ("Class", "Instance", "Attribute", "Dest"), _system, "1756-RM003, GSV"),
    Entry("SSV", ("Class", "Instance", "Attribute", "Source"), _system, "1756-RM003, SSV"),
    Entry("EVENT", ("Task",), _event, "1756-RM003, EVENT"),
    Entry("UID", (), _nothing, "1756-RM003, UID; tasks do not interrupt each other here"),
    Entry("UIE", (), _nothing, "1756-RM003, UIE; tasks do not interrupt each other here"),
    *(Entry(name, (), _refused, "1756-RM003, MOTION-RM002", -1) for name in _REFUSED.split()),
)
