"""The command `rolling` as `python -m rolling`."""

import sys

from rolling.cli import main

if __name__ == "__main__":
    sys.exit(main())
