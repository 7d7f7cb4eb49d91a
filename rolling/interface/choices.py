"""Choices for Python: which is quieter, what would help, and which value or waves are enough."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acoustics.arrays import instance
from acoustics.traps import ignoring_underflow
from rolling.scene.swept import SweptScene
from rolling.terminal import defaults
from rolling.terminal import progress as terminal

if TYPE_CHECKING:
    from rolling.choice.choice import Choice
    from rolling.choice.design import Design
    from rolling.choice.limit import Limit
    from rolling.choice.sensitivity import Sensitivities


@ignoring_underflow
def choose(
    scenes: SweptScene | Sequence[SweptScene],
    within_db: float = defaults.WITHIN_DB,
    minutes: float = defaults.CHOICE_MINUTES,
    folder: Path | str | None = None,
    workers: int = 0,
    progress: bool | None = None,
    pairs: int | None = None,
) -> Choice:
    """Choose the quietest of some scenes of one kind, and say by how much and how sure that is.

    All scenes are heard on the same random surfaces, or at several places of their scans, and each
    difference has its scatter over these pairs as a ±. Pairs are added until it is the wanted one,
    in batches that are fixed beforehand. A pair whose contact has no solution is left out. Balls
    are chosen by the level of their vibration, bearings by the three bands of ISO 15242.

    Parameters
    ----------
    scenes : Scene, BearingScene or sequence of them
        The candidates, of one kind. One scene with a sweep has a candidate for each run, one with
        single faults is compared with itself without them.
    within_db : float, dB
        Wanted standard uncertainty of the differences. Default: 1.
    minutes : float
        Time after which no more pairs begin; four are always heard. Default: 10.
    folder : Path or str
        Folder that keeps the runs of all specimens; a choice that was interrupted goes on there.
        Default: none, and only the numbers are kept.
    workers, progress : int, bool
        As in `simulate`.
    pairs : int
        Number of pairs, from 2 to 60, whatever the ± and the time. The same number gives the same
        answer. Default: as many as the wanted ± needs.

    Returns
    -------
    choice : Choice
        Differences, of bearings by band, sentences, table and plot.

    Raises
    ------
    SceneError
        The scenes are not comparable, one of them cannot run, or so many pairs are not there.
    FolderError
        The folder holds something else.
    ContactError
        More than one in ten pairs have no solution, or half or more of fewer than ten.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> words = ["sphere.radius_mm=1", "rolling.load_n=0.2", "rolling.duration_s=0.003"]
    >>> words += ["sweep.surface.roughness_ra_um=[0.05, 0.2]"]
    >>> scene = rolling.read_scene("quickstart", words)
    >>> choice = rolling.choose(scene, pairs=2, workers=1, progress=False)
    >>> choice.contenders[0].label, choice.differences[0].pairs
    ('Ra 0.05 µm', 2)

    >>> words = ["bearing.surfaces.balls={kind: smooth, waviness: {4: 0.02}}"]
    >>> words += ["bearing.surfaces.inner=", "bearing.surfaces.outer=", "sound.duration_s=0.1"]
    >>> scene = rolling.read_scene("bearing-6204", words)
    >>> twice = scene.with_({"name": "twice", "bearing.surfaces.balls.waviness": {4: 0.04}})
    >>> choice = rolling.choose([scene, twice], workers=1, progress=False)
    >>> round(choice.differences[0].db)
    6

    References
    ----------
    C. Stein, Annals of Mathematical Statistics 16, 1945, 243-258, for the number of pairs.
    """
    from rolling.choice.choose_command import write_answer
    from rolling.choice.choosing import choose_scenes
    from rolling.run.budget import Budget

    listed = _listed(scenes)
    budget = Budget(within_db=within_db, minutes=minutes, pairs=pairs)
    with _kept_in(folder, progress) as kept:
        keep = None if folder is None else write_answer
        return choose_scenes(listed, kept, budget, workers, keep)


@ignoring_underflow
def sensitivities(
    scene: SweptScene,
    keys: Sequence[str] | None = None,
    within_db: float = defaults.IMPROVED_WITHIN_DB,
    minutes: float = defaults.CHOICE_MINUTES,
    folder: Path | str | None = None,
    workers: int = 0,
    progress: bool | None = None,
    pairs: int | None = None,
    quantity: str | None = None,
) -> Sensitivities:
    """Find how much louder a scene becomes when a value of its drawing is a little larger.

    Every value is changed by a tenth, a ball by a grade, and a skewness by 0.1. The scene and the
    changed scene are heard on the same specimens, at least six. Where a larger value is not
    allowed, the value is divided by 1.1. Of balls, the linear chain gives every change a second
    time.

    Parameters
    ----------
    scene : Scene or BearingScene
        A scene without a sweep.
    keys : sequence of str
        Keys of the values. Default: all that stand on a drawing and that the scene has.
    within_db : float, dB
        Wanted standard uncertainty of every change. Default: 0.1.
    minutes : float
        Time after which no more specimens begin; the first six are always heard. Default: 10.
    folder : Path or str
        Folder that keeps the specimens, so that the same call goes on. Default: none, and only the
        numbers are kept.
    workers, progress : int, bool
        As in `simulate`.
    pairs : int
        Number of specimens, from 2 to 60, whatever the ± and the time. Default: as many as the
        wanted ± needs.
    quantity : str
        The quantity whose level changes: low, medium, high or housing of a bearing. Default:
        medium; the vibration of a ball.

    Returns
    -------
    sensitivities : Sensitivities
        Changes of the level, the largest first, with `table()`, `plot(ax)` and `sentences`.

    Raises
    ------
    SceneError
        The scene sweeps, cannot run, makes no sound, or has no value of a key.
    FolderError
        The folder holds something else.
    ContactError
        The contact of the scene has no solution.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> words = ["sphere.radius_mm=1", "rolling.load_n=0.2", "rolling.duration_s=0.003"]
    >>> scene = rolling.read_scene("quickstart", words)
    >>> found = rolling.sensitivities(scene, ["distance_m"], pairs=2, workers=1, progress=False)
    >>> round(found.rows[0].db, 2)
    -0.83
    """
    from rolling.choice.sensitivity import improve_scene
    from rolling.run.budget import Budget

    instance("scene", scene, SweptScene)
    if isinstance(keys, str):
        raise TypeError(f"keys: got {keys!r}, allowed: a list of keys, as in [{keys!r}]")
    with _kept_in(folder, progress) as kept:
        return improve_scene(
            scene=scene,
            folder=kept,
            keys=keys,
            budget=Budget(within_db=within_db, minutes=minutes, pairs=pairs),
            workers=workers,
            quantity=quantity,
        )


@ignoring_underflow
def coarsest_below(
    scene: SweptScene,
    key: str,
    level_db: float,
    between: tuple[float | str, float | str] | None = None,
    seeds: int = defaults.LIMIT_SEEDS,
    folder: Path | str | None = None,
    workers: int = 0,
    progress: bool | None = None,
    quantity: str | None = None,
) -> Limit:
    """Find the coarsest value of a key with which a scene stays below a level.

    Below means that 95 % of specimens lie below the level, with a confidence of 95 %. Where a
    larger value is quieter, the smallest value that stays below is found.

    Parameters
    ----------
    scene : Scene or BearingScene
        A scene without a sweep, on a random or a measured surface.
    key : str
        Key of a number above 0, of the finish, or of the grade of the ball.
    level_db : float
        The level of the vibration at the listener of the scene, dB(A); of a band of the ring of a
        bearing, dB re 1 um/s.
    between : pair of float or str
        Range of the search. Default: a fifth of the value of the scene to five times it, as far as
        scenes are allowed, or all finishes or grades.
    seeds : int
        Number of specimens, from 3 to 60. Default: 12.
    folder : Path or str
        Folder that keeps the specimens, so that the same call goes on. Default: none, and only the
        numbers are kept.
    workers, progress : int, bool
        As in `simulate`.
    quantity : str
        The quantity whose level is limited: low, medium, high or housing of a bearing. Default:
        medium; the vibration of a ball.

    Returns
    -------
    limit : Limit
        The answer, with `value`, `table()`, `plot(ax)` and `sentences`.

    Raises
    ------
    SceneError
        The scene sweeps or cannot run, the key is unknown or has no such value, the range is not
        allowed, or nothing is random in the scene.
    FolderError
        The folder holds something else.
    ContactError
        A contact has no solution.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> words = ["sphere.radius_mm=1", "rolling.load_n=0.2", "rolling.duration_s=0.003"]
    >>> scene = rolling.read_scene("quickstart", words)
    >>> limit = rolling.coarsest_below(
    ...     scene, "distance_m", 200, between=(1, 1.1), seeds=3, workers=1, progress=False
    ... )
    >>> limit.value, limit.rises
    (1.0, False)

    References
    ----------
    ISO 16269-6:2014, for the tolerance limit.
    """
    from rolling.choice.limit_search import coarsest_value

    instance("scene", scene, SweptScene)
    with _kept_in(folder, progress) as kept:
        return coarsest_value(
            scene=scene,
            key=key,
            level_db=level_db,
            between=between,
            seeds=seeds,
            folder=kept,
            workers=workers,
            quantity=quantity,
        )


@ignoring_underflow
def design(
    scene: SweptScene,
    quieter_db: float,
    pairs: int = defaults.DESIGN_PAIRS,
    folder: Path | str | None = None,
    workers: int = 0,
    progress: bool | None = None,
) -> Design:
    """Find which waves of the plate must be lower for a quieter scene, with the least change.

    Waves are lowered in third octaves of wavelength along the track, and keep their phases. The
    linear response of the contact says what each band does to the level. Among all changes that are
    enough, the one with the smallest sum of the squares of its decibels is taken. The changed
    surfaces are marched beside those of the scene, and the change is corrected until the fall is
    the one that is asked for.

    Parameters
    ----------
    scene : Scene
        A scene without a sweep, of a ball that rolls on a plate with a random or measured surface.
    quieter_db : float, dB
        Wanted fall of the level of the vibration, above 0 and up to 60.
    pairs : int
        Number of specimens, from 2 to 30, on which changed surfaces are marched, and of others,
        whose response is taken. Default: 6.
    folder : Path or str
        Folder that keeps the specimens, so that the same call goes on. Default: none, and only the
        numbers are kept.
    workers, progress : int, bool
        As in `simulate`.

    Returns
    -------
    design : Design
        The bands and the fall with its ±, with `table()`, `target()`, `plot(ax)`, `sentences` and
        the scene with lower waves, `changed`.

    Raises
    ------
    SceneError
        The scene sweeps, cannot run, makes no sound or has no waves that could be lower, is no ball
        on a plate, or so large a fall is not possible.
    FolderError
        The folder holds something else.
    ContactError
        A contact has no solution.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> words = ["sphere.radius_mm=1", "rolling.load_n=0.2", "rolling.duration_s=0.003"]
    >>> scene = rolling.read_scene("quickstart", words)
    >>> design = rolling.design(scene, 2, pairs=2, workers=1, progress=False)
    >>> abs(design.fall.db - 2) < design.fall.uncertainty_db
    True
    """
    from rolling.choice.design_search import design_scene

    instance("scene", scene, SweptScene)
    with _kept_in(folder, progress) as kept:
        return design_scene(
            scene=scene, quieter_db=quieter_db, folder=kept, pairs=pairs, workers=workers
        )


def _listed(scenes: Any) -> list[SweptScene]:
    """Return scenes in a list, all of one kind."""
    listed = [scenes] if isinstance(scenes, SweptScene) else list(scenes)
    for scene in listed:
        instance("scenes", scene, SweptScene)
    for scene in listed:
        instance("scenes", scene, type(listed[0]))
    return listed


@contextmanager
def _kept_in(folder: Path | str | None, progress: bool | None) -> Iterator[Path]:
    """Give a folder of specimens, a temporary one without a name, and be silent if asked to."""
    with terminal.shown(progress):
        if folder is not None:
            yield Path(folder)
            return
        with tempfile.TemporaryDirectory() as parent:
            yield Path(parent) / "choice"
