"""Instructions for what is outside of the program: GSV and SSV, messages, and motion.

Those that `system` does not describe are refused by name.
"""

from __future__ import annotations

from structured_text.projects.rockwell.ladder.call import Call, Entry
from structured_text.projects.rockwell.system import SYSTEM_HINT, is_known_class, note_of

__all__ = ["OTHERS"]


def _system(call: Call) -> None:
    name = call.entry.name
    if not is_known_class(call.raw(0)):
        raise call.error(f"{name} of {call.raw(0)} is not supported", SYSTEM_HINT)
    call.tag(3, written=name == "GSV", element=False)
    operands = [call.raw(number) for number in range(4)]
    call.body.notes.append((call.instruction.at, note_of(name, *operands)))


def _event(call: Call) -> None:
    call.body.notes.append((call.instruction.at, note_of("EVENT", call.raw(0))))


def _nothing(call: Call) -> None:
    """Do nothing."""
    del call


def _refused(call: Call) -> None:
    raise call.error(f"{call.entry.name} is not supported", SYSTEM_HINT)


#: Instructions that are refused by name: motion, communication, process control, and phases.
_REFUSED = """
MAAT MAFR MAG MAH MAHD MAJ MAM MAOC MAPC MAR MAS MASD MASR MATC MAW MCCD MCCM MCCP MCD MCLM MCS
MCSD MCSR MCSV MCT MDAC MDCC MDF MDO MDOC MDR MDS MDW MGS MGSD MGSP MGSR MRAT MRHD MRP MSF MSO
MSG ABL ACB ACL AHL ARD ARL AWA AWT
PID ALMA ALMD IOT SRT STD AVE SFP SFR DDT FBC DTR
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
