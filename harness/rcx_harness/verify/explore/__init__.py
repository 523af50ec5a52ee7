"""Exploration of every reachable state of a user's program with its panel and a small controller.

`user` defines the state space of the program, with `controller` as its surroundings. `kept` lists
which variables of the library's blocks have a later effect.
"""
