"""The command `rolling` as `python -m rolling`."""

import sys

from rolling.cli import main

if __name__ == "__main__":
    code = main()
    # Python notes an interruption that came while it ran a text, as imports do for data classes,
    # and would end itself by SIGINT in the place of the code 130. Another text takes the note away.
    exec("")
    sys.exit(code)
