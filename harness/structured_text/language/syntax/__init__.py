"""The parsed source as it is written: declarations, statements and expressions.

Nothing here is checked yet. Names are in the user's spelling, and every node has its position. The
nodes are immutable, so that one parse of a library file serves every project that uses it.
"""

from structured_text.language.syntax.code import *  # noqa: F403
from structured_text.language.syntax.declarations import *  # noqa: F403
