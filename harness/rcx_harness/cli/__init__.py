"""The command `rcx`: a module for each subcommand; the program begins in `start`."""
