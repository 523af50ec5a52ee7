"""Sequential Function Charts of Logix, and their translation to Structured Text."""
