"""Functions for Python: runs of spheres and of bearings, and choices between them."""
