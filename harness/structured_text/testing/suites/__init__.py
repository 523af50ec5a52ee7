"""Unit tests that are written in Structured Text: they run in virtual time, without a PLC tool.

`framework` adds the text of a unit-test framework to a program, `run` runs its suites, `results`
are their results, which `junit_suites` prepares for CI systems.
"""
