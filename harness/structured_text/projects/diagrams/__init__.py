"""Graphical bodies: models of networks and charts, and their translation to Structured Text.

`network` has Ladder Diagrams and Function Block Diagrams, `sfc` has Sequential Function Charts. The
readers of the formats are beside this folder.
"""
