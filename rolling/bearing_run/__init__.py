"""Bearings that turn: motion of the ring, sound of the housing, results, figures and page."""

from acoustics import matplotlib_import  # noqa: F401, before matplotlib
