"""Ready properties of the handshake between a PLC program and a robot program.

`stable` demands data that do not change while a strobe says that they are valid. `standstill`
demands that something moves. `waits` says in words what PLC and robot programs wait for.
"""
