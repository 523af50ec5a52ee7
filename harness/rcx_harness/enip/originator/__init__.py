"""What asks: explicit messages and the scanner's connection."""
