"""Every reachable state of the real blocks, with every choice of their environment.

`model` says what is explored, `models` lists it, `abstraction` and `kept` tell states apart,
`oracle` judges each scan, `search` goes through all states, `replay` shows a trace, `seeded` puts
bugs in to be found. What tells states apart and judges them knows the variables of these blocks.
"""
