"""Marches that a run needs: contacts of a sphere with a surface, each along its whole track."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

from rolling.scene.scene import Scene


class March(NamedTuple):
    """A march that a run needs.

    Attributes
    ----------
    scene : Scene
        Contact, without a sweep.
    name : str
        What it is called where it fails; empty for the contact of the run itself.
    is_shared : bool
        Whether runs that need an equal contact share what is kept of its march. A march that gets
        more than its track, such as that of a run with dynamics, is of one run.
    is_first : bool
        Whether the first answer needs it.
    film : bool
        Whether it gets a slow motion.

    Examples
    --------
    >>> import rolling
    >>> march = rolling.March(rolling.read_scene("quickstart"), name="inner contact")
    >>> march.failure("the load is too large")
    'inner contact: the load is too large'
    """

    scene: Scene
    name: str = ""
    is_shared: bool = True
    is_first: bool = True
    film: bool = False

    def failure(self, reason: str) -> str:
        """Say why the march failed."""
        return f"{self.name}: {reason}" if self.name else reason


class MarchStore(ABC):
    """Place of the marches of some runs: in memory, in their folder, or in that of other runs.

    Attributes
    ----------
    is_lasting : bool
        Whether what is kept outlasts the command, so that the pieces of the march may go.
    """

    is_lasting = False

    def find(self, march: March, identity: str) -> Any | None:
        """Return what is kept of a whole march of a contact identity; None where it is lacking."""
        return None

    def begin(self, march: March, identity: str) -> Any | None:
        """Return the result of other runs with which a march begins; None for an empty one."""
        return None

    @abstractmethod
    def keep(self, march: March, identity: str, result: Any) -> Any:
        """Return what the run needs of a whole march, and write it where it is to last.

        Raises
        ------
        ContactError : the march makes no force law.
        """
