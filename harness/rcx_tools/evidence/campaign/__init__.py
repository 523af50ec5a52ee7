"""Random long runs of this library with every kind of fault.

One program with most kinds of blocks is driven at random while everything fails and people press
stops and take over; then the causes go. Checked is that no rule of the wire or of the contract is
broken, that each command is executed exactly once, or at most once with an error that says so,
that nothing starts by itself, and that the documented way back leads to a working cell.

Storms, faults and what makes a failing run short are those of `rcx campaign`; what is here knows
this program and this library: `requests` compares what was asked for with what was executed.
"""
