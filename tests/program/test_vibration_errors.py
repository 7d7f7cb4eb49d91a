"""Errors of the levels of a vibration: from grid, solver and force law."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rolling.check import error_cost
from rolling.commands import Wanted, resound, run
from rolling.commands.interface import open_run, simulate
from rolling.scene.file import loads
from rolling.simulation import run_errors
from rolling.simulation.stored_runs import read_runs

ALONE = Wanted(workers=1, page=False, pictures=False)

TEXT = """\
name: judged
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 10}
surface: {kind: gaussian, roughness_ra_um: 0.05, correlation_length_um: 10, spacing_um: 2,
  width_um: 120, seed: 3}
rolling: {load_n: 0.5, speed_m_s: 0.1, distance_mm: 0.4}
numerics: {error_estimate: true}
dynamics: {}
sound: {source: vibration}
sweep: {rolling.speed_m_s: [0.1, 0.2]}
"""


@pytest.fixture(autouse=True, scope="module")
def generous() -> None:
    """Let short runs pay for four stretches."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(error_cost, "SHARE", 3.0)
        patch.setattr(error_cost, "STRETCH_STEPS", (16, 50))
        yield


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("judged")
    (folder / "scene.yaml").write_text(TEXT)
    run(folder / "scene.yaml", out=folder / "out", wanted=ALONE)
    return folder / "out"


def test_levels_have_errors_of_grid_solver_and_force_law(swept: Path) -> None:
    for each in read_runs(swept):
        summary = json.loads((each.folder / "summary.json").read_text())
        parts = summary["laeq_uncertainty_parts_db"]
        assert set(parts) == {"record", "grid", "solver", "force_law"}
        assert parts["force_law"] == summary["force_law_error_db"]
        assert summary["laeq_uncertainty_db"] == pytest.approx(
            np.sqrt(sum(part**2 for part in parts.values()))
        )
        assert 0 < parts["solver"] < parts["grid"] < 6
        assert summary["error_estimate"]["stretches"] >= 4
        texts = {caveat["key"]: caveat["text"] for caveat in summary["caveats"]}
        assert "Errors of grid, solver and force law are estimated" in texts["uncertainty"]
        assert "resolution" not in summary["grid_error_db"]


def test_runs_of_one_march_share_their_stretches(swept: Path) -> None:
    results = [open_run(each.folder).result for each in read_runs(swept)]
    marches = [result.stretches.marches for result in results if result.stretches]
    assert marches[0].keys() == marches[1].keys()
    for key, march in marches[0].items():
        assert march.seconds == marches[1][key].seconds  # marched once
        assert march.approach.shape == (march.steps + 1,)
    alone = simulate(read_runs(swept)[1].scene, 1, False)
    stored = open_run(read_runs(swept)[1].folder)
    for key in ("laeq_grid_error_db", "laeq_solver_error_db", "laeq_grid_error_uncertainty_db"):
        assert alone.summary[key] == stored.summary[key]


def test_another_speed_has_its_own_errors_from_the_same_stretches(
    swept: Path, tmp_path: Path
) -> None:
    own = read_runs(swept)[0].folder
    resound(own, ["rolling.speed_m_s=0.3"], tmp_path / "faster", wanted=ALONE)
    before, after = open_run(own).summary, open_run(tmp_path / "faster").summary
    assert after["laeq_grid_error_db"] != before["laeq_grid_error_db"]
    # The short waves are the grid's, and a faster ball does not hear them.
    assert after["grid_signal_db"] < before["grid_signal_db"]


def test_no_estimate_where_contact_is_lost() -> None:
    changes = ["sweep=", "rolling.speed_m_s=1", "surface.roughness_ra_um=0.3"]
    bouncing = simulate(loads(TEXT, [*changes, "surface.width_um=160"]), 1, False)
    assert bouncing.summary["impacts"] > 0
    texts = {caveat["key"]: caveat["text"] for caveat in bouncing.summary["caveats"]}
    assert "contact is lost, and no linear chain" in texts["no_error_estimate"]
    assert bouncing.summary["laeq_uncertainty_db"] is None
    assert "it holds no error of model, grid or solver" in texts["uncertainty"]


@pytest.mark.parametrize(("share", "rms", "said"), [(0.0, 0.1, ""), (0.0, 0.4, "0.4 of the load")])
def test_an_estimate_needs_small_fluctuations(share: float, rms: float, said: str) -> None:
    """Near lift-off the level on one grid says nothing about that on another."""
    vibration = SimpleNamespace(motion=SimpleNamespace(flight_share=share), rms_ratio=rms)
    reason = run_errors._not_linear(vibration)
    assert said in reason and bool(reason) == bool(said)
