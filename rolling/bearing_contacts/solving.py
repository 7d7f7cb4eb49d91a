"""Marches of the contacts of bearings: in memory, or in a folder with pieces that outlast a kill.

Scenes of equal contact are marched once, over all runs of a sweep. The march of a contact is
stored in `contacts/IDENTITY.npz` of the run folder, and its pieces are removed then. Its scene
stands beside it, and `rolling run` takes it.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.contact.solver import ContactError
from rolling.marches.effort import ARRAY, PieceEffort
from rolling.marches.piece import contact_identity
from rolling.marches.result import Result
from rolling.results.run_folder import RunFolder
from rolling.run import folder as folders
from rolling.run.executor import RunFiles, RunLoop, ended_by_signal
from rolling.run.pools import Pool, local_pool
from rolling.run.worker import read_piece
from rolling.scene import file as scene_file
from rolling.scene.scene import Scene
from rolling.terminal import progress, shortage
from rolling.terminal.files import make_below, write_bytes

CONTACTS = "contacts"  # folder of the marches, in the run folder
# Arrays of the file of a march; the approach has as many values as the track has steps.
_SHAPES: dict[str, tuple[int | None, ...]] = {"approach_m": (None,), "numbers": (2,), ARRAY: (3,)}


@dataclass(frozen=True)
class ContactMarch:
    """March of a contact along its closed track.

    approach_m : (steps,) array, m. Approach at each position.
    max_pressure_pa : float, Pa. Maximum pressure along the track.
    contact_area_m2 : float, m2. Mean contact area.
    effort : PieceEffort, s. Processor times; zeros for a march that was taken from another run.
    """

    __repr__ = short_repr

    approach_m: Array
    max_pressure_pa: float
    contact_area_m2: float
    effort: PieceEffort


Marches = Mapping[str, ContactMarch]  # by contact identity


def solved_stages(
    stages: Sequence[Sequence[Scene]],
    *,
    name: str,
    folder: Path | None = None,
    workers: int = 0,
    shown: bool | None = None,
) -> Iterator[Marches]:
    """March the contacts of each stage, and yield all marches so far after each of them.

    Parameters
    ----------
    stages : sequence of sequence of Scene
        Scenes of contacts, the most urgent first.
    name : str
        Name beside the progress.
    folder : Path, optional
        Run folder, whose marches and pieces are taken and kept. Default: all is kept in memory.
    workers : int
        Number of processes; 0 means one per core. Default 0.
    shown : bool, optional
        Whether the progress is shown. Default: where somebody looks.

    Yields
    ------
    dict
        Marches by contact identity.

    Raises
    ------
    ContactError
        A contact has no solution.
    OSError, KeyboardInterrupt
        A disk is full, or the work was stopped; finished pieces are kept.
    """
    marches: dict[str, ContactMarch] = {}
    lacking: list[dict[str, Scene]] = []  # of each stage
    known: set[str] = set()
    for stage in stages:
        fresh = {}
        for scene in stage:
            identity = contact_identity(scene)
            if identity in known:
                continue
            known.add(identity)
            stored = None if folder is None else _read_march(folder, identity)
            if stored is not None:
                marches[identity] = stored
            else:
                fresh[identity] = scene
        lacking.append(fresh)
    scenes = [scene for stage in lacking for scene in stage.values()]
    if not scenes:
        for _ in stages:
            yield dict(marches)
        return
    with ExitStack() as stack:
        stack.enter_context(shortage.as_memory_error())
        bar = stack.enter_context(progress.Bar(0.0, name, shown))
        pool = stack.enter_context(local_pool(workers, scenes))
        stack.enter_context(ended_by_signal())
        # All loops begin before the first is run, so that the progress knows the time of all.
        loops = [_contact_loop(contacts, bar, folder) for contacts in lacking]
        for contacts, loop in zip(lacking, loops, strict=True):
            marches |= _solve(contacts, loop, pool, folder)
            yield dict(marches)


def _contact_loop(scenes: Mapping[str, Scene], bar: progress.Bar, folder: Path | None) -> RunLoop:
    """Return the loop that marches contacts by their identities."""
    runs = list(scenes.values())
    if folder is None:
        return RunLoop(runs, bar)
    home = folder / CONTACTS
    make_below(folder, home)
    for identity, scene in scenes.items():
        path = march_path(folder, identity).with_suffix(".yaml")
        text = scene_file.dump(folders.with_relative_paths(home, scene))
        write_bytes(path, text.encode())
    files = RunFiles(
        runs=[RunFolder({}, scene, home) for scene in runs],
        labels=list(scenes),
        pieces=folder / folders.PIECES,
        stored={},
        film=False,
        finish=store_march,
    )
    return RunLoop(runs, bar, files)


def _solve(
    scenes: Mapping[str, Scene], loop: RunLoop, pool: Pool, folder: Path | None
) -> dict[str, ContactMarch]:
    """March contacts by their identities; raise ContactError where one has no solution."""
    identities = list(scenes)
    marches = {}
    for number, result in loop.finished_runs(pool):
        identity = identities[number]
        if folder is None:
            assert result is not None  # it is not written into files
            marches[identity] = march_of(result)
            continue
        stored = _read_march(folder, identity)
        if stored is None:
            raise OSError(f"{march_path(folder, identity)}: it was removed or changed")
        marches[identity] = stored
        folders.drop_pieces(folder, identity)
    if loop.failures:
        number = min(loop.failures)
        scene = scenes[identities[number]]
        raise ContactError(f"{scene.name}, {scene.load:g} N: {loop.failures[number]}")
    return marches


def march_of(result: Result) -> ContactMarch:
    """Return the march of a contact from its complete result."""
    return ContactMarch(
        approach_m=result.series["approach"][: result.solved_steps],
        max_pressure_pa=float(result.series["max_pressure"].max()),
        contact_area_m2=float(result.series["contact_area"].mean()),
        effort=result.effort.of_march(),
    )


# ---- files


def march_path(folder: Path, identity: str) -> Path:
    """Return the file of a march in a run folder."""
    return folder / CONTACTS / f"{identity[:32]}.npz"


def store_march(run: RunFolder, label: str, result: Result) -> None:
    """Write the file of a march in a process of the pool; the label is its contact identity."""
    march = march_of(result)
    content = io.BytesIO()
    np.savez(
        content,
        allow_pickle=False,
        approach_m=march.approach_m,
        numbers=np.array([march.max_pressure_pa, march.contact_area_m2]),
        effort=np.array(march.effort),
    )
    write_bytes(march_path(run.folder.parent, label), content.getvalue())


def _read_march(folder: Path, identity: str) -> ContactMarch | None:
    """Read the file of a march; return None for a missing or damaged file."""
    arrays = read_piece(march_path(folder, identity))
    if arrays is None or set(arrays) != _SHAPES.keys():
        return None
    for name, shape in _SHAPES.items():
        values = arrays[name]
        is_sound = values.ndim == len(shape) and values.dtype == np.float64
        if not is_sound or (shape != (None,) and values.shape != shape):
            return None
        if not np.all(np.isfinite(values)):
            return None
    pressure, area = arrays["numbers"].tolist()
    return ContactMarch(
        approach_m=arrays["approach_m"],
        max_pressure_pa=pressure,
        contact_area_m2=area,
        effort=PieceEffort(*arrays[ARRAY].tolist()),
    )
