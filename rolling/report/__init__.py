"""The report page of runs: texts and tables, players, pressure maps that move, and how to cite the
program.
"""
