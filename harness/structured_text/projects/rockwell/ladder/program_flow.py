"""Instructions of program control. Source: Rockwell 1756-RM003, program control instructions.

A jump becomes a variable: forward it guards the rungs up to the label, backward it repeats them.
"""

from __future__ import annotations

import re

from structured_text.projects.rockwell.data import First
from structured_text.projects.rockwell.expression_reader import bare
from structured_text.projects.rockwell.ladder.call import Body, Call, Entry, Jump
from structured_text.projects.rockwell.ladder.power import FALSE
from structured_text.projects.rockwell.subroutines import jump_of, received_by, returned_by

__all__ = ["END_OF_ROUTINE", "PROGRAM_FLOW"]

#: Matches a whole number, as `number` of an operand gives it.
_LITERAL = re.compile(r"\(?-?\d+\)?")
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


def _for(call: Call) -> None:
    """Execute a routine for each value of an index; BRK in the routine ends this."""
    body = call.body
    operands = (call.raw(0), "0")
    jump = jump_of(operands, call.instruction.at, body.routine)
    index, data = call.tag(1)
    start = call.assigned(1, call.number(2))
    step, kind = call.number(4)
    reader = call.operand(1)
    here = reader.read(index, data)
    last = call.number(3)
    more, less = (bare(reader.calculated(here, sign, last)[0]) for sign in ("<=", ">="))
    if _LITERAL.fullmatch(step):
        if not int(bare(step)):
            raise call.error("the step of FOR is 0", "write another step")
        again = more if int(bare(step)) > 0 else less
    else:
        zero = "0.0" if kind in ("REAL", "LREAL") else "0"
        again = f"({step} > {zero} AND {more} OR {step} < {zero} AND {less})"
    stopped = body.variable("Break", kept=True)
    call.when(
        f"{stopped} := FALSE;",
        start,
        f"WHILE {again} AND NOT {stopped} DO",
        f"  {jump}",
        f"  IF NOT {stopped} THEN",
        f"    {call.assigned(1, reader.calculated(here, '+', (step, kind)))}",
        "  END_IF;",
        "END_WHILE;",
        f"{stopped} := FALSE;",
        anything=True,
    )
    call.body.first.append(First(routine=call.raw(0).upper()))


def _brk(call: Call) -> None:
    call.when(f"{call.body.variable('Break', kept=True)} := TRUE;")
    _leave(call)


def _mcr(call: Call) -> None:
    """Begin or end a zone: without power at its begin, its rungs have no power."""
    body = call.body
    if body.zone:
        body.zone = ""
        return
    zone = body.variable("Zone")
    call.always(lambda power: [f"{zone} := {power};"])
    body.zone = zone


_FOR = ("Routine Name", "Index", "Initial Value", "Terminal Value", "Step Size")
PROGRAM_FLOW = (
    Entry("AFI", (), _afi, "1756-RM003, AFI"),
    Entry("NOP", (), _nothing, "1756-RM003, NOP"),
    Entry("LBL", ("Label",), _nothing, "1756-RM003, JMP and LBL"),
    Entry("JMP", ("Label",), _jmp, "1756-RM003, JMP and LBL"),
    Entry("JSR", ("Routine Name", "Number of Inputs"), _jsr, "1756-RM003, JSR", optional=-1),
    Entry("SBR", (), _sbr, "1756-RM003, JSR, SBR, RET", optional=-1),
    Entry("RET", (), _ret, "1756-RM003, JSR, SBR, RET", optional=-1),
    Entry("TND", (), _leave, "1756-RM003, TND"),
    Entry("FOR", _FOR, _for, "1756-RM003, FOR and BRK"),
    Entry("BRK", (), _brk, "1756-RM003, FOR and BRK"),
    Entry("MCR", (), _mcr, "1756-RM003, MCR"),
)
