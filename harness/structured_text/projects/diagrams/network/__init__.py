"""Networks of Ladder Diagrams (LD) and Function Block Diagrams (FBD)."""
