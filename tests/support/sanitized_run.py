"""Run the library on matiec with hostile inputs: `python sanitized_run.py [FILE.st]`.

test_sanitizers.py in tests/structured_text/engines/matiec starts this script with the sanitizers'
library preloaded. If a file is given, the script runs that program for one scan instead.
"""

from __future__ import annotations

import sys
from random import Random

from plc_bench import PlcBench
from structured_text.engines import build

_BLOCKS = ("First", "Second", "Third", "ServoOn", "AlarmReset", "ProgramReset", "AutoStart")
_OFFSETS = (-32768, -1, 0, 1, 464, 465, 32767)
_SIZES = (-1, 0, 47, 48, 256, 32767)


def _hostile(scans: int) -> None:
    random, plc = Random(1), PlcBench()
    for _ in range(scans):
        for _ in range(random.choice((0, 0, 1, 3))):
            plc.so[random.randrange(48)] ^= 1 << random.randrange(8)
        for block in _BLOCKS:
            if random.random() < 0.05:
                plc[f"{block}.Execute"] = not plc[f"{block}.Execute"]
        if random.random() < 0.02:
            plc["ReadArea.m"], plc["WriteArea.n"] = random.choices(_OFFSETS, k=2)
            plc["ReadArea.Size"], plc["WriteArea.Size"] = random.choices(_SIZES, k=2)
        plc.scan()


if __name__ == "__main__":
    if sys.argv[1:]:
        build(sys.argv[1:], "matiec").program.scan(0)
    else:
        _hostile(5000)
    print("no finding")
