"""The study of speed against error: variants are marched, compared, and kept as one Dataset."""

import json
from collections.abc import Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from rolling import __version__
from rolling.archive import hdf5_reader
from rolling.archive.definition import ROOT, TEXT, GroupDefinition, Variable
from rolling.check.long_steps import refuse_long_steps
from rolling.contact.solver import ContactError
from rolling.figures.settings import left_out_if_it_fails
from rolling.in_si.physics_of_scene import listener_of
from rolling.results import labels
from rolling.run import pools
from rolling.run.executor import ended_by_signal
from rolling.scene.identity import digest, scene_identity
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import contact_sound
from rolling.studies import accuracy_variants as variants
from rolling.studies import work_precision
from rolling.studies.accuracy_variants import OWN, REFERENCE, SOLVER, Variant, label
from rolling.terminal import defaults, progress, whole_files
from rolling.terminal.whole_files import FolderError, read_regular

BANDS = [name for name in BAND_NAMES if 100 <= float(name) <= 16000]
LEVELS = ("laeq_db", "third_octave_db")
MEANS = ("mean_release_w", "contact_area_m2", "plastic_area_m2", "max_pressure_pa")
DATASET = "accuracy.nc"
MAX_BYTES = 100_000_000  # of the dataset
_STUDY = GroupDefinition(
    (
        Variable("variant", "variant", "1", TEXT, "label of a variant"),
        Variable("band", "band", "Hz", TEXT, "name of a third octave"),
        *(
            # A setting that no variant changes is stored once.
            Variable(name, "variant", unit, dtype, meaning, is_auxiliary=True, may_be_single=True)
            for name, unit, dtype, meaning in (
                ("curve", "1", TEXT, "what the variants of a curve change"),
                ("edges", "1", TEXT, "treatment of the edge of the contact"),
                ("precision", "1", TEXT, "precision of the solver"),
                ("spacing_um", "um", "f8", "spacing of the grid"),
                ("step_um", "um", "f8", "length of a step"),
                ("tolerance", "1", "f8", "tolerance of the solver"),
            )
        ),
        Variable("seconds_per_second", "variant", "1", "f8", "march over duration of the sound"),
        Variable("iterations", "variant", "1", "f8", "mean number of iterations"),
        Variable("convolutions", "variant", "1", "f8", "mean number of convolutions"),
        Variable("laeq_db", "variant", "dB", "f8", "equivalent level"),
        Variable("third_octave_db", "variant band", "dB", "f8", "level of a third octave"),
        Variable("intensity_w_m2", "variant sample", "W/m2", "f8", "audible release"),
        Variable("mean_release_w", "variant", "W", "f8", "mean released power"),
        Variable("contact_area_m2", "variant", "m2", "f8", "mean area in contact"),
        Variable("plastic_area_m2", "variant", "m2", "f8", "mean area at the hardness"),
        Variable("max_pressure_pa", "variant", "Pa", "f8", "maximum pressure"),
        Variable("error_laeq_db", "variant", "dB", "f8", "error of the level"),
        Variable("error_third_octave_db", "variant band", "dB", "f8", "error of a third octave"),
        Variable("error_mean_release_percent", "variant", "%", "f8", "error of the mean release"),
        Variable("error_contact_area_percent", "variant", "%", "f8", "error of the contact area"),
        Variable("error_plastic_area_percent", "variant", "%", "f8", "error of the plastic area"),
        Variable("error_max_pressure_percent", "variant", "%", "f8", "error of the pressure"),
        Variable("error_signal_db", "variant", "dB", "f8", "error over signal of the release"),
        Variable("solver_error_signal_db", "variant", "dB", "f8", "the same, of the solver alone"),
    ),
    {
        "identity": str,
        "name": str,
        "length_m": float,
        "closed": int,
        "failures": str,
        "scene": str,
        "program": str,
    },
)
_MAY_LACK = {"solver_error_signal_db"}


