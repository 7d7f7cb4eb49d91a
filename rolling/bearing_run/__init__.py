"""Bearings that turn: motion of the ring, sound of the housing, results, figures and page."""
