"""Export to Rockwell L5X, for Studio 5000 Logix Designer."""
