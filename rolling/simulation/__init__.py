"""Runs: scenes are solved in pieces on all cores, get their sound and numbers, and are stored.

`solving` solves scenes in memory, `batch` writes result.h5 as runs grow, `run_result` adds sound
and numbers.
"""
