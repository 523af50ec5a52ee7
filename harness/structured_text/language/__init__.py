"""The front end of both engines: parses Structured Text, checks it and reports mistakes.

`load` is the entry point. Code that runs a project which is already checked needs only
`project`, `tree`, `paths` and `values`.
"""
