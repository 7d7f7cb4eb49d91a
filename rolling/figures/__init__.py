"""Figures of runs: one function per figure on axes, and the files of figures."""

from acoustics import matplotlib_import  # noqa: F401, before matplotlib
from rolling.figures.catalogue import has_written_figures, plot_run, write_figures
from rolling.figures.sweep_figures import write_number_figures

__all__ = ["has_written_figures", "plot_run", "write_figures", "write_number_figures"]
