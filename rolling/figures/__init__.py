"""Pictures of runs: plots on given axes, figures with title, note and table, and the gallery."""
