"""Answer to the inverse question: which waves of a surface must be lower, and by how much.

`design_search` computes it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.choice.advice import Advice
from rolling.choice.change_words import two_digits
from rolling.choice.choice_numbers import OmittedPair
from rolling.choice.choice_sentences import counted
from rolling.choice.difference import Difference
from rolling.choice.heard_specimen import HeardQuantity
from rolling.choice.wave_bands import PlateBands
from rolling.surface.lowered_waves import HALF_BAND, nominal

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

MEASURE = "sum of the squares of its decibels over third octaves"
LEAST_SHOWN_DB = 0.05  # of a band; less is left as it is
MORE = "More specimens (--pairs), or a longer track or scan, may show that fewer are enough."
NAMED = 3  # bands that the sentence names


class Round(NamedTuple):
    """A changed surface that was marched.

    aimed_db : float, dB. Fall by the linear response.
    lowered_db : (bands,) array, dB. By how much each band is lowered.
    fall : Difference. Fall of the level over the specimens.
    """

    aimed_db: float
    lowered_db: Array
    fall: Difference

    @property
    def fall_db(self) -> float:
        """Fall of the level by the marches [dB]; infinite where nothing sounds any more."""
        return np.inf if self.fall.db is None else self.fall.db


@dataclass(frozen=True, eq=False, repr=False)
class Design(Advice):
    """Waves that must be lower for a quieter scene, with the least change of the roughness.

    Attributes
    ----------
    name : str
        Name of the scene.
    quantity : HeardQuantity
        The quantity that gets quieter: the vibration of a ball.
    quieter_db : float, dB
        The fall that was asked for.
    bands : PlateBands
        Waves of the surface as it is, and their response.
    rounds : list of Round
        The changed surfaces that were marched, in their order; the nearest to what was asked for
        is the answer.
    noun : str
        What the specimens are: surfaces, or places of the scan.
    folder : Path
        Folder of the specimens.
    scene, changed : scene
        The scene as it is, and with its waves lowered.
    omitted : sequence of OmittedPair
        Specimens that are left out, because a contact has no solution. Default: none.
    doubt : str
        Sentence on bands whose response is not known, so that more waves are lowered than may be
        necessary. Default: empty.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np, rolling
    >>> from rolling.choice.audition import SOUND
    >>> from rolling.choice.design import Round
    >>> from rolling.choice.wave_bands import PlateBands
    >>> fall = rolling.Difference("sound", 2, 3.0, 0.1, 0.99, {"scatter": 0.1})
    >>> bands = PlateBands(
    ...     wavelength_m=np.array([1e-4, 5e-5]), rms_m=np.array([4e-8, 2e-8]),
    ...     responses=np.array([[0.5, 0.4], [0.6, 0.3]]),
    ... )
    >>> design = rolling.Design(
    ...     name="scene", quantity=SOUND, quieter_db=3.0, bands=bands,
    ...     rounds=[Round(3.0, np.array([6.0, 0.0]), fall)], noun="surfaces", folder=Path(),
    ...     scene=None, changed=None,
    ... )
    >>> design.table()["amplitude_target_nm"].round(1).tolist()
    [20.0]
    """

    name: str
    quantity: HeardQuantity
    quieter_db: float
    bands: PlateBands
    rounds: list[Round]
    noun: str
    folder: Path
    scene: Any
    changed: Any
    omitted: Sequence[OmittedPair] = ()
    doubt: str = ""

    @property
    def found_by(self) -> list[str]:
        """Sentences on how the answer was found."""
        sentences = [
            f"Of all changes of the waves that are enough by {self.by_response}, the one with the"
            f" smallest {MEASURE} was marched on {self.noun} with the same phases."
        ]
        if self.fall.uncertainty_db is not None:
            sentences.append("The ± is one standard uncertainty of the mean change by Student's t.")
        if self.doubt:
            sentences.append(self.doubt)
        return sentences

    @property
    def by_response(self) -> str:
        """Name the response by which a change is enough."""
        words = "the linear response"
        return f"{words}, as far as it is known" if self.doubt else words

    @property
    def answer(self) -> Round:
        """The changed surface whose fall by marches is the nearest to what was asked for."""
        return nearest(self.rounds, self.quieter_db)

    @property
    def fall(self) -> Difference:
        """Fall of the level by marches of the changed surface, with its ±."""
        return self.answer.fall

    @property
    def lowered_db(self) -> Array:
        """By how much each band is lowered, (bands,) [dB]."""
        return self.answer.lowered_db

    @property
    def target_rms_m(self) -> Array:
        """Rms of profiles along the track in each band that is aimed at, (bands,) [m]."""
        return np.asarray(self.bands.rms_m * 10.0 ** (-self.lowered_db / 20.0))

    def table(self) -> pd.DataFrame:
        """Tabulate the bands that are lowered, long waves first.

        Returns
        -------
        table : pandas.DataFrame
            One row per third octave: wavelength_um (its middle), amplitude_now_nm and
            amplitude_target_nm (rms of a profile along the track), lowered_db, response_db_per_db
            (fall of the level where the band is a decibel lower) and its standard error, NaN where
            a single specimen, or places that are as good as one, tell none.
        """
        whole = self.target()
        return whole[whole["lowered_db"] > 0].drop(columns=[*_PSD]).reset_index(drop=True)

    def target(self) -> pd.DataFrame:
        """Tabulate all bands of the surface with their power spectral density, long waves first.

        Returns
        -------
        table : pandas.DataFrame
            The columns of `table`, and frequency_1_mm, psd_now_um3 and psd_target_um3: the
            one-sided power spectral density of a profile along the track [um2 mm / 1000], as a mean
            over the third octave.
        """
        import pandas as pd  # slow to import, for tables only

        wavelength_um = 1e6 * self.bands.wavelength_m
        width_1_um = (HALF_BAND - 1 / HALF_BAND) / wavelength_um
        now_um = 1e6 * self.bands.rms_m
        target_um = 1e6 * self.target_rms_m
        return pd.DataFrame(
            {
                "wavelength_um": [float(nominal(middle)) for middle in wavelength_um],
                "frequency_1_mm": 1e3 / wavelength_um,
                "amplitude_now_nm": 1e3 * now_um,
                "amplitude_target_nm": 1e3 * target_um,
                "lowered_db": self.lowered_db,
                "psd_now_um3": np.square(now_um) / width_1_um,
                "psd_target_um3": np.square(target_um) / width_1_um,
                "response_db_per_db": self.bands.response,
                "response_error_db_per_db": self.bands.error,
            }
        )

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the amplitudes of the bands as they are and as they are aimed at."""
        from rolling.choice.advice_pictures import plot_design

        return plot_design(self, ax)

    @property
    def lines(self) -> list[str]:
        """A line per band that is lowered: wavelength, amplitude now and then, decibels."""
        heads = ["wavelength", "rms now", "target", "lower by", "level falls"]
        rows = [heads]
        for row in self.table().itertuples():
            rows.append(
                [
                    f"{row.wavelength_um:g} um",
                    f"{row.amplitude_now_nm:.3g} nm",
                    f"{row.amplitude_target_nm:.3g} nm",
                    f"{row.lowered_db:.1f} dB",
                    f"{row.response_db_per_db:.3f} dB/dB",
                ]
            )
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        return [
            "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
            for row in rows
        ]

    @property
    def sentences(self) -> list[str]:
        """The answer in words, and what to doubt."""
        return [*_sentences(self)]


