"""The contact filter of wheel and rail is a ratio of levels, and near the table of CNOSSOS-EU."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import rolling
from rolling.in_si import scene_surface
from rolling.in_si.measured import HeightArray
from rolling.scene.scene import Scene
from rolling.studies import validate

FOLDER = Path(__file__).parents[2] / "scenarios" / "validation"
TABLE = validate.published_filters(str(FOLDER / "contact_filter.csv"))


def short() -> Scene:
    """Return the scene with two tracks that are 100 mm wide."""
    scene = rolling.read_scene(FOLDER / "wheel-rail.yaml")
    narrow = {"surface.width_um": 102400, "surface.rolloff_um": 100000}
    return scene.with_(narrow | {"sweep": {"surface.seed": [1, 2]}})


def halved(scene: Scene, heights: Any) -> Any:
    """Return a run whose approach is half of the heights under the centre."""
    if heights is not None:
        scene = scene.with_(surface=HeightArray(heights, spacing_um=scene.spacing_um))
    lines = validate.centre_lines(scene_surface.heights(scene))
    approach = 0.5 * lines[::2, 0]
    return SimpleNamespace(scene=scene, series={"approach": np.append(approach, approach[0])})


@pytest.mark.slow
def test_half_of_the_heights_is_6_db_below(monkeypatch: pytest.MonkeyPatch) -> None:
    """On ridges all lines are the same and the filter is -6.02 dB, up to the aliases of the steps.

    On the isotropic surface the level of two lines differs from that of one by 1.7 dB at most.
    """
    monkeypatch.setattr(validate, "_run", halved)
    rows = validate.wheel_on_rail(short(), TABLE)
    conditions = rows.groupby(["load_kn", "wheel_mm", "sample", "surface"]).ngroups
    assert conditions == TABLE.shape[1] * 3  # ridges of the first surface only
    within = rows[rows["wavelength_mm"] > 7]
    ridges = within[within["surface"] == "ridges"]
    assert ridges["ours_db"].to_numpy() == pytest.approx(-6.02, abs=0.1)
    assert within["ours_db"].to_numpy() == pytest.approx(-6.02, abs=2.0)
    difference = rows["ours_db"] - rows["published_db"]
    np.testing.assert_array_equal(rows["difference_db"], difference)


def test_a_table_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A user's table has any loads and wheels; the runs have them."""
    file = tmp_path / "mine.csv"
    file.write_text("kN,62.5,80\nmm,840,1200\n20,-9,-10\n10,-18,-17\n")
    conditions = []

    def noted(scene: Scene, heights: Any = None) -> Any:
        conditions.append((scene.rolling.load_n, scene.sphere.radius_mm))
        return halved(scene, heights)

    monkeypatch.setattr(validate, "_run", noted)
    rows = validate.wheel_on_rail(short(), validate.published_filters(str(file)))
    assert {*conditions} == {(62500.0, 420.0), (80000.0, 600.0)}
    assert len(rows) == 2 * 3 * 2 and {*rows["published_db"]} == {-9, -18, -10, -17}


def test_loads_and_wheels_without_a_table_have_filters(monkeypatch: pytest.MonkeyPatch) -> None:
    """A column of NaN has ours and no difference; the rms is of the filter averaged over runs."""
    monkeypatch.setattr(validate, "_run", halved)
    published = TABLE[[(50.0, 920.0)]].copy()
    published[25.0, 840.0] = np.nan
    rows = validate.wheel_on_rail(short(), published)
    ours = rows.set_index(["load_kn", "surface", "sample", "wavelength_mm"])["ours_db"]
    assert np.isfinite(ours).all() and ours.loc[25.0].equals(ours.loc[50.0])
    summary = validate.differences(rows)
    assert summary.loc[25.0].isna().all(axis=None)
    within = rows[(rows["load_kn"] == 50) & (rows["surface"] == "isotropic")]
    within = within[within["wavelength_mm"].between(7.9, 100)]
    mean = within.groupby("wavelength_mm")["difference_db"].mean()
    assert len(mean) == 12
    expected = [np.sqrt(np.mean(mean**2)), mean.mean()]
    assert [*summary.loc[50.0, 920.0, "isotropic"]] == pytest.approx(expected)


@pytest.mark.slow
def test_elliptic_contact_is_near_the_table() -> None:
    """The rms is below the change of the table by one band, 2.2 dB."""
    rows = validate.wheel_on_rail(short(), TABLE[[(50.0, 920.0)]])
    assert validate.differences(rows).loc[(50.0, 920.0, "isotropic"), "rms_db"] < 2.2
