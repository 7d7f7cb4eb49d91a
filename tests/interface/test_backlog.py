"""Few processes make equal surfaces, and none of them stands idle."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Hashable
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import pytest
from commands import SWEEP, words_of

from rolling import cli
from rolling.in_si import scene_surface
from rolling.run.backlog import Backlog
from rolling.run.pools import LocalPool, Task
from rolling.scene.scene import Scene

SEEDS = 4
WORKERS = 2


def noted(folder: Path, function: Callable[..., Any], *arguments: Any) -> Any:
    """Do a task in a worker, and put a file into a folder whenever that makes a surface."""
    make = scene_surface._make

    def noting(scene: Scene) -> Any:
        tempfile.mkstemp(dir=folder)
        return make(scene)

    with mock.patch.object(scene_surface, "_make", noting):
        return function(*arguments)


@pytest.mark.slow
def test_two_workers_make_few_surfaces_of_a_sweep_of_seeds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each surface is made once, and once more by each worker that helps with the last run."""
    scene = tmp_path / "scene.yaml"
    made = tmp_path / "made"
    submit = LocalPool.submit
    made.mkdir()
    scene.write_text(SWEEP.replace("rolling.load_n: [1, 2]", "surface.seed: [1, 2, 3, 4]"))

    def noting(pool: LocalPool, task: Task, *team: Hashable) -> Any:
        arguments = (made, task.function, *task.arguments)
        return submit(pool, replace(task, function=noted, arguments=arguments), *team)

    monkeypatch.setattr(LocalPool, "submit", noting)
    assert cli.main(words_of(scene, tmp_path / "out", "--workers", str(WORKERS))) == 0
    assert SEEDS <= len([*made.iterdir()]) <= SEEDS + WORKERS - 1


def filled(**items: int) -> Backlog:
    backlog = Backlog()
    for key in items:
        for number in range(items[key]):
            backlog.put_last(key, f"{key}{number}")
    return backlog


def test_an_idle_team_prefers_its_own_surface_then_a_free_one_then_the_longest_queue() -> None:
    backlog = filled(a=2, b=4, c=9)
    teams = {1: 1, 2: 1}
    none = Counter[Hashable]()
    assert backlog.take(teams, none, 1) == (1, "a0")
    assert backlog.take(teams, Counter({1: 1}), 1) == (2, "b0")
    assert backlog.take(teams, Counter({1: 1, 2: 1}), 1) is None
    assert backlog.take(teams, Counter({2: 1}), 1) == (1, "a1")
    assert backlog.take(teams, Counter({2: 1}), 1) == (1, "c0")
    backlog.put("a", ["a2"])
    backlog.put("d", ["d0", "d1"])
    assert [backlog.take({3: 1}, none, 1) for _ in range(3)] == [(3, "a2"), (3, "d0"), (3, "d1")]
    assert backlog.take({3: 1}, none, 1) == (3, "c1")
    assert backlog.take({2: 1}, none, 1) == (2, "b1") and backlog


def test_a_task_waits_in_hand_only_where_others_are_left_for_idle_processes() -> None:
    backlog = filled(a=3)
    busy = Counter[Hashable]({1: 1})
    assert backlog.take({1: 1}, Counter(), 2) == (1, "a0")
    assert backlog.take({1: 1}, busy, 2) == (1, "a1")
    assert backlog.take({1: 1}, busy, 2) is None
    assert backlog.take({1: 1, 2: 1}, busy, 2) == (2, "a2")
    assert backlog.take({1: 1}, Counter(), 2) is None and not backlog


@pytest.mark.parametrize(("workers", "teams"), [(7, 3), (64, 24), (2, 2), (5, 1)])
def test_teams_have_all_workers(workers: int, teams: int) -> None:
    sizes = LocalPool(workers, teams).teams.values()
    assert sum(sizes) == workers and len(sizes) == teams and max(sizes) - min(sizes) <= 1
