"""The reading and judging of a recorded controller and its PLC, from a capture or a trace."""
