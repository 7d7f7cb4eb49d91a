"""The terminal: streams that lose no work, lines and bars for every wait, quiet and verbose."""
