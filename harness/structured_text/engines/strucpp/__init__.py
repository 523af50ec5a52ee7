"""STruC++ as an engine: found on the user's machine, never part of this project."""
