"""Execution of independent work items on many processors.

The number of processors never changes the results.
"""

from structured_text.farm.cluster import Cluster
from structured_text.farm.farm import NOT_YET, Farm, NotYet
from structured_text.farm.parcel import Parcel
from structured_text.farm.result_file import ResultFile
from structured_text.farm.work import Lost, LostError, Prepared

__all__ = [
    "NOT_YET",
    "Cluster",
    "Farm",
    "Lost",
    "LostError",
    "NotYet",
    "Parcel",
    "Prepared",
    "ResultFile",
]
