"""Smooth spheres are silent and real surfaces are not, by the solver's error."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from acoustics import wav
from rolling import cli
from rolling.commands import work
from rolling.scene.file import loads, read_scene
from rolling.scene.scene import Scene
from rolling.simulation import simulate
from rolling.sound import solver_error
from rolling.sound.contact_sound import ContactSound, contact_sound

SMOOTH = """\
name: smooth
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: smooth, spacing_um: 3, width_um: 180}
rolling: {load_n: 5, speed_m_s: 0.12, duration_s: 0.0055}
"""  # 43.3 um of Hertz radius, 220 steps: a border between pieces
ROUGH = SMOOTH.replace(
    "kind: smooth", "kind: gaussian, seed: 1, correlation_length_um: 12, roughness_ra_um: RA"
).replace("0.0055", "0.003")
# a tone of the grid at 40 kHz
BELOW_A_NODE = ("numerics.step_nodes=0.5", "rolling.duration_s=0.003")
YIELDING = "plate.hardness_gpa=0.9"  # 1.27 GPa of Hertz pressure


def heard(scene: Scene) -> ContactSound:
    """Solve a scene piece by piece, as a run does."""
    way = scene.track
    energy = np.concatenate(
        [
            simulate.simulate_piece(scene, a, b, mapped=False).steps["release_energy"]
            for a, b in simulate.pieces(way.steps)
        ]
    )
    return contact_sound(scene, energy, way.step, way.closed)


@pytest.mark.law("Silence: a record within the solver's error is silent.")
@pytest.mark.parametrize(
    "overrides",
    [
        (),
        ("numerics.tolerance=1e-3",),
        ("numerics.tolerance=1e-6",),
        ("rolling.speed_m_s=[[0, 0], [0.004, 0.24]]",),
        (YIELDING, "numerics.tolerance=1e-7"),
        BELOW_A_NODE,
        (*BELOW_A_NODE, "numerics.tolerance=1e-3"),
        (*BELOW_A_NODE, "numerics.tolerance=1e-7"),
        (*BELOW_A_NODE, YIELDING),
        (*BELOW_A_NODE, "rolling.speed_m_s=[[0, 0.12], [0.003, 0.36]]"),
        ("numerics.step_nodes=53", "rolling.speed_m_s=7", "rolling.duration_s=0.0018"),
    ],
)
def test_a_smooth_sphere_is_silent(overrides: tuple[str, ...]) -> None:
    """It is silent in steps of 53 nodes too, which are 3.7 contact radii."""
    sound = heard(loads(SMOOTH, overrides))
    assert sound.levels.level_db is None and sound.factor == 0 and not sound.pressure.any()
    assert sound.audible_rms < sound.resolved_rms
    assert sound.steady_level is not None and sound.mean_power > 0


def test_the_sphere_of_the_scenarios_is_silent_at_the_default_tolerance(
    tmp_path: Path, monkeypatch
) -> None:
    """An earlier version gave -37.6 dB(A), and rounding at -14 dB of full scale to listen to."""
    path = Path(__file__).parents[2] / "scenarios" / "smooth.yaml"
    out = tmp_path / "out"
    monkeypatch.setattr(work, "write_pictures", lambda *_: [])
    settings = [
        "--set",
        "numerics.tolerance=1e-4",
        "--workers",
        "1",
        "--no-report",
        "--out",
        str(out),
    ]
    assert cli.main(["run", str(path), *settings]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert (
        summary["laeq_db"] is None
        and summary["level_db"] is None
        and summary["factor_pa_per_w_m2"] == 0
    )
    samples, _, comment = wav.read(out / "listen.wav")
    assert not samples.any() and "silence" in comment
    beside = json.loads((out / "listen.json").read_text())
    assert beside["gain_full_scale_per_pa"] == 1 and "the record is silent" in beside["meaning"]


@pytest.mark.parametrize(("ra_um", "tolerance"), [(1e-6, 1e-8), (1e-4, 1e-6), (1e-2, 1e-4)])
def test_roughness_of_atoms_and_less_is_heard_where_it_is_resolved(
    ra_um: float, tolerance: float
) -> None:
    """A solve ten times tighter has the same level within 0.1 dB.

    The error of the solver is 39 dB below the sound or more.
    """
    level, tighter = (
        heard(loads(ROUGH.replace("RA", f"{ra_um:f}"), [f"numerics.tolerance={t}"])).levels.level_db
        for t in (tolerance, tolerance / 10)
    )
    assert level is not None and tighter is not None
    assert level == pytest.approx(tighter, abs=0.2)


def test_what_is_not_resolved_is_silent_and_said() -> None:
    """At Ra 1e-12 m and the default tolerance the release is off by its whole fluctuation."""
    scene = loads(ROUGH.replace("RA", "0.000001"))
    sound = heard(scene)
    assert sound.levels.level_db is None
    doubt = solver_error.doubt(scene, sound.audible_rms, sound.resolved_rms)
    assert (
        doubt is not None and "counts as silent; a lower numerics.tolerance, 0.0001 here" in doubt
    )


def test_doubts_by_the_distance_from_the_error() -> None:
    rough, smooth = loads(ROUGH.replace("RA", "0.1")), loads(SMOOTH)
    assert "stands 6 dB above the solver's error" in str(solver_error.doubt(rough, 2.0, 1.0))
    assert "counts as silent" in str(solver_error.doubt(rough, 1.0, 1.0))
    assert solver_error.doubt(rough, 3.2, 1.0) is None
    assert solver_error.doubt(smooth, 0.5, 1.0) is None


@pytest.mark.parametrize(
    "speed", ["0.01", "0.12", "3", "[[0, 0.1], [0.05, 3]]", "[[0, 0], [0.01, 0.5], [0.011, 0.02]]"]
)
@pytest.mark.parametrize("closed", [True, False])
def test_an_error_that_is_white_along_the_track_is_known_in_the_band(
    speed: str, closed: bool
) -> None:
    """White noise of twice the resolved rms is audible, and of half of it silent.

    This holds at any speed, with 3 % of spread from 5000 steps. The band from 20 Hz, fades of a
    tenth and few lines within hearing change the rms by up to a fifth.
    """
    scene = loads(SMOOTH, [f"rolling.speed_m_s={speed}", "rolling.duration_s=1"])
    noise = np.random.default_rng(1).standard_normal(5000)
    for factor in (0.5, 2.0):
        energy = 1e-9 * (1 + factor * solver_error.resolved_fluctuation(scene) * noise)
        sound = contact_sound(scene, energy, 3e-6, closed)
        assert sound.audible_rms == pytest.approx(factor * sound.resolved_rms, rel=0.2)
        assert (sound.levels.level_db is None) == (factor < 1)


def test_edges_leave_no_error_of_their_own() -> None:
    """Blended edges have no memory of a start: the tolerance alone decides the resolution."""

    def resolved(*overrides: str) -> float:
        return solver_error.resolved_fluctuation(
            loads(SMOOTH, ["numerics.tolerance=1e-8", *overrides])
        )

    for overrides in ((), (YIELDING,), (YIELDING, "numerics.step_nodes=0.5")):
        assert resolved(*overrides) == pytest.approx(2e-7)


def test_a_quiet_scene_is_not_a_silent_one() -> None:
    """Distance and radiated share change the levels but not the resolution."""
    energy = 1e-9 * (1 + 0.1 * np.random.default_rng(1).standard_normal(220))
    scene = read_scene(Path(__file__).parents[2] / "scenarios" / "smooth.yaml")
    far = Scene.from_dict(scene.to_dict() | {"sound": {"distance_m": 1e4, "q": 1e-6}})
    near, distant = (contact_sound(one, energy, 2e-6, True) for one in (scene, far))
    assert near.audible_rms == pytest.approx(distant.audible_rms, rel=1e-12)
    # 10 lg of 1e-14
    assert distant.levels.level_db == pytest.approx(near.levels.level_db - 140, abs=1e-6)
