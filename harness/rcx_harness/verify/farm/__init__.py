"""Independent pieces of work on many processors; how many of them never changes what comes out."""

from rcx_harness.verify.farm.cluster import Cluster
from rcx_harness.verify.farm.farm import NOT_YET, Farm, NotYet
from rcx_harness.verify.farm.kept import Kept
from rcx_harness.verify.farm.parcel import Parcel
from rcx_harness.verify.farm.work import Lost, LostError, Prepared

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
