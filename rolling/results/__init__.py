"""Finished runs: their sound, numbers, caveats and labels, and the files that hold them."""
