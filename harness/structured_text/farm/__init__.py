"""Independent pieces of work on many processors; how many of them never changes what comes out."""

from structured_text.farm.cluster import Cluster
from structured_text.farm.farm import NOT_YET, Farm, NotYet
from structured_text.farm.kept import Kept
from structured_text.farm.parcel import Parcel
from structured_text.farm.work import Lost, LostError, Prepared

__all__ = [
    "NOT_YET",
    "Cluster",
    "Farm",
    "Kept",
    "Lost",
    "LostError",
    "NotYet",
    "Parcel",
    "Prepared",
]
