"""Numbers that help texts name and commands use, in a module that imports nothing."""

MAX_RUNS_ON_PAGE = 24  # with player, pictures and slow motion each: half a megabyte and more
MAX_RUNS_COMPARED = 400  # with a curve each in pictures of all runs, and a row on the terminal
FEW_RUNS = 20  # of more, on the terminal

# `rolling accuracy`
FINEST = 4  # divisor of the spacing for the reference
ACCURACY_SECONDS = 0.045  # [s] of rolling: no third octave from 100 Hz is empty

# `rolling choose`
WITHIN_DB = 1.0  # wanted ± of a difference
CHOICE_MINUTES = 10.0  # after which no more pairs begin
IMPROVED_WITHIN_DB = 0.1  # wanted ± of a change by --improve
LIMIT_SEEDS = 12  # specimens of --below

# `rolling design`
DESIGN_PAIRS = 6  # specimens

# `rolling listen`
LISTENED_SECONDS = 20.0
MIN_LISTENED_SECONDS = 0.1
MAX_LISTENED_SECONDS = 120.0  # a record in memory, 550 MB while it becomes sound
MAX_LISTENED_POSITIONS = 5e8  # of the track, ten minutes of one core

# `rolling reproduce --quick`
QUICK_SEEDS = 1
QUICK_LOADS_N = (5, 20, 100)
# The widest contact is 1.29 mm long, with two bodies at Ra 5 um and 100 N. The track must be
# longer.
QUICK_SECONDS = 0.015
QUICK_STRIDES = 3

WATCH_SECONDS = 2.0  # between two looks at a folder
