"""`python -m rcx_harness` is the command `rcx`."""

import sys

from rcx_harness.start import main

sys.exit(main())
