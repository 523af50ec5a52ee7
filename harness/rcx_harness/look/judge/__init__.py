"""What a recorded controller and its PLC did: found in a capture or a trace, told and judged."""
