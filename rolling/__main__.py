"""The command `rolling` as `python -m rolling`."""

from __future__ import annotations

import sys

from rolling.cli import main

if __name__ == "__main__":
    sys.exit(main())
