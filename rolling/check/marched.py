"""Check of runs by the marches that they need: time, memory and disk, and the nodes of contacts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from acoustics.numbers import byte_size
from rolling.check import cost, forecast, refusals
from rolling.check.finding import Finding
from rolling.check.findings import Findings, smooth_contact_rules
from rolling.check.long_steps import refuse_long_steps
from rolling.check.memory_and_disk import disk, memory
from rolling.check.run_size import run_size
from rolling.numbers.doubt import Doubt
from rolling.scene.identity import contact_keys, digest
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene


def refuse_contacts(contacts: Sequence[Scene], workers: int, folder: Path | None) -> None:
    """Refuse contacts that cannot be marched here.

    Parameters
    ----------
    contacts : sequence of Scene
        Contacts without sweeps; equal ones are marched once.
    workers : int
        Number of processes; 0 means one per core.
    folder : Path or None
        Folder of the results; None if nothing is written.

    Raises
    ------
    SceneError
        A height file cannot be used, steps are too long, or memory or disk do not suffice.
    """
    alone = [*_by_identity(contacts).values()]
    refusals.refuse_large_files(alone)
    for contact in alone:
        refuse_long_steps(contact)
    sizes = [run_size(contact) for contact in alone]
    lacking = refusals.excess(sizes, workers or cost.cores(), folder) if sizes else []
    if lacking:
        raise SceneError([need.line for need in lacking])


def check_contacts(contacts_of_runs: Mapping[str, Sequence[Scene]]) -> Findings:
    """Judge runs by the contacts that they march.

    Parameters
    ----------
    contacts_of_runs : mapping of str to sequence of Scene
        Contacts without sweeps by the name of their run.

    Returns
    -------
    findings : Findings
        Time, memory and disk of each run, and doubts about nodes and hardness of its
        contacts.
    """
    rows: dict[str, list[Finding]] = {}
    doubts: dict[str, list[Doubt]] = {}
    every: dict[str, Scene] = {}
    for name, contacts in contacts_of_runs.items():
        alone = _by_identity(contacts)
        every |= alone
        judged = [*_rules([*alone.values()])]
        rows[name] = [row for row in judged if isinstance(row, Finding)]
        by_key = {doubt.key: doubt for doubt in judged if isinstance(doubt, Doubt)}
        doubts[name] = [*by_key.values()]
    scenes = [*every.values()]
    seconds = sum(map(forecast.march_seconds, scenes))
    seconds += forecast.beside_seconds(scenes, cost.cores())
    whole = f"{forecast.takes(seconds)}, with start, files and page"
    return Findings(rows, doubts, (("time of all marches", whole),), seconds=seconds)


def _by_identity(contacts: Sequence[Scene]) -> dict[str, Scene]:
    """Return contacts by their identities, equal ones once."""
    return {digest(contact_keys(contact)): contact for contact in contacts}


def _rules(contacts: Sequence[Scene]) -> Iterator[Finding | Doubt]:
    """Yield rows and doubts of a run from its contacts."""
    yield Finding("marches", "marches", str(len(contacts)))
    if not contacts:
        return
    seconds = sum(map(forecast.march_seconds, contacts))
    workers = cost.cores()
    sizes = [run_size(contact) for contact in contacts]
    yield Finding("expected_time", "time of the marches", cost.computing(seconds), seconds)
    yield Finding("memory", "memory", refusals.memory_text(memory(sizes, workers)))
    yield Finding("disk", "disk", f"about {byte_size(disk(sizes))}")
    yield from refusals.excess(sizes, workers, refusals.OUTPUTS)
    for contact in contacts:
        for doubt in smooth_contact_rules(contact):
            if isinstance(doubt, Doubt):
                yield doubt
