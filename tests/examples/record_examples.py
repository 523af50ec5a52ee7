"""Record the examples' traces anew, from matiec: `python tests/examples/record_examples.py`."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))

from example_runs import EXAMPLES, SECONDS, changes
from rcx_harness.errors import InputError


def main() -> int:
    """Write tests/data/traces/examples; 2 where matiec is missing."""
    for example in EXAMPLES:
        with tempfile.TemporaryDirectory() as folder:
            trace = Path(folder) / "trace.jsonl"
            try:
                with example.build("matiec", trace=trace) as cell:
                    cell.run(f"{SECONDS}s")
            except InputError as error:
                print(error, file=sys.stderr)
                return 2
            lines = ["recorded from matiec by tests/examples/record_examples.py", *changes(trace)]
        example.recorded.parent.mkdir(parents=True, exist_ok=True)
        example.recorded.write_text("\n".join(lines) + "\n", encoding="utf-8")
        print(f"{example.folder.name}: {len(lines) - 1} changes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
