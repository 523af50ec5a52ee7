"""The fault campaign: random long runs in which everything fails, again and again.

One program with most kinds of blocks is driven at random while packets are lost, late and
doubled, the packet interval changes, scans overrun, PLC and controller lose their power, people
press stops and take over; then the causes go. Checked is that no rule of the wire or of the
contract is broken, that each command is executed exactly once, or at most once with an error that
says so, that nothing starts by itself, and that the documented way back leads to a working cell.
"""
