"""Measurements of the conformance page: levels, third octaves and resampling.

The requirements are IEC 61672-1, IEC 61260-1 and the limits that `acoustics` sets itself.
"""
