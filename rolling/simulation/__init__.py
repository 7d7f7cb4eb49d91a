"""Runs: scenes are solved in pieces on all cores, made audible, summarized and stored.

`solving` solves scenes in memory, `batch` writes result.h5 as runs grow, and `run_result` adds the
sound and the summary.
"""
