"""Mutation testing of Structured Text: small deliberate mistakes are made, one at a time.

A test must fail for each mistake. `mutant` creates the mutants. `engine` inserts a mutant into
compiled programs.
"""
