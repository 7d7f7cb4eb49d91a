"""Pictures of runs: plots on given axes, figures with title, note and table, the gallery of a run or a sweep."""
