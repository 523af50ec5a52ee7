"""`rcx debug`: the Debug Adapter Protocol over the built-in engine, forwards and backwards.

`places` knows which lines have statements, `tracer` stops at them, `machine` is what runs,
`history` and `player` go back in it, `debugger` steps, `session` talks to the client.
"""
