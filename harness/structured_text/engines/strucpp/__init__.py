"""The engine that compiles with STruC++, which users install themselves."""
