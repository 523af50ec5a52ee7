"""The front end of both engines: parses Structured Text, checks it, names what is wrong.

`load` does that; who runs what was checked before needs only `project`, `tree`, `paths`, `values`.
"""
