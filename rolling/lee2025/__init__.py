"""The study of Lee, Kim & Kim (2025): its readings are scenes, its statements are judged by them.

`cases` runs the scenes, `conditions` and `statements` judge, `figures` draws, `reproduce` is the
command.
"""
