"""Finished runs: their sound, numbers, doubts and labels, and the files that hold them."""
