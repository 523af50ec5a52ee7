"""How tests and programs are put to the test: coverage, mutants, all states, proof, many processes.

What is measured here is any Structured Text; nothing knows the tests or reports of one library. Of
its blocks, `explore` knows which variables tell states apart.
"""
