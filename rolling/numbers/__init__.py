"""Numbers of runs: quantities with their uncertainty, doubts about them, and how they are kept."""
