"""Input and output of all commands: files, streams, child processes, progress, the system."""
