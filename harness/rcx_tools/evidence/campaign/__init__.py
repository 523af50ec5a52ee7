"""Random long runs of this library with every kind of fault.

One program with most kinds of blocks gets random requests. At the same time all kinds of faults
occur, and operators press stop buttons and take over the control. Then all faults end. The check
requires that no rule of the wire or of the contract is broken, and that each command is executed
exactly once, or at most once if it ends with an error of unknown outcome. Nothing may start by
itself, and the documented recovery must lead to a working cell.

The code for storms, faults and the shortening of a failing run is that of `rcx campaign`. The
modules here are specific to this program and this library. For example, `requests` compares the
requests with the executions.
"""
