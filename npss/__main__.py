"""Run the command ``npss`` as ``python -m npss``, for when Python's scripts are not on the path."""

import sys

from npss.commands import main

sys.exit(main())
