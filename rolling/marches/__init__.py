"""Pieces of a march, which any number of processes solve, and the results that they make."""
