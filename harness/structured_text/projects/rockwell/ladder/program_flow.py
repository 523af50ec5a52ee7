"""Instructions of program control. Source: Rockwell 1756-RM003, program control instructions.

A jump becomes a variable: forward it guards the rungs up to the label, backward it repeats them.
"""

from __future__ import annotations

from structured_text.projects.rockwell.data import First
from structured_text.projects.rockwell.ladder.call import Body, Call, Entry, Jump
from structured_text.projects.rockwell.ladder.power import FALSE
from structured_text.projects.rockwell.subroutines import jump_of, received_by, returned_by

__all__ = ["END_OF_ROUTINE", "PROGRAM_FLOW"]

#: The label behind the last rung.
END_OF_ROUTINE = "(end)"


def _nothing(call: Call) -> None:
    """Do nothing."""
    del call


def _afi(call: Call) -> None:
    call.condition(FALSE)


def _jmp(call: Call) -> None:
    label = call.raw(0).upper()
    if label not in call.body.labels:
        raise call.error(f"there is no label {call.raw(0)}", "add it, or remove the jump")
    _jump(call, label)


def _jump(call: Call, label: str) -> None:
    body: Body = call.body
    target = body.labels[label]
    back = target <= body.rung
    plain = "End" if label == END_OF_ROUTINE else call.raw(0)
    variable = body.variable(f"{'Again' if back else 'Skip'}_{plain.strip('_')}")
    body.jumps.append(Jump(body.rung, target, variable))
    call.when(f"{variable} := TRUE;", leaves=variable)


def _leave(call: Call) -> None:
    if call.body.may_return:
        call.when("RETURN;")
    else:
        _jump(call, END_OF_ROUTINE)


def _ret(call: Call) -> None:
    returned = returned_by(call.instruction.operands, call.instruction.at, call.body.routine)
    if returned:
        call.when(*returned)
    _leave(call)


def _sbr(call: Call) -> None:
    received = received_by(call.instruction.operands, call.instruction.at, call.body.routine)
    if received:
        call.when(*received)


def _jsr(call: Call) -> None:
    jump = jump_of(call.instruction.operands, call.instruction.at, call.body.routine)
    call.when(jump, anything=True)
    call.body.first.append(First(routine=call.raw(0).upper()))


def _mcr(call: Call) -> None:
    """Begin or end a zone: without power at its begin, its rungs have no power."""
    body = call.body
    if body.zone:
        body.zone = ""
        return
    zone = body.variable("Zone")
    call.always(lambda power: [f"{zone} := {power};"])
    body.zone = zone


PROGRAM_FLOW = (
    Entry("AFI", (), _afi, "1756-RM003, AFI"),
    Entry("NOP", (), _nothing, "1756-RM003, NOP"),
    Entry("LBL", ("Label",), _nothing, "1756-RM003, JMP and LBL"),
    Entry("JMP", ("Label",), _jmp, "1756-RM003, JMP and LBL"),
    Entry("JSR", ("Routine Name", "Number of Inputs"), _jsr, "1756-RM003, JSR", optional=-1),
    Entry("SBR", (), _sbr, "1756-RM003, JSR, SBR, RET", optional=-1),
    Entry("RET", (), _ret, "1756-RM003, JSR, SBR, RET", optional=-1),
    Entry("TND", (), _leave, "1756-RM003, TND"),
    Entry("MCR", (), _mcr, "1756-RM003, MCR"),
)
