"""Tasks that wait for the processes of a pool, by the surface that they need.

A process makes each surface that it meets. In a sweep of seeds, 8 processes that kept to surfaces
took 132 s of processor time, and 147 s where each process took the next task. The difference grows
with the number of processes (`tests/benchmarks/core_study.py`).
"""

import math
from collections import Counter, defaultdict, deque
from collections.abc import Hashable, Mapping, Sequence
from typing import Any


class Backlog:
    """Queues from which teams of processes take items, so that few of them make equal surfaces.

    A team keeps to a surface that it has. Where that needs no more, an idle team takes the first
    one that no team has, or else the one with most items per process of the teams that have it.

    """

    def __init__(self) -> None:
        self._queues: defaultdict[Hashable, deque[Any]] = defaultdict(deque)  # none is empty
        # The last surfaces of each team, at most one per process, and the processes of each surface
        self._surfaces_of: defaultdict[Hashable, deque[Hashable]] = defaultdict(deque)
        self._processes: Counter[Hashable] = Counter()

    def __bool__(self) -> bool:
        """Return whether an item is left."""
        return bool(self._queues)

    def put(self, surface: Hashable, items: Sequence[Any]) -> None:
        """Put items before the others of their surface."""
        if items:
            self._queues[surface].extendleft(reversed(items))

    def put_last(self, surface: Hashable, item: Any) -> None:
        """Put an item behind the others of its surface."""
        self._queues[surface].append(item)

    def take(
        self, teams: Mapping[Hashable, int], in_hand: Mapping[Hashable, int], slots: int
    ) -> tuple[Hashable, Any] | None:
        """Take an item for a team with a free slot, the idlest first; return both, or None.

        An item that would have to wait for a process is taken only if more are left than processes
        share its surface.

        Parameters
        ----------
        teams : mapping. Number of processes of each team.
        in_hand : mapping. Number of tasks that each team has.
        slots : int. Number of tasks per process that a team may have.
        """
        if not self._queues:
            return None
        with_slot = [team for team, size in teams.items() if in_hand[team] < slots * size]
        for team in sorted(with_slot, key=lambda team: in_hand[team] - teams[team]):
            is_idle = in_hand[team] < teams[team]
            surface = self._own_surface(team, least_items=0 if is_idle else 1)
            if surface is None and is_idle:
                surface = self._new_surface(team, teams[team])
            if surface is not None:
                return team, self._next_item(surface)
        return None

    def _own_surface(self, team: Hashable, least_items: int) -> Hashable | None:
        """Return a surface of a team with more items per process than some number, or None."""
        for surface in self._surfaces_of[team]:
            if self._items_per_process(surface) > least_items:
                return surface
        return None

    def _new_surface(self, team: Hashable, size: int) -> Hashable:
        """Give the surface with most items per process to a team of so many processes."""
        surface = max(self._queues, key=self._items_per_process)
        own = self._surfaces_of[team]
        own.append(surface)
        self._processes[surface] += size
        if len(own) > size:
            self._processes[own.popleft()] -= size
        return surface

    def _next_item(self, surface: Hashable) -> Any:
        """Take the first item of a surface."""
        item = self._queues[surface].popleft()
        if not self._queues[surface]:
            del self._queues[surface]
        return item

    def _items_per_process(self, surface: Hashable) -> float:
        """Return the number of items per process that has a surface; infinity where none has it."""
        items = len(self._queues.get(surface, ()))
        processes = self._processes[surface]
        if processes == 0:
            return math.inf
        return items / processes
