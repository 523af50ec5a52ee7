"""Function block diagrams of Logix: sheets, and their translation to Structured Text."""