def accuracy(
    scene: Scene,
    duration_s: float = defaults.ACCURACY_SECONDS,
    finest: int = defaults.FINEST,
    workers: int = 0,
) -> xr.Dataset:
    """March the variants of a scene over the same stretch of track and compare them.

    Parameters
    ----------
    scene : Scene
        Scene without a sweep.
    duration_s : float, s
        Maximum duration of rolling.
    finest : int
        Divisor of the spacing for the reference: 2, 4, ...
    workers : int
        Number of processes; 0 means one per core.

    Returns
    -------
    xarray.Dataset
        Settings, costs, levels and means by `variant`, with their differences from the reference as
        `error_...`. The errors of `solver_error_signal_db` are those against the scene's own grid
        and step, solved to 1e-8. Variants that failed stand in the attribute `failures`.

    Raises
    ------
    ContactError
        The scene as it stands or its reference cannot be solved.

    Examples
    --------
    >>> study = accuracy(read_scene("scenarios/elastic-plate.yaml"), 0.01)  # doctest: +SKIP
    >>> study.error_laeq_db.to_series()  # doctest: +SKIP
    """
    scene, nodes = variants.stretch_of(scene, duration_s)
    listed = variants.variants_of(scene, finest)
    marched, failures = _march_all(scene, listed, nodes, workers)
    for variant in listed:
        if variant.curve in (OWN, REFERENCE) and variant in failures:
            raise ContactError(f"{label(scene, variant)}: {failures[variant]}")
    rows = [_row(scene, variant, nodes, series) for variant, series in marched.items()]
    study = compared(xr.concat(rows, "variant", coords="different", compat="equals"))
    study.attrs = {
        "name": scene.name,
        "length_m": nodes * scene.spacing,
        "closed": int(nodes == scene.track.n_along),
        "failures": "\n".join(f"{label(scene, v)}: {reason}" for v, reason in failures.items()),
        "scene": json.dumps(scene.to_dict()),
        "program": __version__,
    }
    return study


def _march_all(
    scene: Scene, listed: Sequence[Variant], nodes: int, workers: int
) -> tuple[dict[Variant, dict[str, Array]], dict[Variant, str]]:
    """March variants, the longest first; return their series and the reasons of failures.

    Raises
    ------
    OSError : a worker was killed.
    """
    marched = dict[Variant, dict[str, Array]]()
    failures = dict[Variant, str]()
    total = sum(variant.cost for variant in listed)
    bar = progress.Bar(total, f"{scene.name}: {len(listed)} variants")
    with bar, ended_by_signal(), pools.local_pool(workers, [scene]) as pool:
        futures: dict[Variant, Future[dict[str, Array]]] = {}
        for variant in sorted(listed, key=attrgetter("cost"), reverse=True):
            task = pools.Task(("", ""), variants.march_variant, (scene, variant, nodes))
            futures[variant] = pool.submit(task)
            futures[variant].add_done_callback(partial(_proceed, bar, variant.cost))
        for variant, future in futures.items():
            try:
                marched[variant] = future.result()
            except ContactError as error:
                failures[variant] = str(error)
            except BrokenExecutor as error:
                raise OSError("a worker process was killed; out of memory?") from error
    return {variant: marched[variant] for variant in listed if variant in marched}, failures


def _proceed(bar: progress.Bar, share: float, future: object) -> None:
    """Add the share of a variant that is done to the progress."""
    bar.update(share)


def _row(scene: Scene, variant: Variant, nodes: int, series: Mapping[str, Array]) -> xr.Dataset:
    """Compute the costs, levels and means of a marched variant."""
    solved = scene.with_({"numerics.tolerance": variant.tolerance})
    step = variant.step_nodes * scene.spacing
    closed = nodes == scene.track.n_along
    sound = contact_sound(
        series["release_energy"],
        step=step,
        motion=solved.motion,
        listener=listener_of(solved),
        tolerance=solved.tolerance,
        closed=closed,
    )
    levels = sound.levels
    bands = np.array([levels.third_octave_db[name] for name in BANDS], dtype=float)
    return xr.Dataset(
        {
            "seconds_per_second": float(series["seconds"]) / sound.duration,
            "iterations": float(series["iterations"].mean()),
            "convolutions": float(series["convolutions"].mean()),
            "laeq_db": np.float64(levels.laeq_db),
            "third_octave_db": ("band", bands),
            "intensity_w_m2": ("sample", sound.pressure / (sound.factor or 1.0)),
            "mean_release_w": sound.mean_power,
            "contact_area_m2": float(series["contact_area"].mean()),
            "plastic_area_m2": float(series["plastic_area"].mean()),
            "max_pressure_pa": float(series["max_pressure"].max()),
        },
        {
            "variant": label(scene, variant),
            "curve": variant.curve,
            "spacing_um": scene.spacing / variant.times * 1e6,
            "step_um": step * 1e6,
            "tolerance": variant.tolerance,
            "edges": variant.edges,
            "precision": variant.precision,
            "band": BANDS,
        },
    )


