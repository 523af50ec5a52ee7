"""Projects of PLC tools: their Structured Text, with the line numbers of the project file.

`formats` recognizes project files by their names. `open` reads them, and is imported only if the
user names a project file.
"""
