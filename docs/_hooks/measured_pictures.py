"""The picture of what docs/accuracy.md tabulates about choices: their calibration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from build_cache import ROOT
from drawn_pictures import Drawn, legend_below, new_figure
from scipy import stats

from acoustics.arrays import Array
from acoustics.plot_style import COLOURS, LINE_STYLES, gridded

ACCURACY = ROOT / "docs" / "accuracy.md"
ROUNDING = 0.06  # of shares in percent, as the table prints them
BINOMIAL = 0.05  # probability of fewer right answers, below which a promise does not hold


def rows_of_table(heading: str) -> list[dict[str, str]]:
    """Return the rows of the table of docs/accuracy.md whose first columns are headed so."""
    lines = ACCURACY.read_text(encoding="utf-8").splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(f"|{heading}|"))
    names = lines[first].strip("|").split("|")
    rows = []
    for line in lines[first + 2 :]:
        if not line.startswith("|"):
            break
        rows.append(dict(zip(names, line[1:-1].split("|"), strict=True)))
    return rows


class Calibration(NamedTuple):
    """Answers of a table of docs/accuracy.md, by their sureness [%].

    rows : list of str. Ranges of the sureness.
    promised, right : (rows,) arrays. Mean sureness, and answers that were right.
    fewest : (rows,) array. Right answers, of which fewer have a probability below 5 %.
    """

    rows: list[str]
    promised: Array
    right: Array
    fewest: Array

    @property
    def failed(self) -> int:
        """Number of rows with fewer right answers than that."""
        return int(np.count_nonzero(self.right < self.fewest - ROUNDING))


def read_calibration(heading: str) -> Calibration:
    """Read the table of a calibration whose first column is headed so."""
    rows = rows_of_table(f"{heading}|answers")
    answers = np.array([int(row["answers"]) for row in rows])
    promised = np.array([float(row["promised"].rstrip(" %")) for row in rows])
    return Calibration(
        rows=[row[heading].rstrip(" %").replace(" to ", "-") for row in rows],
        promised=promised,
        right=np.array([float(row["right"].rstrip(" %")) for row in rows]),
        fewest=100 * stats.binom.ppf(BINOMIAL, answers, promised / 100) / answers,
    )


def calibration(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the right answers of choices on single scans over the sureness that they stated."""
    figure = new_figure(6.4)
    curve, by_row = figure.subplots(2)
    curve.plot([50, 100], [50, 100], color="0.5", linewidth=0.9, label="as promised")
    by_row.axhline(0.0, color="0.5", linewidth=0.9)
    of_places = read_calibration("sureness")
    of_windows = read_calibration("sureness, each place counted as one")
    drawn = {"independent places": of_places, "each place counted as one": of_windows}
    for number, (label, answers) in enumerate(drawn.items()):
        style = {"color": COLOURS[number], "marker": "os"[number]}
        slots = np.arange(len(answers.rows)) + 0.12 * (2 * number - 1)
        curve.plot(
            answers.promised, answers.right, linestyle=LINE_STYLES[number], label=label, **style
        )
        by_row.plot(slots, answers.right - answers.promised, linestyle="none", **style)
        by_row.plot(
            slots,
            answers.fewest - answers.promised,
            color=COLOURS[number],
            linestyle="none",
            marker="_",
            markersize=10,
            markeredgewidth=2,
        )
    curve.plot(
        [],
        [],
        color="0.5",
        linestyle="none",
        marker="_",
        markersize=10,
        markeredgewidth=2,
        label="fewest that a chance of 5 % allows",
    )
    gridded(curve, xlabel="sureness that was stated [%]", ylabel="right answers [%]")
    gridded(by_row, xlabel="sureness that was stated [%]", ylabel="right less promised [%]")
    by_row.set_xticks(range(len(of_places.rows)), of_places.rows)
    legend_below(figure, curve, columns=2)
    numbers = {
        "rows": str(len(of_places.rows)),
        "held": str(len(of_places.rows) - of_places.failed),
        "rows as one": str(len(of_windows.rows)),
        "failed as one": str(of_windows.failed),
    }
    return Drawn(figure, numbers)
