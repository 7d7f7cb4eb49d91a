"""Answer to the question which of some scenes is quieter, with its sentences, table and picture."""

from __future__ import annotations

import html
from dataclasses import dataclass
from typing import TYPE_CHECKING

from acoustics.traps import ignoring_underflow
from rolling.choice import choice_doubts, choice_sentences, choice_table
from rolling.choice.choice_numbers import ChoiceNumbers
from rolling.numbers.doubt import Doubt

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False)
class Choice(ChoiceNumbers):
    """Answer to the question which of some scenes is quieter.

    Attributes
    ----------
    contenders : list of Contender
        Candidates, the quietest first, each with `label` and `levels_db`, the levels of what a
        listener would hear of its specimens, dB(A); for a bearing those of its medium band.
    differences : list of Difference
        How much louder each candidate after the first is than the quietest: `db`, its standard
        `uncertainty_db`, the `sureness` of its sign, `parts_db`, where the ± comes from, and
        `left_out_db`, what it leaves out.
    by_quantity : list of dict of Difference
        The same of each quantity: the vibration of a ball; the bands low, medium and high of the
        ring of a bearing, and the housing where all scenes have one.
    quantities : list of HeardQuantity
        These quantities, each with `name`, `words` and `unit`.
    rms : dict of (candidates, specimens) arrays
        Root mean squares of all specimens by quantity: Pa, or um/s of a ring.
    audition : Audition
        How the scenes of the kind are compared.
    noun : str
        What the specimens are: surfaces, or places of the scan.
    limit : str
        Why no more pairs were heard although the ± is above the wanted one; empty if it is not.
    within_db : float, dB
        The wanted ±.
    folder : Path
        Folder of the choice; it is gone unless one was given.
    audible : tuple of HeardDifference
        Whether each difference is audible in the noise of the room.
    omitted : list of OmittedPair
        Pairs that are left out, because a contact has no solution: `number` of the specimen,
        `label` of the candidate, and `reason`. Each counts against the sureness.
    is_early : bool
        Whether the limit of time ended the choice before its rule did.
    command : str
        Command that repeats the answer; empty for a choice in Python.
    advice : LinearAdvice or None
        The values of the drawing that matter most for the loudest one; None until the choice ends.

    Examples
    --------
    >>> import rolling
    >>> pit = rolling.SurfaceFault(kind="pit", at_mm=(0.5, 0), size_um=80, depth_um=2)
    >>> smooth = rolling.Smooth(spacing_um=4, width_um=256, faults=[pit])
    >>> scene = rolling.read_scene("quickstart", ["rolling.load_n=1", "rolling.duration_s=0.01"])
    >>> choice = rolling.choose(scene.with_(surface=smooth), workers=1, progress=False)
    >>> choice.table().candidate.to_list()
    ['the scene without faults', 'the scene with faults']
    """

    @property
    def sentences(self) -> list[str]:
        """Who is quieter, by how much and how sure; where the difference lies; one doubt."""
        return choice_sentences.sentences(self)

    @property
    def methods(self) -> str:
        """Paragraph on methods that one may paste into a report, with all conditions."""
        return choice_sentences.methods(self)

    @property
    def doubts(self) -> list[Doubt]:
        """What limits the answer, and notes: what was assumed, and what the ± leaves out."""
        return choice_doubts.doubts(self)

    def table(self) -> pd.DataFrame:
        """Tabulate the candidates, the quietest first.

        Returns
        -------
        table : pandas.DataFrame
            A row for each candidate, and for each quantity where there are several: its mean over
            specimens, how much louder it is than the quietest, with its ± and where that comes
            from; of balls also the released power, dB(A).
        """
        return choice_table.frame(self)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw how much louder each candidate is than the quietest, by third octave, with ±.

        Of bearings, each specimen is a point in its band.

        Parameters
        ----------
        ax : Axes
            Axes of matplotlib. Default: new ones.

        Returns
        -------
        ax : Axes
        """
        from rolling.choice.choice_picture import draw
        from rolling.figures.picture import axes_of

        return draw(self, axes_of(ax))

    def __repr__(self) -> str:
        return "\n".join([*self.sentences, choice_table.lines(self)])

    def _repr_html_(self) -> str:
        """Write sentences and table for a notebook."""
        paragraphs = "".join(f"<p>{html.escape(text)}</p>" for text in self.sentences)
        return f"{paragraphs}<pre>{html.escape(choice_table.lines(self))}</pre>"
