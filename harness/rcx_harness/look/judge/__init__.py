"""The judgement of a recorded controller and its PLC, from a capture or a trace."""
