"""Findings of a scene before it is run: its cost, and whether its result can be believed.

`findings` judges one run, `check_scene` all runs of a scene.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, overload

from rolling.check import (
    cost,
    demand,
    height_files,
    long_steps,
    refusals,
    report,
    sampling,
    size,
    smooth_contact,
    validity,
)
from rolling.check.finding import Finding, clock, on_cores
from rolling.scene.run_names import run_name
from rolling.scene.scene import Scene

if TYPE_CHECKING:
    from rolling.check.probe import Probe


class RunFindings(NamedTuple):
    """Findings of one run and its name: the swept values, or the name of the scene."""

    name: str
    findings: list[Finding]


@dataclass(frozen=True)
class Findings(Sequence[Finding]):
    """Findings of all runs of a scene, one run after the other; printed, they are a table.

    Attributes
    ----------
    runs : tuple of RunFindings
        Findings by run.
    of_all : tuple of (str, str)
        Time, memory and disk of all runs together; empty for a single run.
    excess : tuple of str
        Warnings that all runs together need too much memory or disk.
    """

    runs: tuple[RunFindings, ...]
    of_all: tuple[tuple[str, str], ...] = ()
    excess: tuple[str, ...] = ()

    @property
    def warnings(self) -> list[str]:
        """Warnings in words, each once; empty where nothing is doubtful."""
        return [*self.excess, *report.warnings(self)]

    def __len__(self) -> int:
        return sum(len(run.findings) for run in self.runs)

    def __iter__(self) -> Iterator[Finding]:
        return (finding for run in self.runs for finding in run.findings)

    @overload
    def __getitem__(self, index: int) -> Finding: ...
    @overload
    def __getitem__(self, index: slice) -> list[Finding]: ...
    def __getitem__(self, index: int | slice) -> Finding | list[Finding]:
        return list(self)[index]

    def __str__(self) -> str:
        return report.text(self)

    def _repr_html_(self) -> str:
        return report.html(self)


def check_scene(scene: Scene, solve: bool = True) -> Findings:
    """Judge all runs of a scene before anything is computed.

    Parameters
    ----------
    solve : bool
        Solve a few positions of each run, which tells more than closed forms. Default true.

    Raises
    ------
    SceneError
        A height file cannot be used, a package that the scene asks for is missing, or its steps are too long.
    """
    refusals.refuse_unavailable(scene)
    long_steps.refuse_long_steps(scene)
    runs = scene.runs()
    for run in runs:
        refusals.refuse_large_heights(run.scene)
    solved = _solved([run.scene for run in runs], solve)
    by_run = tuple(
        RunFindings(run_name(run.values) or scene.name, findings(run.scene, probe))
        for run, probe in zip(runs, solved, strict=True)
    )
    if len(runs) == 1:
        return Findings(by_run)
    seconds = sum(finding.seconds for run in by_run for finding in run.findings)
    roughness = refusals.roughness_read_once()
    needed = demand.of_scenes([(run.scene, roughness(run.scene)) for run in runs], cost.cores())
    excess = refusals.excess(needed, refusals.OUTPUTS)
    return Findings(
        by_run,
        (
            ("expected time of all", f"about {clock(seconds)} on {on_cores()}, {len(runs)} runs"),
            ("memory of all", refusals.amount_text(needed.memory)),
            ("disk of all", refusals.amount_text(needed.disk)),
        ),
        tuple(f"{key} of all: {fault}" for key, fault in excess.items()),
    )


def findings(scene: Scene, solved: Probe | None = None) -> list[Finding]:
    """Judge one run; the sweep of the scene is not looked at.

    Parameters
    ----------
    solved : Probe, optional
        Solved positions, whose numbers replace those of the closed forms.

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
    from rolling.check import probe  # the solver is slow to import

    return probe.probes(scenes)


def _replaced(findings: Sequence[Finding], better: Sequence[Finding]) -> list[Finding]:
    """Replace findings by better ones with the same key, whose warnings stay, and append the others."""
    by_key = {finding.key: finding for finding in better}
    result: list[Finding] = []
    for finding in findings:
        instead = by_key.pop(finding.key, finding)
        result.append(replace(instead, warning=instead.warning or finding.warning))
    return [*result, *by_key.values()]
