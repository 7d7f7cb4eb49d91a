"""Answer to the question which of some bearings moves its ring less, band by band."""

from __future__ import annotations

import html
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from acoustics.arrays import Array
from acoustics.level import level_db
from acoustics.texts import printable
from acoustics.traps import ignoring_underflow
from rolling.bearing_contacts.band_gain import gain_uncertainty_db
from rolling.bearing_run.band_difference import HOUSING, NAMES, BandDifference, band_difference
from rolling.numbers.quantity import uncertain
from rolling.terminal.streams import columns

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

_OVER = 0.999  # probabilities above are not told apart


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False)
class BearingChoice:
    """Answer to the question which of some bearings moves its ring less, band by band.

    Attributes
    ----------
    labels : list of str
        Names of the bearings. The first one is compared with each other one.
    rms : dict of (bearings, specimens) arrays
        Radial velocity of the ring by band (low, medium, high) [um/s rms], and the A-weighted sound
        pressure of the housing plate (housing) [Pa rms] where all scenes have one.
    limit : str
        Why no more specimens were heard although a ± is above the wanted one; empty if none is.
    within_db : float, dB
        The wanted ±.
    folder : Path
        Folder of the choice; it is gone unless one was given.
    gain_levels : dict of list of arrays, dB
        By band, for each bearing: its level without each group of waves of its marches, as of
        `rolling.bearing_contacts.band_gain`. Bands without it have certain gains. Default: none.
    is_early : bool
        Whether the limit of time ended the choice before its rule did.
    command : str
        Command that repeats the answer; empty for a choice in Python.

    Examples
    --------
    >>> import numpy as np
    >>> from rolling.bearing_run.bearing_choice import BearingChoice
    >>> fine = np.array([1.0, 1.1, 0.9])
    >>> choice = BearingChoice(["G5", "G100"], {"high": np.array([fine, 2 * fine])}, "", 1.0)
    >>> f"{choice.differences[0][0].db:.2f} dB"
    '6.02 dB'
    """

    labels: list[str]
    rms: dict[str, Array]
    limit: str
    within_db: float
    folder: Path = Path()
    gain_levels: dict[str, list[Array]] = field(default_factory=dict)
    is_early: bool = False
    command: str = ""

    @property
    def pairs(self) -> int:
        """Number of specimens that each bearing was heard on."""
        return len(next(iter(self.rms.values()))[0])

    @property
    def tried(self) -> int:
        """Number of specimens that were taken, which are all heard."""
        return self.pairs

    @property
    def differences(self) -> list[list[BandDifference]]:
        """How much more each bearing after the first moves in each band [dB]."""
        return [
            [
                band_difference(band, values[0], values[number], self._gain_db(band, number))
                for band, values in self.rms.items()
            ]
            for number in range(1, len(self.labels))
        ]

    def _gain_db(self, band: str, number: int) -> float:
        """Return the uncertainty by the gains of contacts of the first and another bearing [dB].

        The sound of a housing has that of its most uncertain band.
        """
        bands = self.gain_levels if band == HOUSING else [band] if band in self.gain_levels else []
        parts = [
            gain_uncertainty_db(self.gain_levels[name][0], self.gain_levels[name][number])
            for name in bands
        ]
        return max(parts, default=0.0)

    @property
    def sentences(self) -> list[str]:
        """Who moves less in which band, by how much and how sure; one doubt."""
        lines = []
        for number, differences in enumerate(self.differences, start=1):
            lines += _verdicts(self.labels[0], self.labels[number], differences)
        if self.is_early:
            lines.append(
                f"The choice ended early, because {self.limit} after {self.pairs} specimens; with"
                " more --minutes the same command goes on."
            )
        elif self.limit and self._has_large_scatter:
            lines.append(
                f"A ± is above the wanted {self.within_db:g} dB, because {self.limit}; four times"
                " as many specimens would halve it."
            )
        parts = [apart.gain_db for differences in self.differences for apart in differences]
        if max(parts) > self.within_db:
            lines.append(
                f"The gains of the rough contacts alone leave ± {max(parts):.1f} dB, which a longer"
                " numerics.window_mm lowers, and more specimens do not."
            )
        return lines

    @property
    def _has_large_scatter(self) -> bool:
        """Whether more specimens would help: a ± is above the wanted one, and not by the gains."""
        return any(
            apart.uncertainty_db is not None
            and apart.uncertainty_db > max(self.within_db, math.sqrt(2) * apart.gain_db)
            for differences in self.differences
            for apart in differences
        )

    @property
    def in_short(self) -> str:
        """The present differences of the first two bearings, for a line of progress."""
        numbers = [f"{_number(apart)} dB ({NAMES[apart.band]})" for apart in self.differences[0]]
        return f"{printable(self.labels[1])} less {printable(self.labels[0])}: {', '.join(numbers)}"

    def rows(self) -> list[dict[str, Any]]:
        """Return the numbers of each bearing and band by the names of their columns."""
        found = []
        for number, label in enumerate(self.labels):
            for place, (band, values) in enumerate(self.rms.items()):
                row: dict[str, Any] = {
                    "bearing": label,
                    "band": NAMES[band],
                    "velocity_um_s": float(np.sqrt(np.mean(np.square(values[number])))),
                    "more_db": None,
                    "more_uncertainty_db": None,
                    "more_gain_db": None,
                    "sureness": None,
                }
                if band == HOUSING:
                    row["housing_laeq_db"] = level_db(row.pop("velocity_um_s") ** 2)
                if number:
                    apart = self.differences[number - 1][place]
                    row["more_db"] = apart.db if math.isfinite(apart.db) else None
                    row["more_uncertainty_db"] = apart.uncertainty_db
                    row["more_gain_db"] = apart.gain_db
                    row["sureness"] = apart.sureness
                row["specimens"] = self.pairs
                found.append(row)
        return found

    def table(self) -> pd.DataFrame:
        """Tabulate bearings and bands.

        Returns
        -------
        table : pandas.DataFrame
            A row for each bearing and band: velocity [um/s rms], or level of the housing [dB(A)],
            and how much more it is than that of the first bearing, with its ±.
        """
        import pandas as pd

        return pd.DataFrame(self.rows())

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the velocity of each bearing in the three bands, a point for each specimen.

        Parameters
        ----------
        ax : Axes
            Axes of matplotlib. Default: new ones.

        Returns
        -------
        ax : Axes
        """
        from rolling.bearing_run.choice_picture import draw_choice
        from rolling.figures.picture import axes_of

        return draw_choice(self, axes_of(ax))

    @property
    def lines(self) -> str:
        """Table for a terminal: a row for each bearing, a column for each band."""
        heads = ["bearing"]
        for band in self.rms:
            unit = "dB(A)" if band == HOUSING else "um/s"
            heads += [f"{NAMES[band]}, {unit}", "more, dB"]
        rows = [heads]
        for number, label in enumerate(self.labels):
            row = [printable(label)]
            for place, (band, values) in enumerate(self.rms.items()):
                mean = float(np.sqrt(np.mean(np.square(values[number]))))
                row.append(_level(mean) if band == HOUSING else f"{mean:.3g}")
                apart = self.differences[number - 1][place] if number else None
                row.append("" if apart is None else _number(apart))
            rows.append(row)
        return columns(rows)

    def __repr__(self) -> str:
        return "\n".join([*self.sentences, self.lines])

    def _repr_html_(self) -> str:
        """Write sentences and table for a notebook."""
        paragraphs = "".join(f"<p>{html.escape(text)}</p>" for text in self.sentences)
        return f"{paragraphs}<pre>{html.escape(self.lines)}</pre>"


# ---- sentences


def _verdicts(first: str, second: str, differences: list[BandDifference]) -> list[str]:
    """Say in which bands one of two bearings moves less, and which bands stay open."""
    lines = []
    still_open = []
    for apart in differences:
        if not math.isfinite(apart.db):
            quiet = first if apart.db > 0 else second
            lines.append(f"{_where(apart)}, {printable(quiet)} is at rest and the other is not.")
        elif apart.db == 0 and apart.sureness is None:
            lines.append(f"{_where(apart)}, both are alike.")
        elif apart.sureness is not None and not apart.is_sure:
            still_open.append(apart)
        else:
            lines.append(_verdict(first, second, apart))
    for apart in still_open:
        lines.append(
            f"{_where(apart)} it stays open which one is quieter: {printable(second)} is"
            f" {_number(apart)} dB above {printable(first)} ({_specimens(apart)})."
        )
    return lines


def _verdict(first: str, second: str, apart: BandDifference) -> str:
    """Say which of two bearings is quieter in a band, by how much and how sure that is."""
    quiet, loud = (first, second) if apart.db > 0 else (second, first)
    number = uncertain(abs(apart.db), apart.uncertainty_db)
    verb = "is" if apart.band == HOUSING else "moves its ring"
    adverb = "quieter" if apart.band == HOUSING else "less"
    return (
        f"{_where(apart)}, {printable(quiet)} {verb} {number} dB {adverb} than {printable(loud)}"
        f" ({_specimens(apart)})."
    )


def _where(apart: BandDifference) -> str:
    """Begin a sentence with the band."""
    if apart.band == HOUSING:
        return "By the sound of the housing"
    return f"From {NAMES[apart.band]}"


def _specimens(apart: BandDifference) -> str:
    """Say on how many specimens a difference was heard, and how sure its sign is."""
    if apart.sureness is None:
        return "one specimen, so it has no ±"
    sure = "over 99.9 %" if apart.sureness > _OVER else f"{math.floor(100 * apart.sureness)} %"
    return f"{apart.pairs} specimens; {sure} sure"


def _level(pressure_rms: float) -> str:
    """Write the level of an rms sound pressure [Pa] in dB(A), or silence."""
    level = level_db(pressure_rms**2)
    return "silent" if level is None else f"{level:.1f}"


def _number(apart: BandDifference) -> str:
    """Write a difference with its ±."""
    if not math.isfinite(apart.db):
        return "-"
    return uncertain(apart.db, apart.uncertainty_db)
