"""What answers to questions on one scene share: conditions, methods, a picture and their files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from rolling.kinds.stated_conditions import conditions_of, with_conditions, write_answer_file
from rolling.numbers.conditions import Conditions
from rolling.results.notes import UNVALIDATED
from rolling.terminal import whole_files

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


class Advice(ABC):
    """Answer to a question on one scene: what would help, what stays below, which waves to lower.

    Attributes
    ----------
    name : str
        Name of the scene.
    folder : Path
        Folder of the specimens.
    scene : scene
        The scene; none where it is not known.
    """

    name: str
    folder: Path
    scene: Any

    @property
    @abstractmethod
    def sentences(self) -> list[str]:
        """The answer in words, and what to doubt."""

    @property
    @abstractmethod
    def found_by(self) -> list[str]:
        """Sentences on how the answer was found."""

    @abstractmethod
    def table(self) -> pd.DataFrame:
        """Tabulate the answer."""

    @abstractmethod
    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the answer on axes, new ones by default, and return them."""

    @property
    def conditions(self) -> Conditions:
        """Conditions of the scene; none where it is not known."""
        return conditions_of({self.name: self.scene})

    @property
    def methods(self) -> str:
        """Paragraph on methods that one may paste into a report, with all conditions."""
        return self.conditions.paragraph([*self.found_by, *self.sentences[:1], UNVALIDATED])

    def __repr__(self) -> str:
        return "\n".join(self.sentences)


Answer = TypeVar("Answer", bound=Advice)


def write_advice(
    result: Answer,
    stem: str,
    picture: Callable[[Answer], bytes] | None,
    page: Callable[[Answer], bytes],
) -> list[Path]:
    """Write table, answer, picture and page into the folder of an answer, and return the files.

    Parameters
    ----------
    result : Advice
        The answer.
    stem : str
        Name of the files without their endings.
    picture : function
        It draws the picture of the answer; None where there is nothing to draw.
    page : function
        It makes the page of the answer.
    """
    from rolling.figures.settings import left_out_if_it_fails
    from rolling.results.runs_table import csv_bytes

    path = result.folder / stem
    table = result.table()
    stated = with_conditions(table, result.conditions, [result.name] * len(table))
    written = [path.with_suffix(".csv"), path.with_suffix(".json")]
    whole_files.write_bytes(written[0], csv_bytes(stated))
    write_answer_file(written[1], result.sentences, result.conditions, result.methods)
    if picture is not None:
        with left_out_if_it_fails(stem):
            whole_files.write_bytes(path.with_suffix(".png"), picture(result))
            written.append(path.with_suffix(".png"))
    whole_files.write_bytes(path.with_suffix(".html"), page(result))
    return [*written, path.with_suffix(".html")]
