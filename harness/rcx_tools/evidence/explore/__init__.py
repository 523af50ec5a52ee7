"""Exploration of all reachable states of small programs with the blocks of the library.

`model` describes a model, and `models` lists all models. `oracle` judges each scan, `search`
explores a model, and `replay` shows a trace. `seeded` inserts bugs that must be found. The search
itself and the comparison of states are in `rcx_harness.verify.explore`.
"""
