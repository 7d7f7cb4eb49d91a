"""Marches that a run takes from the folder of another run, and those that it does not take."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rolling.run import folder as folders

OTHER_CONTACT = "no finished march there has an equal contact"
MAX_NAMED = 4


@dataclass
class TakenMarches:
    """Marches of a stored run that another run takes.

    folder : Path. The folder of the stored run.
    taken : list of str. Names of the marches that are taken.
    left : dict. Names of the marches that are not taken, by the reason.
    """

    folder: Path
    taken: list[str] = field(default_factory=list)
    left: defaultdict[str, list[str]] = field(default_factory=lambda: defaultdict(list))

    def take(self, name: str) -> None:
        """Note that a march is taken."""
        self.taken.append(name)

    def leave(self, name: str, reason: str) -> None:
        """Note the reason why a march is not taken."""
        self.left[reason].append(name)

    def lines(self) -> Iterator[str]:
        """Yield what is taken, and what is not, each with its reason."""
        program = folders.made_by(self.folder)
        if self.taken and program != folders.this_program():
            yield f"{self.folder}: marched by {program}, heard by {folders.this_program()}"
        if self.taken:
            yield f"{self.folder}: {_marches(self.taken)} taken: {_named(self.taken)}"
        for reason, names in self.left.items():
            yield f"{self.folder}: {_marches(names)} not taken: {_named(names)}: {reason}"


def _marches(names: Sequence[str]) -> str:
    """Return the number of marches with its verb."""
    return "1 march is" if len(names) == 1 else f"{len(names)} marches are"


def _named(names: Sequence[str]) -> str:
    """Name the first marches."""
    named = ", ".join(name or "the march of the run" for name in names[:MAX_NAMED])
    more = len(names) - MAX_NAMED
    return f"{named} and {more} more" if more > 0 else named
