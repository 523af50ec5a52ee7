"""`python -m rcx_harness.verify.metamorphic`."""

import sys

from rcx_harness.verify.metamorphic.main import main

if __name__ == "__main__":
    sys.exit(main())
