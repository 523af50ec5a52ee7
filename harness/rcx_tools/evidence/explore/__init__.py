"""Exploration of every reachable state of the real blocks, with every choice of the environment.

`model` describes a model, `models` lists all, `oracle` judges each scan, `search` is the world of a
model, `replay` shows a trace, and `seeded` adds bugs that must be found. The search itself and
the comparison of states are in `rcx_harness.verify.explore`.
"""
