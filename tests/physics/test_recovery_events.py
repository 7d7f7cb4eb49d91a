"""Each recovery event is an unbroken fall of a loaded node's deflection.

Together the events are the released energy, on a whole track and on a cut one.
"""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise

import numpy as np
import pytest
from helpers import make_track, releases, roll, rough, step_energies

from rolling.contact import recovery
from rolling.contact.state import Window

STEPS = 60


def scene(**changes: float):
    return make_track(
        rough(50, 60, 1e-7), **{"load": 0.1, "hardness": 2.1e9, "tolerance": 1e-9} | changes
    )


def table_of(track, states, left_end: bool = False) -> recovery.EventTable:
    table = recovery.EventTable(track.heights.shape)
    for state, step in zip(states, step_energies(track, states, left_end), strict=False):
        table.add(state.position, step)
    return table


def by_node(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    order = np.lexsort((columns["first"], columns["node"][:, 1], columns["node"][:, 0]))
    return {name: column[order] for name, column in columns.items()}


@pytest.mark.law("Recovery events: their energies add up to the release.")
@pytest.mark.parametrize("left_end", [False, True])
def test_event_energies_sum_to_the_release(left_end: bool) -> None:
    """A few thousand terms in another order have the same sum to rounding, also over the seam."""
    track = scene()
    states = roll(track, 0, STEPS)
    columns = table_of(track, states, left_end).columns()
    assert columns["energy"].sum() == pytest.approx(
        releases(track, states, left_end).sum(), rel=1e-13
    )
    assert (columns["energy"] > 0).all()
    assert (columns["peak"] <= columns["energy"] * (1 + 1e-13)).all()
    assert (
        columns["peak"] * (columns["last"] - columns["first"]) >= columns["energy"] * (1 - 1e-13)
    ).all()


def test_table_grows_without_losing_an_event() -> None:
    """Energies still sum for more events than the first 1024 rows."""
    track = make_track(rough(120, 120, 2e-8), load=5.0, tolerance=1e-3)
    states = roll(track, 0, 40)
    table = table_of(track, states)
    assert table.count > 1024
    assert len(table.energy) > 1024
    assert table.columns()["energy"].sum() == pytest.approx(
        releases(track, states).sum(), rel=1e-13
    )


@pytest.mark.law("Recovery events: each is an unbroken fall of a loaded node's deflection.")
def test_events_are_unbroken_falls_of_loaded_nodes() -> None:
    """The events are the maximal runs of steps in which u falls under load.

    The node histories give these runs independently.
    """
    track = make_track(rough(50, 60, 1e-7), load=0.3, tolerance=1e-9)
    states = roll(track, 0, 49)
    runs = defaultdict(list)
    for k, step in enumerate(step_energies(track, states)):
        for i, j in np.argwhere(step.node_work > 0):
            runs[(step.window.row + i) % 50, (step.window.column + j) % 60].append(
                (k, step.node_work[i, j])
            )
    expected = []
    for node, falls in runs.items():
        begin = 0
        for n in range(1, len(falls) + 1):
            if n == len(falls) or falls[n][0] != falls[n - 1][0] + 1:
                piece = falls[begin:n]
                expected.append(
                    (
                        *node,
                        piece[0][0],
                        piece[-1][0] + 1,
                        sum(e for _, e in piece),
                        max(e for _, e in piece),
                    )
                )
                begin = n
    columns = by_node(table_of(track, states).columns())
    expected = np.array(sorted(expected))
    np.testing.assert_array_equal(
        np.column_stack([columns["node"], columns["first"], columns["last"]]), expected[:, :4]
    )
    np.testing.assert_allclose(
        np.column_stack([columns["energy"], columns["peak"]]), expected[:, 4:], rtol=1e-13
    )
    assert (np.diff(expected[:, 2:4], axis=1) > 1).any()  # some last longer than a step
    times = defaultdict(int)
    for i, j in columns["node"]:
        times[i, j] += 1
    assert max(times.values()) > 1  # and some nodes fall more than once


@pytest.mark.law("Recovery events: on a smooth sphere they are the trailing half of the contact.")
def test_smooth_sphere_events_are_the_trailing_half() -> None:
    """On a smooth plate each complete event lasts half a chord.

    A node falls once, from under the centre to the edge.
    """
    track = make_track(np.zeros((100, 60)), load=0.5, tolerance=1e-9)
    states = roll(track, 0, 40)
    columns = table_of(track, states).columns()
    nodes = [tuple(node) for node in columns["node"]]
    assert len(set(nodes)) == len(nodes)
    radius = states[0].loaded.rows / 2
    whole = (columns["first"] > 0) & (columns["last"] < 40)
    longest = (columns["last"] - columns["first"])[whole].max()
    assert abs(longest - radius) <= 1.5


@pytest.mark.law("Recovery events: a track that is solved in pieces has the events of the whole.")
@pytest.mark.parametrize("cuts", [(25,), (1, 2, 31), (10, 20, 30, 40, 50)])
def test_events_of_a_cut_track_are_those_of_the_whole(cuts: tuple[int, ...]) -> None:
    """Pieces have the same events, with energies to the solver's tolerance.

    They share the position at the cut, which each solves from a cold start. At a tolerance of
    1e-9 no node of this scene turns so gently that its sign is in doubt.
    """
    track = scene()
    whole = by_node(table_of(track, roll(track, 0, STEPS)).columns())
    edges = (0, *cuts, STEPS)
    pieces = [table_of(track, roll(track, a, b)).columns() for a, b in pairwise(edges)]
    joined = by_node(recovery.join_events(pieces))
    assert sum(len(piece["energy"]) for piece in pieces) > len(whole["energy"])  # something was cut
    for name in ("node", "first", "last"):
        np.testing.assert_array_equal(joined[name], whole[name])
    np.testing.assert_allclose(
        joined["energy"], whole["energy"], rtol=0, atol=1e-7 * whole["energy"].max()
    )
    np.testing.assert_allclose(
        joined["peak"], whole["peak"], rtol=0, atol=1e-7 * whole["peak"].max()
    )


def test_an_event_longer_than_a_piece_is_joined_through_it() -> None:
    """A fall of three steps in three pieces is one event again.

    An empty piece in between ends the event.
    """

    def piece(first: int, last: int, energy: float) -> dict[str, np.ndarray]:
        return {
            "node": np.array([[3, 4]], np.int32),
            "first": np.array([first]),
            "last": np.array([last]),
            "energy": np.array([energy]),
            "peak": np.array([energy]),
        }

    joined = recovery.join_events([piece(0, 1, 1.0), piece(1, 2, 3.0), piece(2, 3, 2.0)])
    assert {name: column.tolist() for name, column in joined.items()} == {
        "node": [[3, 4]],
        "first": [0],
        "last": [3],
        "energy": [6.0],
        "peak": [3.0],
    }
    nothing = {name: column[:0] for name, column in piece(0, 0, 0.0).items()}
    apart = recovery.join_events([nothing, piece(0, 1, 1.0), nothing, piece(2, 3, 2.0)])
    assert apart["energy"].tolist() == [1.0, 2.0]
    assert recovery.join_events([]) == {}


def test_a_pause_of_one_step_ends_an_event() -> None:
    """Node (2, 3) falls, falls, rests and falls: it has two events.

    Its neighbour, over the seam, falls in the third step alone.
    """
    table = recovery.EventTable((5, 4))
    for k, (own, neighbour) in enumerate([(1.0, 0.0), (2.0, -1.0), (0.0, 5.0), (4.0, 0.0)]):
        work = np.array([[own, neighbour]])
        table.add(
            k,
            recovery.StepEnergy(
                max(own, 0) + max(neighbour, 0), 0.0, 0.0, Window(7, 3, 1, 2), work
            ),
        )
    columns = by_node(table.columns())
    assert columns["node"].tolist() == [[2, 0], [2, 3], [2, 3]]
    assert columns["first"].tolist() == [2, 0, 3]
    assert columns["last"].tolist() == [3, 2, 4]
    assert columns["energy"].tolist() == [5.0, 3.0, 4.0]
    assert columns["peak"].tolist() == [5.0, 2.0, 4.0]
