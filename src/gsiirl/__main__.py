"""`python -m gsiirl`."""

import sys

from gsiirl.cli import main

sys.exit(main())
