"""What the robot adds to the language server."""
