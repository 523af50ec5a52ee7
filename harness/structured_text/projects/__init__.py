"""Projects of PLC tools: their Structured Text, with the lines that it stands in.

`formats` knows them by their names; `open` reads them, and is loaded where there is one.
"""
