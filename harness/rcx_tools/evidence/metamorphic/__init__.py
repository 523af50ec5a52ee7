"""Metamorphic checks: what must not matter does not matter.

The same program, changed in a way that a user may change it, does the same: areas at other
offsets, of another size, in bytes or in words, a slower scan with everything else as much slower,
the other engine, the other link. What "the same" means is stated with each relation.
"""
