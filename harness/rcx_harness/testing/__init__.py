"""For users who test their own PLC project with pytest: plugin, settings, evidence of failures."""
