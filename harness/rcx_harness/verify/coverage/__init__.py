"""Coverage of Structured Text by tests: statements, branches, conditions, MC/DC.

The tests run on the built-in engine, which counts (`engine.builtin.coverage`); `measure` makes
results of the counts, which are written as text, as HTML with source lines and for lcov.

A line that cannot be reached is removed, or has `(* unreachable: reason *)` on it or in a line
of its own before it; the comment covers the statements and branches of that line. The branch of
an IF without ELSE, or of a CASE in which no label fits, is on the line of END_IF or END_CASE.

MC/DC is masking MC/DC (each condition decides the outcome, once TRUE and once FALSE, in two
evaluations in which a change of it alone would change the outcome); where the two evaluations
differ in this condition only, it has unique-cause MC/DC as well. Nothing short-circuits in
Structured Text, so every evaluation counts for all its conditions.
"""
