"""Predefined properties of the handshake between a PLC program and a robot program.

`stable` demands that data do not change while a strobe declares them valid. `standstill` demands
that something moves. `waits` describes the signals for which PLC and robot programs wait.
"""
