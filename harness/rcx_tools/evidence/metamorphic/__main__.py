"""Entry point of `python -m rcx_tools.evidence.metamorphic`."""

import sys

from rcx_tools.evidence.metamorphic.main import main

if __name__ == "__main__":
    sys.exit(main())
