"""A debugger over the built-in engine: the Debug Adapter Protocol, forwards and backwards.

`places` finds the lines with statements, and `tracer` stops at them. `machine` is the interface of
a run, and `player` moves back and forth in it. `debugger` steps, `session` serves the client.
"""
