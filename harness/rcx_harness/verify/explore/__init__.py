"""Exploration of every reachable state of a user's program with its panel and a small controller.

`user` defines the state space of the program, with `controller` as its surroundings. `state_tables`
lists the variables of the library's blocks that have a later effect.
"""
