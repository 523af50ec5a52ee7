"""Record the traces of all probes again, from matiec.

Run it as `python tests/structured_text/engines/agreement/record.py`.
"""

from __future__ import annotations

import sys

from probes import language_probes, trace, trace_file

from structured_text.engines.load import build
from structured_text.errors import InputError


def main() -> int:
    """Write tests/data/traces; return 2 if matiec is missing or a probe does not compile."""
    for probe in language_probes():
        try:
            program = build(probe.files, "matiec").program
        except InputError as error:
            print(error, file=sys.stderr)
            return 2
        lines = trace(program, probe)
        trace_file(probe).write_text("\n".join(lines) + "\n", encoding="utf-8")
        print(f"{probe.name}: {len(lines) - 2} scans")
    return 0


if __name__ == "__main__":
    sys.exit(main())
