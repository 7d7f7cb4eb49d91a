"""The report page of runs.

It holds texts and tables, players, moving pressure maps, and the citation of the program.
"""

from acoustics import matplotlib_import  # noqa: F401, before matplotlib
