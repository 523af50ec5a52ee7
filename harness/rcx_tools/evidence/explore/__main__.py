"""Entry point of `python -m rcx_tools.evidence.explore`: see `command`."""

import sys

from rcx_tools.evidence.explore.command import main

if __name__ == "__main__":
    sys.exit(main())
