"""The cases of the study: the runs of its scenes, each a row of settings and measures."""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.plot_style import NOTHING_DB, Lines
from acoustics.radiation import I_REF_W_M2, P_REF_PA
from acoustics.spectrum import article_line_level_db
from acoustics.uncertainty import level_uncertainty
from acoustics.weighting import a_weighting_db
from rolling.in_si import scene_surface
from rolling.results.run_result import Run
from rolling.run.folder import stored_runs
from rolling.run.solving import open_runs, solve_folder
from rolling.scene.file import read_as
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.terminal import progress

HIGH_HZ = 5000.0  # lowest frequency of a "high-frequency" spectrum
STATED_SPHERE = (5.0, None)  # radius [mm] and modulus [GPa] of the article's rigid sphere
# Settings that a case shares with its twin, the same scene without hardness.
TWIN_KEYS = [
    "roughness_um",
    "load_n",
    "seed",
    "correlation_um",
    "autocorrelation",
    "width_um",
    "spacing_um",
    "step_um",
    "duration_s",
    "radius_mm",
    "contact_modulus_gpa",
    "skewness",
    "kurtosis",
]
ENDS_N = (5.0, 100.0)  # loads of the maps
PATCH_M = 512e-6  # side of the surfaces of the article's Fig. 1
CELLS = 100  # maximum number of cells along a side of a map: more can hardly be distinguished
CURVES = ["curve_hz", "curve_db"]  # columns of arrays


class MapKey(NamedTuple):
    """Quantity, roughness and load of a map."""

    quantity: str
    roughness_um: float
    load_n: float


class ThinnedMap(NamedTuple):
    """Values of the cells of a map, and the width of a cell."""

    cell_um: float
    values: Array


Maps = dict[MapKey, ThinnedMap]


def finished_runs(
    scene_path: Path, folder: Path, workers: int, overrides: Sequence[str] = ()
) -> list[Run]:
    """Run a scene file into a folder, or continue it there, and open its complete runs."""
    failures = solve_folder(read_as(scene_path, Scene, overrides), folder, workers=workers)
    for label, reason in failures.items():
        progress.line(f"failed: {folder.name}, {label}: {reason}")
    return open_runs([run for run in stored_runs(folder) if run.is_done])


def case_of(reading: str, run: Run) -> dict[str, Any]:
    """Return the row of a run; the names of its columns end in their units."""
    scene = run.scene
    contact = run.numbers.contact
    surface = scene.surface
    assert isinstance(surface, Gaussian)
    skewness, kurtosis = surface.moments
    has_hardness = math.isfinite(scene.plate.cap_gpa)
    return {
        "reading": reading,
        "roughness_um": surface.roughness_ra_um,
        "load_n": scene.load,
        "seed": surface.seed,
        "correlation_um": surface.correlation_length_um,
        "autocorrelation": surface.autocorrelation,
        "skewness": skewness,
        "kurtosis": kurtosis,
        "width_um": surface.width_um,
        "spacing_um": surface.spacing_um,
        "step_um": scene.step * 1e6,
        "duration_s": run.numbers.record.duration_s,
        "radius_mm": scene.sphere.radius_mm,
        "contact_modulus_gpa": scene.contact_modulus * 1e-9,
        "hardness_gpa": scene.plate.cap_gpa if has_hardness else math.nan,
        "as_stated": (scene.sphere.radius_mm, scene.sphere.youngs_modulus_gpa) == STATED_SPHERE,
        "rms_slope": run.numbers.surface.rms_slope,
        "max_pressure_gpa": contact.max_pressure_pa * 1e-9,
        "contact_area_um2": contact.area_mean_m2 * 1e12,
        "plastic_area_um2": contact.plastic_area_mean_m2 * 1e12,
        "plastic_ratio": contact.plastic_ratio,
        "deflection_um": float(np.nanmean(run.series["max_deflection"])) * 1e6,
        **_sound_measures(run),
        **_line_measures(run),
    }


