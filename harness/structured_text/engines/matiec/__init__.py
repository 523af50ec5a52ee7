"""The engine that compiles with matiec, as OpenPLC does."""
