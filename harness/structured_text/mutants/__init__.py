"""Mutation testing: small mistakes are made on purpose in Structured Text, one at a time.

For each of them a test must fail. `mutant` makes them, `engine` puts one into compiled programs.
"""
