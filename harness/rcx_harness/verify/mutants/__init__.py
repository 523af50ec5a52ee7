"""Mutation testing of the library: small mistakes are made in it on purpose, and tests must fail.

`python -m rcx_harness.verify.mutants` says how; docs/verification.md says what came of it.
"""
