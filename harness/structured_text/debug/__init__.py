"""A debugger over the built-in engine: the Debug Adapter Protocol, forwards and backwards.

`places` knows which lines have statements, `tracer` stops at them, `machine` is what runs,
`player` goes back in it, `debugger` steps, `session` talks to the client.
"""
