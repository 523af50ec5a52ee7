"""What is written: whole files or none, lines of a log, and what an export knows again."""