def _sound_measures(run: Run) -> dict[str, float]:
    """Compute levels of the fluctuation of the release [dB] and its spectral centroid [Hz].

    LAeq is 10 lg of the release. The same fluctuation as 20 lg has no absolute value.
    """
    numbers = run.numbers
    spreads = numbers.of_record.spreads
    third_octaves = numbers.bands.released_power
    assert spreads is not None and third_octaves is not None  # the release plays
    sound = run.sound
    laps = run.laps
    unscaled = level_uncertainty(sound.pressure, sound.sample_rate, sound.levels, False, laps=laps)
    factor = numbers.record.factor_pa_per_w_m2
    unscaled_db = 20 * math.log10(P_REF_PA / (factor * I_REF_W_M2)) if factor else math.nan
    level_db = _or_nan(numbers.of_record.laeq_db)
    bands_db = np.array(third_octaves.value, dtype=float)
    square = np.nan_to_num(10 ** (bands_db / 10))
    return {
        "audible_10_db": level_db,
        "audible_10_uncertainty_db": _or_nan(spreads.laeq_db),
        "audible_20_db": level_db + unscaled_db,
        "audible_20_uncertainty_db": _or_nan(unscaled.laeq_db),
        "centroid_hz": float(square @ MID_HZ / square.sum()) if square.any() else math.nan,
        **dict(zip(band_columns(BAND_NAMES), map(float, bands_db + unscaled_db), strict=True)),
    }


def _or_nan(value: float | None) -> float:
    """Return a number, NaN where there is none."""
    return math.nan if value is None else value


def _line_measures(run: Run) -> dict[str, Any]:
    """Compute the article's A-weighted line spectrum and its heights [dB] with 10 and 20 lg."""
    scene = run.scene
    power = run.release_power
    rate_hz = len(power) / run.numbers.record.duration_s
    frequency_hz, level_db = article_line_level_db(
        power, rate_hz, scene.sound.distance_m, scene.sound.q
    )
    lines = Lines.audible(frequency_hz, level_db)
    hz, db = lines.mean
    curve_db = np.where(db > NOTHING_DB, db, math.nan)
    high = hz >= HIGH_HZ
    return {
        "maximum_10_db": float(lines.level_db.max()),
        "maximum_20_db": float(_doubled(lines.frequency_hz, lines.level_db).max()),
        "high_10_db": float(np.nanmean(curve_db[high])),
        "high_20_db": float(np.nanmean(_doubled(hz, curve_db)[high])),
        "curve_hz": hz,
        "curve_db": curve_db,
    }


def _doubled(frequency_hz: Array, level_db: Array) -> Array:
    """Return A-weighted levels [dB] of 20 lg in place of 10 lg; the weighting stays the same."""
    weighting = a_weighting_db(frequency_hz)
    return 2 * (level_db - weighting) + weighting


def band_columns(names: Iterable[str]) -> list[str]:
    """Return the columns of third-octave levels [dB] by the bands' nominal frequencies."""
    return [f"band_{name}_hz_db" for name in names]


def maps_of(run: Run) -> Maps:
    """Return thinned maps of heights, contact pressure and deflection of a run at an end load."""
    scene = run.scene
    snapshot = run.result.snapshot
    assert isinstance(scene.surface, Gaussian)
    if scene.load not in ENDS_N or scene.surface.seed != 1 or snapshot is None:
        return {}
    quantities = {
        "pressure [GPa]": snapshot.pressure * 1e-9,
        "deflection [µm]": snapshot.deflection * 1e6,
    }
    if scene.load == ENDS_N[0]:  # the same surface under both loads
        nodes = round(PATCH_M / scene.spacing)
        quantities["height [µm]"] = scene_surface.heights(scene)[:nodes, :nodes] * 1e6
    maps: Maps = {}
    for quantity, values in quantities.items():
        stride = -(-max(values.shape) // CELLS)
        key = MapKey(quantity, scene.surface.roughness_ra_um, scene.load)
        maps[key] = ThinnedMap(stride * scene.spacing * 1e6, values[::stride, ::stride])
    return maps


def frame(rows: Sequence[dict[str, Any]]) -> pd.DataFrame:
    """Return the rows of cases as a table in the order of roughness, load and surface."""
    cases = pd.DataFrame(rows)
    order = ["roughness_um", "correlation_um", "load_n", "seed"]
    return cases.sort_values(order, kind="stable", ignore_index=True)


def by_reading(cases: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the cases of each reading beside their twins, whose columns end in `_elastic`.

    A twin has the same settings but no hardness. Cases without hardness are no reading.
    """
    elastic = cases["hardness_gpa"].isna()
    twins = cases[elastic].drop(columns=["reading", "hardness_gpa", "as_stated"])
    return {
        str(name): group.merge(twins, on=TWIN_KEYS, how="left", suffixes=("", "_elastic"))
        for name, group in cases[~elastic].groupby("reading", sort=False)
    }
