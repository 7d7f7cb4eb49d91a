"""Refusals before anything large is computed or written.

A package may be missing, or memory and disk may not suffice.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path

from rolling.check import cost, demand, machine
from rolling.check.finding import byte_size
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene

OUTPUTS = Path("outputs")  # where runs are written unless another folder is given
PURPOSES = {
    "sound samples": "the sound",
    "runs of the sweep": "the other runs of the sweep",
}  # parts of a demand in words


def refuse_unavailable(scene: Scene) -> None:
    """Refuse a scene that asks for a package that is not installed.

    Raises
    ------
    SceneError
        The scene asks for loudness, and the package for it is missing.
    """
    if scene.sound.loudness and find_spec("mosqito") is None:
        raise SceneError(
            [
                f"{scene.place('sound.loudness')}: sound.loudness:"
                " needs the package mosqito, which is not installed;"
                ' pip install "rolling-contact-noise[loudness]", or set it to false'
            ]
        )


def refuse_what_cannot_fit(scene: Scene, workers: int = 0, folder: Path = OUTPUTS) -> None:
    """Refuse a scene whose runs need more memory or disk than they may take.

    Parameters
    ----------
    workers : int
        Number of processes; 0 means one per core. Default 0.
    folder : Path
        Folder of the results. Files of the run that are there already are not needed again.

    Raises
    ------
    SceneError
        The runs do not fit, or a height file cannot be used.
    """
    scenes = [single for _, single in scene.runs()]

    def needed(roughness: Callable[[Scene], float]) -> demand.Demand:
        return demand.of_scenes(
            [(single, roughness(single)) for single in scenes], workers or cost.cores()
        )

    written = _written(folder) if (folder / "resolved.yaml").is_file() else 0.0
    _refuse_excess(scenes, needed, folder, written)


def refuse_variants_that_cannot_fit(
    scene: Scene, finest: int, workers: int = 0, folder: Path = OUTPUTS
) -> None:
    """Refuse the variants of a scene without sweep whose memory or disk does not suffice.

    Parameters
    ----------
    finest : int
        Divisor of the spacing on the finest grid.
    workers : int
        Number of processes; 0 means one per core. Default 0.
    folder : Path
        Folder of the results.

    Raises
    ------
    SceneError
        The variants do not fit, or a height file cannot be used.
    """

    def needed(roughness: Callable[[Scene], float]) -> demand.Demand:
        return demand.of_variants(scene, roughness(scene), finest, workers or cost.cores())

    _refuse_excess([scene], needed, folder)


def refuse_large_heights(scene: Scene) -> None:
    """Refuse a height file that does not fit into memory, judged by its header."""
    if scene.height_path is not None:
        faults = excess(demand.reading(scene.track), OUTPUTS)
        if faults:
            raise SceneError([f"surface.path: {fault}" for fault in faults.values()])


def _refuse_excess(
    scenes: Sequence[Scene],
    needed: Callable[[Callable[[Scene], float]], demand.Demand],
    folder: Path,
    written: float = 0.0,
) -> None:
    """Refuse a demand that does not fit.

    The demand depends on the rms roughness [m] of each scene.
    """
    # The header of a height file alone decides first, before the file is read.
    first = [lambda scene: 0.0] if any(scene.height_path is not None for scene in scenes) else []
    for roughness in (*first, roughness_read_once()):
        if faults := excess(needed(roughness), folder, written):
            raise SceneError([f"{key}: {fault}" for key, fault in faults.items()])


def roughness_read_once() -> Callable[[Scene], float]:
    """Return a function for the rms roughness [m] of a scene.

    It reads a height file that many runs share only once.
    """
    known: dict[str, float] = {}

    def roughness(scene: Scene) -> float:
        key = f"{scene.surface.model_dump_json()} {scene.height_path}"
        if key not in known:
            known[key] = cost.roughness(scene)[0]
        return known[key]

    return roughness


def amount_text(amount: demand.Amount) -> str:
    """Write a demand with the part that dominates it."""
    part, size = amount.largest
    return (
        f"about {byte_size(amount.total)}, {byte_size(size)} for"
        f" {PURPOSES.get(part, f'the {part}')}"
    )


def excess(needed: demand.Demand, folder: Path, written: float = 0.0) -> dict[str, str]:
    """Write by "memory" and "disk" why a demand does not fit.

    A text holds need, limit, the largest part and the advice.

    Parameters
    ----------
    needed : Demand
        Memory and disk that are needed.
    folder : Path
        Folder of the results.
    written : float, bytes
        Files of the run that are there already. Default 0.
    """
    memory, address_space, disk = (
        machine.memory(),
        machine.address_space(),
        machine.free_disk(folder),
    )
    place = f"free where {folder} is" if folder.exists() else f"free where {folder} will be"
    limits = [
        ("memory", needed.memory, memory, "this machine allows"),
        ("memory", needed.process, address_space, "one process may address"),
        ("disk", needed.disk, disk + written, place),
    ]
    faults: dict[str, str] = {}
    for key, amount, limit, words in limits:
        if amount.total > machine.SHARE * limit and key not in faults:
            part = amount.largest[0]
            faults[key] = (
                f"needs {amount_text(amount)}, allowed: {byte_size(machine.SHARE * limit)},"
                f" {100 * machine.SHARE:.0f} % of the {byte_size(limit)} {words};"
                f" {demand.ADVICE[part]}"
            )
    return faults


def _written(folder: Path) -> float:
    """Return the size [bytes] of the files in a folder."""
    return float(sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()))
