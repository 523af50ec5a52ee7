"""The server for assistants (`rcx mcp`): tools that check, run, prove and search a program."""
