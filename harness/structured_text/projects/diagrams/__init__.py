"""Graphical bodies and their translation to Structured Text.

`sfc` has Sequential Function Charts, `networks` has Ladder and Function Block Diagrams. The readers
of both in PLCopen XML are in `projects.plcopen`.
"""
