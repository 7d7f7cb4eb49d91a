"""Kinds of scenes: what a kind has to tell, which kinds there are, and the folder of a run."""
