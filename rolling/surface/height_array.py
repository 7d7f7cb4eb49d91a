"""Heights of numpy arrays as surfaces of scenes.

A scene knows files. An array is written to a folder of this process under the digest of its bytes,
where the workers read it, and a saved run has a copy.
"""

from __future__ import annotations

import atexit
import hashlib
import io
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.arrays import positive
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.scene.track import MIN_NODES
from rolling.surface.levelling import in_metres
from rolling.terminal import files

COPY = "heights.npy"  # name of the copy in the folder of a run


def HeightArray(heights: Any, *, spacing_um: float, **keys: Any) -> HeightFile:
    """Make a surface of an array of heights, for `Scene(surface=...)` and `simulate(heights=...)`.

    Parameters
    ----------
    heights : (m, n) array_like, m
        Real heights along and across the track, one period of at least 8 x 8 nodes; or a profile of
        shape (m,), (m, 1) or (1, m) with the key `width_um`.
    spacing_um : float, um
        Node spacing along and across.
    **keys
        Other keys of `HeightFile`, such as `periodic="blend"` for a measurement,
        `unmeasured="fill"` where NaN marks unmeasured points, and `height_unit`.

    Returns
    -------
    surface : HeightFile. Its file lasts as long as this process.

    Raises
    ------
    ValueError : the heights have another shape, or are not real, not finite or too large.
    SceneError : a key is unknown or does not fit.

    Examples
    --------
    >>> import numpy as np
    >>> import rolling
    >>> z = 1e-7 * np.random.default_rng(1).standard_normal((64, 32))
    >>> rolling.HeightArray(z, spacing_um=2).spacing_um
    2.0
    """
    allowed = f"allowed: real numbers, (along, across), at least {MIN_NODES} each way, or a profile"
    try:
        if np.ma.isMaskedArray(heights):
            heights = np.ma.filled(heights.astype(float), np.nan)
        values = np.asarray(heights)
    except ValueError as error:  # rows of several lengths
        raise ValueError(f"heights: got rows of several lengths, {allowed}") from error
    if values.dtype.kind not in "fiu" or values.ndim not in (1, 2):
        raise ValueError(f"heights: got {values.ndim}-D {values.dtype}, {allowed}")
    is_profile = values.ndim == 1 or 1 in values.shape
    if max(values.shape) < MIN_NODES or (min(values.shape) < MIN_NODES and not is_profile):
        raise ValueError(f"heights: got an array of shape {values.shape}, {allowed}")
    positive("spacing_um", spacing_um, 1e15)
    surface = HeightFile(path=COPY, spacing_um=float(spacing_um), **keys)
    in_metres(values, surface.height_unit, "heights", surface.unmeasured == "fill")
    stream = io.BytesIO()
    np.save(stream, values)
    content = stream.getvalue()
    path = _folder() / f"{hashlib.sha256(content).hexdigest()[:32]}.npy"
    if not path.exists():
        files.write_bytes(path, content)
    return surface.model_copy(update={"path": str(path)})


@cache
def _folder() -> Path:
    """Make the folder of the arrays of this process, which its end removes."""
    folder = Path(tempfile.mkdtemp(prefix="rolling-heights-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def with_copy(scene: Scene, folder: Path) -> Scene:
    """Copy the array of a scene into a folder; return the scene with the copy in its place."""
    path, is_made = scene.height_path, _folder.cache_info().currsize > 0
    if path is None or not is_made or path.parent != _folder():
        return scene
    files.write_bytes(folder / COPY, path.read_bytes())
    data = scene.to_dict()
    return Scene.from_dict({**data, "surface": {**data["surface"], "path": COPY}}, folder)
