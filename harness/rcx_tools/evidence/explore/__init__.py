"""Every reachable state of the real blocks, with every choice of their environment.

`model` says what is explored, `models` lists it, `oracle` judges each scan, `search` is the world
of a model, `replay` shows a trace, `seeded` puts bugs in to be found. What goes through all states
and tells them apart is `rcx_harness.verify.explore`.
"""
