"""Metamorphic checks: changes that must not matter do not matter.

A program is changed as a user may change it, and must behave the same: areas at other offsets, of
another size, in bytes or words, a slower scan with everything else slowed down equally, the other
engine, the other link. Each relation states the meaning of "the same".
"""
