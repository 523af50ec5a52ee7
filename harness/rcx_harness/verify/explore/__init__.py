"""Exploration of every reachable state of a user's program with its panel and a small controller.

The module `user` defines the state space of the program together with the small controller in
`controller`. `state_tables` lists the block variables that influence later scans.
"""
