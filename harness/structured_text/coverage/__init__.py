"""Coverage of Structured Text by tests: statements, branches, conditions, MC/DC.

The built-in engine counts (`engines.builtin.collector`). Each process makes a part of its counts
(`parts`), and `measure` combines all parts into results. `output` writes them as a table, as pages
with source lines, for lcov and as Cobertura XML.

A line that cannot be reached should be removed. Otherwise it has `(* unreachable: reason *)` on it,
or in a line of its own before it; the comment covers the statements and branches of that line. The
branch of an IF without ELSE, or of a CASE in which no label fits, is on the line of END_IF or
END_CASE.

MC/DC is masking MC/DC: each condition decides the outcome, once as TRUE and once as FALSE. A
condition decides an evaluation if a change of it alone would change the outcome, or may change it
where conditions were skipped. If the two evaluations differ in this condition only, it has
unique-cause MC/DC as well. AND and OR skip nothing, so every evaluation counts for all their
conditions, unless evaluating one of them could end the run.
"""
