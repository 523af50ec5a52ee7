"""A faceplate in the browser for the RCX_PANEL variables of a program that runs in real time."""
