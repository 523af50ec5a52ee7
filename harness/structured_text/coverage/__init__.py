"""Coverage of Structured Text by tests: statements, branches, conditions, MC/DC.

The built-in engine counts (`engines.builtin.collector`). Each process saves its counts as a part
(`parts`), and `measure` combines all parts into results. `output` writes them as a table, as pages
with source lines, for lcov and as Cobertura XML.

Remove a line that cannot be reached, or mark it with `(* unreachable: reason *)`. The comment
stands on the line, or on a line of its own before it, and covers the statements and branches of
that line. The branch of an IF without ELSE, or of a CASE in which no label fits, is on the line of
END_IF or END_CASE.

MC/DC is masking MC/DC: each condition decides the outcome, once as TRUE and once as FALSE. A
condition decides an evaluation if inverting this condition alone would change the outcome. If
conditions were skipped, it is sufficient that the outcome may change. If two deciding evaluations
differ in this condition only, the condition has unique-cause MC/DC as well. AND and OR skip a
condition only if its evaluation could end the run. Otherwise every evaluation counts for all
conditions of the decision.
"""
