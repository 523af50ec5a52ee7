"""A debugger over the built-in engine: the Debug Adapter Protocol, forwards and backwards.

`places` knows which lines have statements, `tracer` stops at them, `values` shows and sets
variables, `expressions` evaluates, `protocol` talks to an editor.
"""
