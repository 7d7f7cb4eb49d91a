"""Findings of a scene before it is run: its cost, and whether its result can be believed.

`findings` judges one run, `check_scene` all runs of a scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from rolling.check import (
    cost,
    demand,
    finishing,
    height_files,
    long_steps,
    refusals,
    sampling,
    size,
    smooth_contact,
    validity,
    vibration,
)
from rolling.check.finding import Finding, clock, on_cores
from rolling.check.report import Findings, RunFindings
from rolling.scene.identity import Identity
from rolling.scene.scene import Scene
from rolling.scene.sweep import run_name
from rolling.terminal import progress

if TYPE_CHECKING:
    from rolling.check.probe import Probe


def check_scene(scene: Scene, solve: bool = True) -> Findings:
    """Judge all runs of a scene before anything is computed.

    Parameters
    ----------
    solve : bool
        If true, solve a few positions of each run, which tell more than closed forms. Default true.

    Raises
    ------
    SceneError
        A height file cannot be used, a package that the scene asks for is missing, or its steps are
        too long.
    """
    refusals.refuse_unavailable(scene)
    long_steps.refuse_long_steps(scene)
    runs = scene.runs()
    for run in runs:
        refusals.refuse_large_heights(run.scene)
    solved = _solved([run.scene for run in runs], solve)
    with progress.step("judging the numbers of the scene"):
        by_run = tuple(
            RunFindings(run_name(run.values) or scene.name, findings(run.scene, probe))
            for run, probe in zip(runs, solved, strict=True)
        )
    alone = _marched_alone([run.scene for run in runs])
    seconds = sum(
        finding.seconds
        for k, run in enumerate(by_run)
        for finding in run.findings
        if k in alone or finding.key == vibration.OWN_MARCH
    )
    time = _time_text(seconds, finishing.seconds([run.scene for run in runs], cost.cores()))
    if len(runs) == 1:
        return Findings((_with_time(by_run[0], time),))
    roughness = refusals.roughness_read_once()
    needed = demand.of_scenes([(run.scene, roughness(run.scene)) for run in runs], cost.cores())
    excess = refusals.excess(needed, refusals.OUTPUTS)
    return Findings(
        by_run,
        (
            ("expected time of all", f"{time}, {len(runs)} runs"),
            ("memory of all", refusals.amount_text(needed.memory)),
            ("disk of all", refusals.amount_text(needed.disk)),
        ),
        tuple(f"{key} of all: {fault}" for key, fault in excess.items()),
    )


def _marched_alone(scenes: Sequence[Scene]) -> set[int]:
    """Return the numbers of the runs that are marched; other runs share one of their marches."""
    if len(scenes) > demand.PAGE_RUNS:  # each run is a task of its own, which shares nothing
        return set(range(len(scenes)))
    first: dict[str, int] = {}
    for number, scene in enumerate(scenes):
        shared = not scene.numerics.error_estimate or scene.dynamics is not None
        first.setdefault(Identity.of(scene, None).text if shared else str(number), number)
    return set(first.values())


def _time_text(solving: float, after: float) -> str:
    """Write the expected time of a command, and the share of it that is not solving [s]."""
    return (
        f"about {clock(solving + after)} on {on_cores()},"
        f" {clock(after)} of it for start, sound and pictures"
    )


def _with_time(run: RunFindings, time: str) -> RunFindings:
    """Replace the time of solving a run alone by that of the whole command."""
    return RunFindings(
        run.name,
        [
            replace(finding, value=time) if finding.key == "expected_time" else finding
            for finding in run.findings
        ],
    )


def findings(scene: Scene, solved: Probe | None = None) -> list[Finding]:
    """Judge one run without regard to the sweep of its scene.

    Parameters
    ----------
    solved : Probe, optional
        Solved positions, whose numbers replace the numbers of the closed forms.

    Raises
    ------
    SceneError
        The height file cannot be used.
    """
    rq, slope = cost.roughness(scene)
    closed_forms = [
        *size.findings(scene, rq),
        *smooth_contact.findings(scene),
        *sampling.findings(scene),
        *height_files.findings(scene),
        *validity.findings(scene, slope),
        sampling.record(scene),
    ]
    return closed_forms if solved is None else _replaced(closed_forms, solved.findings(scene))


def _solved(scenes: Sequence[Scene], solve: bool) -> Sequence[Probe | None]:
    if not solve:
        return [None] * len(scenes)
    with progress.step("loading the solver"):
        from rolling.check import probe

    return probe.probes(scenes)


def _replaced(findings: Sequence[Finding], better: Sequence[Finding]) -> list[Finding]:
    """Replace findings by better findings with the same key, and append the others.

    The warnings of the replaced findings stay.
    """
    by_key = {finding.key: finding for finding in better}
    result: list[Finding] = []
    for finding in findings:
        instead = by_key.pop(finding.key, finding)
        result.append(replace(instead, warning=instead.warning or finding.warning))
    return [*result, *by_key.values()]
