"""Mutation testing of Structured Text: small deliberate mistakes, one at a time.

A test must fail for each mistake. `mutant` creates the mutants, `engine` inserts one of them into
compiled programs.
"""
