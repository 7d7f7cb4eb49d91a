"""Smooth spheres are silent and real surfaces are not, by the solver's error."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import march_all
from scene_sounds import sound_of_release

from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import (
    ContactSound,
    resolved_fluctuation,
    solver_doubt,
)

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
    """March a scene, and make the sound of its release."""
    energy = march_all(scene).whole_series("release_energy")
    return sound_of_release(scene, energy, scene.track.step, scene.track.closed)


@pytest.mark.law("Silence: a record within the solver's error is silent.")
@pytest.mark.parametrize(
    "overrides",
    [
        (),
        ("rolling.speed_m_s=[[0, 0], [0.004, 0.24]]",),
        (YIELDING, "numerics.tolerance=1e-7"),
        (*BELOW_A_NODE, "numerics.tolerance=1e-3"),
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


@pytest.mark.slow
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


def test_a_release_below_the_solver_error_is_silent_and_says_so() -> None:
    """At Ra 1e-12 m and the default tolerance the release is off by its whole fluctuation."""
    scene = loads(ROUGH.replace("RA", "0.000001"), ["numerics.tolerance=1e-4"])
    sound = heard(scene)
    assert sound.levels.level_db is None
    doubt = solver_doubt(scene.tolerance, sound.audible_rms, sound.resolved_rms)
    assert doubt is not None and "silent" in doubt and "numerics.tolerance" in doubt


def test_doubts_by_the_distance_from_the_error() -> None:
    assert "stands 6 dB above the solver's error" in str(solver_doubt(1e-4, 2.0, 1.0))
    assert "counts as silent" in str(solver_doubt(1e-4, 1.0, 1.0))
    assert solver_doubt(1e-4, 3.2, 1.0) is None
    assert solver_doubt(1e-4, 0.0, 0.0) is None


@pytest.mark.parametrize("speed", ["0.01", "3", "[[0, 0], [0.01, 0.5], [0.011, 0.02]]"])
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
        energy = 1e-9 * (1 + factor * resolved_fluctuation(scene.tolerance) * noise)
        sound = sound_of_release(scene, energy, 3e-6, closed)
        assert sound.audible_rms == pytest.approx(factor * sound.resolved_rms, rel=0.2)
        assert (sound.levels.level_db is None) == (factor < 1)


def test_a_quiet_scene_is_not_a_silent_one() -> None:
    """Distance and radiated share change the levels but not the resolution."""
    energy = 1e-9 * (1 + 0.1 * np.random.default_rng(1).standard_normal(220))
    scene = loads(SMOOTH)
    far = scene.with_({"sound.distance_m": 1e4, "sound.q": 1e-6})
    near, distant = (sound_of_release(place, energy, 2e-6, True) for place in (scene, far))
    assert near.audible_rms == pytest.approx(distant.audible_rms, rel=1e-12)
    # 10 lg of 1e-14
    assert distant.levels.level_db == pytest.approx(near.levels.level_db - 140, abs=1e-6)