def compared(rows: xr.Dataset) -> xr.Dataset:
    """Add the errors of variants against the reference, and of the solves on the scene's grid."""
    best = rows.isel(variant=rows.curve == REFERENCE).squeeze("variant", drop=True)
    errors = {f"error_{name}": rows[name] - best[name] for name in LEVELS}
    with np.errstate(divide="ignore", invalid="ignore"):
        for name in MEANS:
            errors[f"error_{name.rpartition('_')[0]}_percent"] = 100 * (rows[name] / best[name] - 1)
        errors["error_signal_db"] = _signal_db(rows, best)
        exact = rows.isel(variant=rows.curve == SOLVER)
        if exact.sizes["variant"]:
            on_grid = rows.curve.isin([OWN, "tolerance", "precision"])
            solver_errors = _signal_db(rows, exact.squeeze("variant", drop=True))
            errors["solver_error_signal_db"] = solver_errors.where(on_grid)
    return rows.assign(errors)


def _signal_db(rows: xr.Dataset, best: xr.Dataset) -> xr.DataArray:
    """Return the rms error of the audible release over the rms of its fluctuation [dB]."""
    off = ((rows.intensity_w_m2 - best.intensity_w_m2) ** 2).mean("sample")
    ratio = off / (best.intensity_w_m2**2).mean("sample")
    level: xr.DataArray = 10 * np.log10(ratio.where(ratio > 0))
    return level


# ---- the command


def run_study(
    scene: Scene,
    out: Path | None = None,
    workers: int = 0,
    finest: int = defaults.FINEST,
    duration_s: float = defaults.ACCURACY_SECONDS,
) -> list[Path]:
    """Study the first run of a scene, print the table, and return the folder of the files.

    A folder that holds the same study already is not computed again.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    ContactError : as in `accuracy`.
    """
    values, scene = scene.runs()[0]
    refuse_long_steps(scene)
    identity = digest([scene_identity(scene), finest, duration_s])
    folder = out or Path("outputs") / f"{scene.name}-accuracy-{identity[:8]}"
    study = _stored(folder, identity)
    if study is None:
        if values:
            first = ", ".join(labels.worded(key, value) for key, value in values.items())
            progress.line(f"the first run of the sweep: {first}; --set chooses another")
        study = accuracy(scene, duration_s, finest, workers).assign_attrs(identity=identity)
        folder.mkdir(parents=True, exist_ok=True)
        whole_files.write_bytes(folder / DATASET, bytes(study.to_netcdf(engine="h5netcdf")))
    whole_files.write_bytes(folder / "accuracy.csv", work_precision.table(study).to_csv().encode())
    picture = None
    with left_out_if_it_fails("accuracy.png"):
        picture = work_precision.diagram_png(study)
    if picture is not None:
        whole_files.write_bytes(folder / "accuracy.png", picture)
    if not progress.is_quiet():
        print(work_precision.text(study))
    return [folder]


def _stored(folder: Path, identity: str) -> xr.Dataset | None:
    """Return the study that a folder holds, or None for a new or an empty folder.

    Raises
    ------
    FolderError : the folder holds anything else.
    """
    try:
        if not folder.exists() or all(
            path.suffix == whole_files.PARTIAL for path in folder.iterdir()
        ):
            return None
        study = read_study(folder / DATASET)
    except (OSError, ValueError) as error:
        raise FolderError(f"{folder}: holds no study of accuracy; take another --out") from error
    if study.attrs.get("identity") != identity:
        raise FolderError(f"{folder}: holds the study of another scene; take another --out")
    return study


def read_study(path: Path) -> xr.Dataset:
    """Read a stored study, whose arrays are judged before.

    Raises
    ------
    OSError, ValueError : the file is missing, larger than MAX_BYTES, or holds no study.
    """
    content = read_regular(path, MAX_BYTES)
    with hdf5_reader.reading(content, MAX_BYTES) as file:
        stored = file.groups({ROOT: _STUDY}, {"band": len(BANDS)})[ROOT]
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for name, values in stored.arrays.items():
        definition = _STUDY.by_name[name]
        kept = coordinates if definition.is_coordinate else variables
        kept[name] = (definition.axes if values.ndim else (), values)
    study = xr.Dataset(variables, coordinates, stored.attributes)
    missing = {*_STUDY.by_name} - {*stored.arrays} - _MAY_LACK
    if missing:
        raise ValueError(f"lacks {', '.join(sorted(missing))}")
    return study
