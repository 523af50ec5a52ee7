"""The command `rcx`: a module for each subcommand; `start` is where it begins."""
