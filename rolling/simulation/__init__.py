"""Runs: scenes are solved in pieces on all cores, get their sound and numbers, and are stored.

`interface` runs scenes in memory, `batch` writes result.h5 as runs grow, `result_file` reads and writes it.
"""
