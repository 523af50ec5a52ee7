"""Coverage of Structured Text by tests: statements, branches, conditions, MC/DC.

The built-in engine counts (`engines.builtin.collector`); each process makes a part of its counts
(`parts`), `measure` makes results of all parts, which are written as a table, as pages with source
lines, for lcov and as Cobertura XML (`output`).

A line that cannot be reached is removed, or has `(* unreachable: reason *)` on it or in a line
of its own before it; the comment covers the statements and branches of that line. The branch of
an IF without ELSE, or of a CASE in which no label fits, is on the line of END_IF or END_CASE.

MC/DC is masking MC/DC (each condition decides the outcome, once TRUE and once FALSE, in two
evaluations in which a change of it alone would change the outcome, or may have done so where
conditions were skipped); where the two evaluations differ in this condition only, it has
unique-cause MC/DC as well. AND and OR skip nothing, so every evaluation counts for all their
conditions, unless looking at one could end the run.
"""
