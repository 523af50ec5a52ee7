"""Entry point of `python -m rcx_tools.evidence.campaign`."""

import sys

from rcx_tools.evidence.campaign.main import main

if __name__ == "__main__":
    sys.exit(main())
