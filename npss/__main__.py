"""``python -m npss``: the command ``npss`` where the scripts of this Python are not on the path."""

import sys

from npss.commands import main

sys.exit(main())
