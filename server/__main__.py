"""`python -m server` is `balise`."""

import sys

from server.cli import main

sys.exit(main())