def nearest(rounds: Sequence[Round], quieter_db: float) -> Round:
    """Return the changed surface whose fall by marches is the nearest to a wanted one [dB]."""
    return min(rounds, key=lambda marched: abs(marched.fall_db - quieter_db))


_PSD = ("frequency_1_mm", "psd_now_um3", "psd_target_um3")


def _sentences(result: Design) -> Iterator[str]:
    """Yield the answer, how it was found, and what to doubt."""
    fall = result.fall
    assert fall.db is not None  # a surface without any sound is no answer
    lowered = result.lowered_db
    bands = [nominal(1e6 * middle) for middle in result.bands.wavelength_m]
    order = np.argsort(-lowered)
    strongest = [f"{bands[k]} um by {lowered[k]:.1f} dB" for k in order[:NAMED] if lowered[k] > 0]
    count = int(np.count_nonzero(lowered))
    changed = [k for k in range(len(bands)) if lowered[k] > 0]
    ends = f"{bands[changed[0]]} um"
    if count > 1:
        ends = f"{bands[changed[-1]]} to {ends}"
    yield (
        f"With waves of {ends} lower along the track, the scene is"
        f" {two_digits(fall.db, fall.uncertainty_db)} {result.quantity.decibels} quieter"
        f" ({counted(fall, result.noun)}, each marched as it is and with lower waves of the same"
        f" phases); {result.quieter_db:g} dB were asked for."
    )
    yield (
        f"Lower most: {'; '.join(strongest)}. By {result.by_response}, no other change that is"
        f" enough has a smaller {MEASURE}."
    )
    if result.doubt:
        yield f"{result.doubt} {MORE}"
    total = float(result.bands.response.sum())
    rq_now = 1e9 * float(np.sqrt(np.sum(np.square(result.bands.rms_m))))
    rq_target = 1e9 * float(np.sqrt(np.sum(np.square(result.target_rms_m))))
    yield (
        f"Rq of profiles along the track falls from {rq_now:.3g} to {rq_target:.3g} nm."
        f" All waves a decibel lower would make it {total:.2f} dB quieter."
    )
    first = result.rounds[0]
    if first is not result.answer and np.isfinite(first.fall_db):
        yield (
            f"The linear response aimed at {first.aimed_db:.2f} dB first, and marches gave"
            f" {first.fall_db:.2f} dB, because the contact is not linear; so it aims at"
            f" {result.answer.aimed_db:.2f} dB."
        )
    if fall.uncertainty_db is None:
        yield f"The ± is not known, because {result.noun} are too few or too much alike."
    else:
        if not fall.is_sure:
            yield (
                "It is not sure that it gets quieter at all; more specimens (--pairs), or a longer"
                " track or scan, would tell."
            )
        off = abs(fall.db - result.quieter_db)
        if off > fall.uncertainty_db:
            yield (
                f"The marches miss the fall that was asked for by {off:.2f} dB after"
                f" {len(result.rounds)} changed surfaces, which is more than the ±."
            )
    for pair in result.omitted:
        yield f"Number {pair.number} of the {result.noun} is left out: {pair.reason}."
