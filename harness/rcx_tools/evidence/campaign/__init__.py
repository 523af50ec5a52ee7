"""Random long runs of this library with every kind of fault.

One program with most kinds of blocks is driven at random. Meanwhile all kinds of faults occur, and
operators press stops and take over. Then the causes disappear. The check requires that no rule of
the wire or
of the contract is broken, and that each command is executed exactly once, or at most once with an
error that says so. Nothing may start by itself, and the documented recovery must lead to a working
cell.

Storms, faults and the shortening of a failing run come from `rcx campaign`. The modules here are
for this program and this library: `requests` compares the requests with the executions.
"""
