"""Run of a bearing: motion of its ring with its numbers, and how it is seen and heard."""

from __future__ import annotations

import html
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from acoustics.traps import ignoring_underflow
from rolling.bearing.ring_record import AXIAL
from rolling.bearing_kind import bearing_sentences
from rolling.bearing_kind.bearing_run_numbers import MarchFindings, bearing_numbers
from rolling.bearing_kind.former_bearing import former_names
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.kinds.shown_run import ShownRun
from rolling.numbers.bearing_numbers import BearingNumbers
from rolling.numbers.run_file import StoredBearing

if TYPE_CHECKING:
    import xarray


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class BearingRun(SolvedBearing, ShownRun):
    """A run of a bearing. It equals no other run, so it can be the key of a dictionary.

    Attributes
    ----------
    scene : BearingScene
        Scene without a sweep.
    record : RingRecord
        Motion of the ring that vibrates, and loads of the balls.
    tracks : BearingTracks
        How the heights of all bodies change the approach of their contacts.
    numbers : BearingNumbers
        All numbers by subject; a run that was opened has the stored ones.
    stored : StoredBearing or None
        What the run folder holds beside the result; None for a run that was not opened.
    values : dict
        Swept values of the run, by dotted key.
    label : str
        Label that distinguishes the run from others, such as `grade G5`.
    folder : Path
        Run folder; the working directory for a run that is in memory only.

    Examples
    --------
    >>> import rolling
    >>> waves = {"inner": {"kind": "smooth", "waviness": {9: 0.1}}}
    >>> scene = rolling.BearingScene(
    ...     bearing={"named": "6204", "speed_rpm": 1800, "axial_load_n": 70, "surfaces": waves},
    ...     sound={"duration_s": 0.2, "listen_s": 0.2},
    ... )
    >>> run = rolling.simulate(scene, progress=False)
    >>> run.moving, [round(line.frequency_hz) for line in run.lines if line.name == "inner 9"]
    ('outer', [178])
    """

    numbers: BearingNumbers
    stored: StoredBearing | None = None

    @property
    def summary(self) -> Mapping[str, Any]:
        """Numbers by the names of version 0.8; read `numbers` instead."""
        warnings.warn(
            "BearingRun.summary has the names of version 0.8; read the attributes of"
            " BearingRun.numbers",
            DeprecationWarning,
            stacklevel=2,
        )
        return former_names(self.numbers, self.label)

    def to_xarray(self) -> xarray.Dataset:
        """Return the content of result.h5 as named arrays with units.

        Returns
        -------
        dataset : xarray.Dataset
            Motion of the ring and loads of the balls over time, tracks over the turns of their
            bodies, and the facts of the run in `attrs`.
        """
        from rolling.bearing_kind import stored_run

        return stored_run.result_dataset(self)

    def _repr_html_(self) -> str:
        """Write the sentences of a run and its bands for a notebook."""
        numbers = self.numbers
        sentences = "".join(f"<p>{html.escape(text)}</p>" for text in numbers.sentences)
        directions = numbers.below_bending.by_direction
        rows = ""
        for band, words in bearing_sentences.band_words(numbers.ring).items():
            cells = ""
            for direction, bands in directions.items():
                text = bearing_sentences.velocity(bands.um_s[band])
                spread = bearing_sentences.spread_of_velocity(bands.by_band[band])
                if direction == AXIAL and numbers.axial_doubt is not None:
                    text += f", {numbers.axial_doubt.severity.word}"
                elif spread:
                    text += f" {spread}"
                cells += f"<td>{text}</td>"
            rows += f"<tr><td>{words}</td>{cells}</tr>"
        heads = "".join(f"<th>{direction} [um/s]</th>" for direction in directions)
        return f"{sentences}<table><tr><th>band</th>{heads}</tr>{rows}</table>"

    def __repr__(self) -> str:
        um_s = self.numbers.below_bending.radial.um_s.values()
        texts = ", ".join("-" if value is None else f"{value:.3g}" for value in um_s)
        return f"<bearing run {self.scene.name}: radial {texts} um/s>"


def numbered(bearing: SolvedBearing, findings: MarchFindings | None = None) -> BearingRun:
    """Return a solved bearing with its numbers.

    Parameters
    ----------
    bearing : SolvedBearing
        Motion of the ring.
    findings : MarchFindings
        What the marches of its rough contacts say beside their tracks. Default: nothing.
    """
    numbers = bearing_numbers(bearing, findings or MarchFindings())
    return with_numbers(bearing, numbers)


def with_numbers(
    bearing: SolvedBearing, numbers: BearingNumbers, stored: StoredBearing | None = None
) -> BearingRun:
    """Return a solved bearing with numbers; what followed from it already is kept."""
    known = {field.name: getattr(bearing, field.name) for field in fields(SolvedBearing)}
    run = BearingRun(**known, numbers=numbers, stored=stored)
    made = {name: value for name, value in vars(bearing).items() if name not in vars(run)}
    vars(run).update(made)
    return run
