"""Measurement of how much code of plc/lib the tests execute."""
