"""Lets the tests of this folder import `probes`, which the script `record.py` imports too."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
