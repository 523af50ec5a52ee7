"""The front end of both engines: parses Structured Text, checks it and reports mistakes.

`load` is the entry point. To run a project that is already checked, `project`, `tree`, `paths` and
`values` are sufficient.
"""
