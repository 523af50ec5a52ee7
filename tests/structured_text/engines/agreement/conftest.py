"""Let the tests of this folder import `probes`, as the script `record.py` does."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
