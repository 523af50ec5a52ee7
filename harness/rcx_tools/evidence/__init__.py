"""What is shown about this library: checks, their lists, their page."""
