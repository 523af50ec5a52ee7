"""`python -m rcx_harness` is the command `rcx`."""

import sys

from rcx_harness.cli.start import main

sys.exit(main())
