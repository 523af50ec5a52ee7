"""Mutation testing: small mistakes are made on purpose in Structured Text, one at a time.

For each of them a test must fail. `mutant` makes them, `engine` puts one into compiled programs,
`pool` runs each in a process of its own, `report` says what came of them.
"""
