"""Marches of the contacts of bearings: in memory, or in a folder with pieces that outlast a kill.

Scenes of equal contact are marched once, over all runs of a sweep. The march of a contact is
stored in `contacts/IDENTITY.npz` of the run folder, and its pieces are removed then. Its scene
stands beside it, and `rolling run` takes it. A run may take equal marches from the folder of
another one, which is judged as the file of a stranger.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.contact.solver import ContactError
from rolling.marches.effort import ARRAY, PieceEffort
from rolling.marches.piece import contact_identity
from rolling.marches.result import Result
from rolling.results import result_file
from rolling.results.run_folder import RunFolder
from rolling.run import folder as folders
from rolling.run.executor import RunFiles, RunLoop, ended_by_signal
from rolling.run.pools import Pool, local_pool
from rolling.run.taken import OTHER_CONTACT, TakenMarches
from rolling.scene import file as scene_file
from rolling.scene.scene import Scene
from rolling.terminal import progress, shortage
from rolling.terminal.files import FolderError, make_below, write_bytes

CONTACTS = "contacts"  # folder of the marches, in the run folder
_IDENTITY = "identity"  # name of the contact identity in the file of a march
_MAX_BESIDE = 10_000  # bytes of the file of a march beside its approach
_MAX_HEADER = 1000  # letters of the description of an array


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
    start_from: Path | None = None,
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
    start_from : Path, optional
        Run folder of another bearing, whose equal marches are taken. What is taken is said.

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
    taken = None if start_from is None else TakenMarches(start_from)
    for stage in stages:
        fresh = {}
        for scene in stage:
            identity = contact_identity(scene)
            if identity in known:
                continue
            known.add(identity)
            stored = None
            if folder is not None:
                stored = _own_march(folder, scene, identity)
            if stored is None and taken is not None:
                stored = _taken_march(taken, scene, identity, folder)
            if stored is not None:
                marches[identity] = stored
            else:
                fresh[identity] = scene
        lacking.append(fresh)
    if taken is not None:
        for line in taken.lines():
            progress.line(line)
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
    for identity, scene in scenes.items():
        _write_scene(folder, scene, identity)
    files = RunFiles(
        runs=[RunFolder({}, scene, folder / CONTACTS) for scene in runs],
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
    for number, result, _ in loop.finished_runs(pool):
        identity = identities[number]
        if folder is None:
            assert result is not None  # it is not written into files
            marches[identity] = march_of(result)
            continue
        stored = _own_march(folder, scenes[identity], identity)
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
    _write_march(run.folder.parent, label, march_of(result))


def _write_march(folder: Path, identity: str, march: ContactMarch) -> None:
    """Write the file of a march, with its identity and a digest at its end."""
    stream = io.BytesIO()
    np.savez(
        stream,
        allow_pickle=False,
        approach_m=march.approach_m,
        numbers=np.array([march.max_pressure_pa, march.contact_area_m2]),
        effort=np.array(march.effort),
        identity=np.array(identity),
    )
    content = stream.getvalue()
    write_bytes(march_path(folder, identity), content + result_file.seal(content))


def _write_scene(folder: Path, scene: Scene, identity: str) -> None:
    """Write the scene of a march beside its file."""
    home = folder / CONTACTS
    make_below(folder, home)
    path = march_path(folder, identity).with_suffix(".yaml")
    text = scene_file.dump(folders.with_relative_paths(home, scene))
    write_bytes(path, text.encode())


def _own_march(folder: Path, scene: Scene, identity: str) -> ContactMarch | None:
    """Read the march of a contact in the own run folder; None for a missing or damaged file."""
    with suppress(FolderError):
        return read_march(folder, scene, identity)
    return None


def _taken_march(
    taken: TakenMarches, scene: Scene, identity: str, folder: Path | None
) -> ContactMarch | None:
    """Take a march of another run into the own run folder, if there is one that is sound."""
    name = f"{scene.name} at {scene.load:g} N"
    if not march_path(taken.folder, identity).exists():
        taken.leave(name, OTHER_CONTACT)
        return None
    try:
        march = read_march(taken.folder, scene, identity)
    except FolderError as error:
        taken.leave(name, str(error))
        return None
    march = replace(march, effort=PieceEffort(0.0, 0.0, 0.0))  # this run did not march it
    if folder is not None:
        _write_scene(folder, scene, identity)
        _write_march(folder, identity, march)
    taken.take(name)
    return march


def read_march(folder: Path, scene: Scene, identity: str) -> ContactMarch:
    """Read the march of a contact from a run folder that a stranger may have made.

    Raises
    ------
    FolderError : the file is missing or damaged, or holds another march.
    """
    path = march_path(folder, identity)
    steps = scene.track.solved_steps
    content = result_file.sealed_content(path, 8 * steps + _MAX_BESIDE)
    expected = {
        "approach_m": ((steps,), np.dtype(np.float64)),
        "numbers": ((2,), np.dtype(np.float64)),
        ARRAY: ((3,), np.dtype(np.float64)),
        _IDENTITY: ((), np.array(identity).dtype),
    }
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as stored:
            _refuse_other_arrays(stored, expected)
            arrays = {name: stored[name] for name in expected}
        if str(arrays.pop(_IDENTITY)) != identity:
            raise ValueError("the march of another contact")
        if not all(np.all(np.isfinite(values)) for values in arrays.values()):
            raise ValueError("values that are no finite numbers")
    except Exception as error:  # numpy raises errors of any kind on hostile files
        text = " ".join(str(error).split()) or type(error).__name__
        raise FolderError(f"{path}: no march of this contact ({text})") from error
    pressure, area = arrays["numbers"].tolist()
    return ContactMarch(
        approach_m=arrays["approach_m"],
        max_pressure_pa=pressure,
        contact_area_m2=area,
        effort=PieceEffort(*arrays[ARRAY].tolist()),
    )


def _refuse_other_arrays(
    stored: Any, expected: Mapping[str, tuple[tuple[int, ...], np.dtype[Any]]]
) -> None:
    """Refuse a file whose arrays have other names, shapes or types, before their values are read.

    Raise ValueError with the first fault.
    """
    if sorted(stored.files) != sorted(expected):
        raise ValueError(f"arrays {', '.join(sorted(stored.files)[:9])}")
    for member in stored.zip.infolist():
        if member.compress_type:
            raise ValueError(f"{member.filename}: compressed")
        name = member.filename.removesuffix(".npy")
        with stored.zip.open(member) as stream:
            np.lib.format.read_magic(stream)
            shape, _, dtype = np.lib.format.read_array_header_1_0(stream, _MAX_HEADER)
        if (shape, dtype) != expected[name]:
            raise ValueError(f"{name}: {dtype} of the shape {shape}")
