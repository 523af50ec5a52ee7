"""Graphical bodies and their translation to Structured Text.

`sfc` has Sequential Function Charts. The reader of charts in PLCopen XML is in `projects.plcopen`.
"""
