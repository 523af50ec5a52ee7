"""Export to files in a folder, in the Structured Text dialect of a tool."""
