"""What a run of any kind shows and plays by itself, in Python and in notebooks.

The bodies of its methods import rooms above, so that a run has the methods wherever it is made.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from acoustics.traps import ignoring_underflow

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes


@ignoring_underflow
class ShownRun:
    """Methods of a run that need its figures and its sounds."""

    def plot(self, name: str | None = None, ax: Axes | None = None) -> Axes:
        """Draw a figure of the run.

        Parameters
        ----------
        name : str
            Name of the figure, as `rolling plot` has them. Default: the first figure of its kind,
            which is third_octaves for a ball and spectrum for a bearing.
        ax : matplotlib.axes.Axes
            Axes to draw on. Default: new axes.

        Returns
        -------
        ax : matplotlib.axes.Axes

        Raises
        ------
        ValueError
            The run has no figure of this name; the message names those that it has.

        Examples
        --------
        >>> import rolling
        >>> ax = run.plot("surface")
        """
        from rolling.figures import catalogue

        return catalogue.draw(self, name, ax)

    def play(self) -> Any:
        """Return a player for a notebook; in a script, name a sound file and open a player for it.

        A ball is heard by its vibration, computed or estimated, and by the released power where
        nothing vibrates: for at least five seconds, in laps, or as the long record of a scene with
        `sound.listen_s`. A bearing is heard by its housing plate, or by the
        acceleration of its ring where it has none. The gain makes all runs equally loud, so levels
        are compared by their numbers. A run without files writes a temporary one. The system's
        player is opened on a terminal only, and the script goes on at once.

        Returns
        -------
        player : IPython.display.Audio, or None
        """
        from rolling.results import player

        return player.play(self)

    def save(self, folder: Path | str, report: bool = True) -> Path:
        """Write the run into a new folder, as `rolling.save_run` does, and return the folder.

        Parameters
        ----------
        folder : Path or str
            The folder to make.
        report : bool
            Write the report page as well. Default: true.

        Raises
        ------
        FolderError
            The folder holds files already, or is a file.
        """
        from rolling.interface import runs

        return runs.save_run(self, folder, report)
