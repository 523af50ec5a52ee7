"""The originator: explicit messages and the scanner's connection."""
