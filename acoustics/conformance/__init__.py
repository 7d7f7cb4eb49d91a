"""The conformance page: levels, third octaves and resampling against IEC 61672-1, IEC 61260-1 and
own requirements.
"""
