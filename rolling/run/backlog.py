"""Tasks that wait for the processes of a pool, by the surface that they need."""

import math
from collections import Counter, defaultdict, deque
from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import Any


class Backlog:
    """Queues from which teams of processes take items, so that few of them make equal surfaces.

    A team keeps to a surface that it has. Where that needs no more, an idle team takes the first
    one that no team has, or else the one with most items per process of the teams that have it.

    items : iterable of pair. Surfaces, each with an item that needs it.
    """

    def __init__(self, items: Iterable[tuple[Hashable, Any]] = ()) -> None:
        self._queues: defaultdict[Hashable, deque[Any]] = defaultdict(deque)  # none is empty
        for surface, item in items:
            self._queues[surface].append(item)
        # The last surfaces of each team, at most one per process, and the processes of each surface
        self._had: defaultdict[Hashable, deque[Hashable]] = defaultdict(deque)
        self._processes: Counter[Hashable] = Counter()

    def __bool__(self) -> bool:
        return bool(self._queues)

    def put(self, surface: Hashable, items: Sequence[Any]) -> None:
        """Put items before the others of their surface."""
        if items:
            self._queues[surface].extendleft(reversed(items))

    def take(
        self, teams: Mapping[Hashable, int], in_hand: Mapping[Hashable, int], slots: int
    ) -> tuple[Hashable, Any] | None:
        """Take an item for a team that has room, the idlest first; return both, or None.

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
        room = [team for team, size in teams.items() if in_hand[team] < slots * size]
        for team in sorted(room, key=lambda team: in_hand[team] - teams[team]):
            had, least = self._had[team], 0 if in_hand[team] < teams[team] else 1
            chosen = next((own for own in had if self._per_process(own) > least), None)
            if chosen is None and not least:
                chosen = max(self._queues, key=self._per_process)
                had.append(chosen)
                self._processes[chosen] += teams[team]
                if len(had) > teams[team]:
                    self._processes[had.popleft()] -= teams[team]
            if chosen is not None:
                item = self._queues[chosen].popleft()
                if not self._queues[chosen]:
                    del self._queues[chosen]
                return team, item
        return None

    def _per_process(self, surface: Hashable) -> float:
        """Return the number of items per process that has a surface."""
        count, processes = len(self._queues.get(surface, ())), self._processes[surface]
        return count / processes if processes else math.inf
