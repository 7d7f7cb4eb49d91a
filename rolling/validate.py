"""Results of the program beside published ones: the contact filter of wheel and rail."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from acoustics.arrays import Array
from rolling.results.run_result import Run
from rolling.scene.laws import SelfAffineLaw
from rolling.scene.scene import Scene
from rolling.sound.wavelengths import wavelength_bands
from rolling.surface.scene_surface import heights

LONGEST_MM, LEAST_MM = 100.0, 7.9  # wavelengths whose differences are summed up
Simulate = Callable[..., Any]


def wheel_on_rail(
    scene: Scene, published: Mapping[float, pd.Series], simulate: Simulate
) -> pd.DataFrame:
    """Compare the contact filter of an elliptic, a round and a ridged contact with a table.

    The filter is the level of the approach under a constant load over the level of the heights
    under the centre of the contact, in third octaves of wavelength. Nothing is fitted.

    Parameters
    ----------
    scene : Scene
        Wheel and rail, with a self-affine surface whose track closes.
    published : dict of Series
        Published filters [dB] by nominal wavelength [mm], by load [N].
    simulate : callable
        `rolling.simulate`.

    Returns
    -------
    DataFrame
        A row for each load, contact and third octave: load_n, contact, wavelength_mm, published_db,
        ours_db and difference_db.
    """
    radius = 1e3 * np.sqrt(scene.radius * scene.radius_across)
    sphere = {"sphere.radius_mm": radius, "sphere.radius_across_mm": None}
    profile = centre_lines(heights(scene))[:, :1]
    ridges = np.repeat(profile, scene.track.n_across, axis=1)
    rows = []
    for load, table in published.items():
        loaded = scene.with_({"rolling.load_n": load})
        for contact, changes, surface in (
            ("elliptic", {}, None),
            ("round", sphere, None),
            ("elliptic, full-width ridges", {}, ridges),
        ):
            run = simulate(loaded.with_(changes), progress=False, heights=surface)
            rows.append(_beside(table, contact_filter(run)).assign(load_n=load, contact=contact))
    order = ["load_n", "contact", "wavelength_mm", "published_db", "ours_db", "difference_db"]
    return pd.concat(rows, ignore_index=True)[order]


def differences(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rms and maximum difference [dB] by load and contact, from 7.9 to 100 mm."""
    within = rows[rows["wavelength_mm"].between(LEAST_MM, LONGEST_MM)]
    grouped = within.groupby(["load_n", "contact"], sort=False)["difference_db"]
    return pd.DataFrame(
        {
            "rms_db": grouped.apply(lambda error: float(np.sqrt(np.mean(error**2)))),
            "worst_db": grouped.apply(lambda error: float(np.abs(error).max())),
        }
    ).reset_index()


def published_filters(path: str) -> dict[float, pd.Series]:
    """Read filters [dB] by wavelength [mm] from a table with a column for each load [kN]."""
    table = pd.read_csv(path, comment="#", index_col="wavelength_mm")
    return {1e3 * float(load): table[load] for load in table}


def centre_lines(surface: Array) -> Array:
    """Return the one or two lines of heights under the centre of the contact."""
    across = surface.shape[1]
    return surface[:, (across - 1) // 2 : across // 2 + 1]


def contact_filter(run: Run) -> pd.Series:
    """Return the level of the approach re the heights under the centre [dB] by wavelength [mm]."""
    scene = run.scene
    wavelength, surface = wavelength_bands(centre_lines(heights(scene)), scene.spacing, True)
    own, level = wavelength_bands(run.series["approach"][:-1], scene.step, True)
    filtered = pd.Series(level, 1e3 * own) - pd.Series(surface, 1e3 * wavelength)
    law = scene.surface
    least = 1e-3 * law.shortest_um if isinstance(law, SelfAffineLaw) else 4e3 * scene.step
    return filtered[filtered.index >= least].dropna()


def _beside(published: pd.Series, ours: pd.Series) -> pd.DataFrame:
    """Return both filters [dB] in the bands that both have, and their difference."""
    bands = [
        pd.Series(part.to_numpy(), np.round(10 * np.log10(part.index)))
        for part in (published, ours)
    ]
    rows = pd.concat(bands, axis=1, join="inner", keys=["published_db", "ours_db"])
    rows["difference_db"] = rows["ours_db"] - rows["published_db"]
    return rows.sort_index().assign(wavelength_mm=lambda part: 10 ** (part.index / 10))
