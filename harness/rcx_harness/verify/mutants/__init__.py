"""Mutation testing: small mistakes are made on purpose, in the library and in what judges it.

For each of them a test must fail.

`python -m rcx_tools.evidence.mutants` says how; docs/verification.md says what came of it.
"""
