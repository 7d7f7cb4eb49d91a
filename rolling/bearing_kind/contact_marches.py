"""Marches of some contacts of bearings alone: in memory, or in a folder that keeps their pieces."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from rolling.contact.solver import ContactError
from rolling.kinds.needed_marches import March
from rolling.kinds.run_folder import RunFolder
from rolling.marches.piece import contact_identity
from rolling.run.executor import RunFiles, RunLoop, ended_by_signal
from rolling.run.march_files import ContactStore, Marches
from rolling.run.pools import local_pool
from rolling.scene.scene import Scene
from rolling.terminal import progress, shortage


def march_contacts(
    contacts: Sequence[Scene],
    *,
    name: str,
    folder: Path | None = None,
    workers: int = 0,
    shown: bool | None = None,
    homes: Sequence[Path] = (),
) -> Marches:
    """March contacts, equal ones once, and return all marches by contact identity.

    Parameters
    ----------
    contacts : sequence of Scene
        Contacts, without sweeps.
    name : str
        Name beside the progress.
    folder : Path, optional
        Run folder, whose marches and pieces are taken and kept. Default: all is kept in memory.
    workers : int
        Number of processes; 0 means one per core. Default 0.
    shown : bool, optional
        Whether the progress is shown. Default: where somebody looks.
    homes : sequence of Path
        Run folders of other bearings, whose equal marches are taken. Default: none.

    Raises
    ------
    ContactError
        A contact has no solution.
    OSError, KeyboardInterrupt
        A disk is full, or the work was stopped; finished pieces are kept.
    """
    marches = [march_of_contact(scene) for scene in contacts]
    store = ContactStore(folder, homes)
    files = None
    if folder is not None:
        files = RunFiles(
            runs=[RunFolder({}, march.scene, folder) for march in marches],
            labels=[march.name for march in marches],
            folder=folder,
            finish=None,
        )
    with ExitStack() as stack:
        stack.enter_context(shortage.as_memory_error())
        bar = stack.enter_context(progress.Bar(0.0, name, shown))
        loop = RunLoop([[march] for march in marches], store, bar, files)
        pool = stack.enter_context(local_pool(workers, contacts))
        stack.enter_context(ended_by_signal())
        by_number = {number: marched for number, (marched,), _ in loop.finished_runs(pool)}
    if loop.failures:
        raise ContactError(loop.failures[min(loop.failures)])
    return {contact_identity(contacts[number]): march for number, march in by_number.items()}


def march_of_contact(scene: Scene, is_first: bool = True) -> March:
    """Return the march of a contact of a bearing, which a first answer needs or not."""
    return March(scene, name=f"{scene.name}, {scene.load:g} N", is_first=is_first)
