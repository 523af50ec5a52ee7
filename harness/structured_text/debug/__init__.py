"""A debugger over the built-in engine: the Debug Adapter Protocol, forwards and backwards.

`places` finds the lines with statements, and `tracer` stops at them. `machine` is the interface of
a run, and `player` moves back and forth in it. `devices` is the interface of programs of devices,
which run beside the PLC's program in other languages. `debugger` executes the user's `orders`.
`session` serves the client, with `breakpoint_requests` and `view_requests`.
"""
