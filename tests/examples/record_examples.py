"""Record the examples' traces again, from matiec: `python tests/examples/record_examples.py`."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))

from example_runs import EXAMPLES, changes, recorded_trace
from structured_text.errors import InputError


def main() -> int:
    """Run each example on matiec, and write its trace. Return 2 if matiec is missing."""
    for example in EXAMPLES:
        try:
            with example.build("matiec") as cell:
                cell.run(example.duration)
                found = list(changes(cell.trace.lines()))
        except InputError as error:
            print(error, file=sys.stderr)
            return 2
        lines = ["recorded from matiec by tests/examples/record_examples.py", *found]
        file = recorded_trace(example)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        print(f"{example.name}: {len(found)} changes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
