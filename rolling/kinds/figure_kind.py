"""A figure that a kind of scene gives its runs: how it is drawn, its table, and which runs have it.

Files, page and `rolling.plot` draw a figure by the same function.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

Groups = Callable[[Sequence[Any]], Iterable[tuple[str, Sequence[Any]]]]


def _always(shown: Any) -> bool:
    return True


@dataclass(frozen=True)
class FigureKind:
    """A kind of figure: its function on axes, its table, and the runs that have it.

    Parameters
    ----------
    draw : callable of (runs, ax=), or of (run, ax=) for a figure of one run.
    table : callable of the same runs or run. None for a map.
    is_shown : callable of the same. Whether the runs have the figure.
    is_single : bool. Whether it is of one run; otherwise it compares runs.
    shares_scales : bool. Whether `draw` takes the runs `among` which a run is compared.
    is_unasked : callable of the same. Whether the runs have it without a request, if fewer runs do.
    is_asked_only : bool. Whether neither page nor `rolling run` has it.
    is_written : bool. Whether `rolling run` writes the figure beside its page. None: it does if the
        figure compares runs.
    is_polar : bool. Whether new axes for it are polar.
    groups : callable of runs. Labels and runs of the groups of which each has the figure. None:
        all runs have it together.
    """

    draw: Callable[..., Axes]
    table: Callable[..., DataFrame] | None = None
    is_shown: Callable[[Any], bool] = _always
    is_single: bool = False
    shares_scales: bool = False
    is_unasked: Callable[[Any], bool] = _always
    is_asked_only: bool = False
    is_written: bool | None = None
    is_polar: bool = False
    groups: Groups | None = None

    @property
    def has_file(self) -> bool:
        """Whether `rolling run` writes the figure beside its page, where runs have it unasked."""
        return not self.is_single if self.is_written is None else self.is_written
