"""The conformance page: levels, third octaves and resampling against their requirements.

The requirements are IEC 61672-1, IEC 61260-1 and the package's own limits.
"""
