"""What assumed values of a bearing are worth, against the mass and the spring of its ring."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from bearing_runs import WAVY, loads_bearing

from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.assumed_surfaces import FORM_DB, assumptions_db
from rolling.bearing.linear_ring import LinearRing, linear_ring
from rolling.bearing_kind.assumed_worth import assumed_doubt, assumed_worth, band_changes_db
from rolling.bearing_kind.band_edges import edge_doubts, moved_edges
from rolling.bearing_kind.body_forms import assumed_waves

SCENE = loads_bearing(WAVY)


@pytest.mark.law("Assumed values: a mass rules above the resonance, and nothing below it.")
def test_a_heavier_ring_moves_less_above_its_resonance() -> None:
    """A fifth more mass is 1.6 dB far above, and below it hardly moves the resonance."""
    model = SCENE.model
    resonance_hz = linear_ring(model).radial_hz
    bands = {"below": (50.0, resonance_hz / 30), "above": (30 * resonance_hz, 40 * resonance_hz)}
    heavier = replace(model, ring_mass_kg=1.2 * model.ring_mass_kg)
    changes = band_changes_db(model, heavier, bands)
    assert changes["below"] == pytest.approx(0.0, abs=0.01)
    assert changes["above"] == pytest.approx(-20 * np.log10(1.2), abs=0.01)


@pytest.mark.law("Assumed values: five times the loss factor take 7 dB from a band of a resonance.")
def test_a_loss_factor_is_worth_its_share_of_the_resonance() -> None:
    worth = assumed_worth(SCENE, "contact_loss_factor")
    assert worth is not None
    assert worth.change_db["low"] == pytest.approx(0.0, abs=0.01)
    assert worth.change_db["high"] == pytest.approx(-10 * np.log10(5), abs=0.7)
    assert worth.words.startswith("contact_loss_factor (at 0.1: +0.0, +0.0, -")


def test_the_doubt_names_the_largest_first_and_no_given_value() -> None:
    doubt = assumed_doubt(SCENE)
    assert doubt is not None
    assert doubt.text.index("contact_loss_factor") < doubt.text.index("ring_mass_kg")
    given = SCENE.with_({"bearing.contact_loss_factor": 0.05, "bearing.ring_mass_kg": 0.06})
    rest = assumed_doubt(given)
    assert rest is None or ("loss_factor" not in rest.text and "ring_mass" not in rest.text)


def test_assumed_surfaces_have_their_decibels_the_largest_first() -> None:
    """The form of balls alone has the whole of what a grade leaves, 20 log10(3) / sqrt(3)."""
    graded = SCENE.with_({"bearing.surfaces.balls": {"kind": "graded", "grade": "G10"}})
    (waves,) = assumed_waves(graded)
    worth = assumptions_db([waves], graded.model, VELOCITY_BANDS_HZ)
    assert worth["balls", "amplitude"]["low"] == pytest.approx(FORM_DB)
    doubt = assumed_doubt(graded)
    assert doubt is not None
    assert "surfaces.balls.grade (± 5.5, 5.5, " in doubt.text
    places = [doubt.text.index(key) for key in ("loss_factor", "surfaces.balls.grade", "ring_mass")]
    assert places == sorted(places)


def test_assumed_roughness_has_its_decibels_too() -> None:
    """Much where waves are small, less than 0.1 dB beside those of its finish.

    A Ra of 0.02 um is read with a shorter cut-off, so its range has less than 3.5 dB.
    """
    finish = {"kind": "raceway", "finish": "honed"}
    rough = SCENE.with_({"bearing.surfaces.inner": finish})
    doubt = assumed_doubt(rough)
    assert doubt is not None
    assert "surfaces.inner.correlation_length_um (less than 0.1 dB)" in doubt.text
    smooth = SCENE.with_({"bearing.surfaces.inner": finish | {"wave_amplitude_um": 1e-4}})
    doubt = assumed_doubt(smooth)
    assert doubt is not None
    assert "surfaces.inner.roughness_ra_um (± 2.8, " in doubt.text
    assert "wave_amplitude_um" not in doubt.text


def test_a_value_that_the_scene_does_not_take_has_no_worth() -> None:
    """A clearance beside a given contact angle is refused, so that none is stated."""
    assert assumed_worth(SCENE, "radial_clearance_um") is None
    assert assumed_worth(SCENE, "width_mm") is None


@pytest.mark.law("Edges of bands: they matter where a resonance stands at one, and nowhere else.")
def test_a_band_depends_on_an_edge_with_a_resonance() -> None:
    """A sharp resonance just beyond an edge comes into the band with it."""

    def ring_at(hz: float) -> LinearRing:
        stiffness = 0.05 * (2 * np.pi * hz) ** 2 * np.eye(3)
        return LinearRing(
            masses=np.full(3, 0.05),
            stiffness_n_m=stiffness,
            springs_n_m=np.zeros(3),
            loss_factor=0.02,
        )

    moved = list(moved_edges(ring_at(1850.0)))
    assert {(edge.direction, edge.band) for edge in moved} >= {
        ("radial", "medium"),
        ("axial", "medium"),
    }
    assert max(edge.change_db for edge in moved) > 3
    assert not list(moved_edges(ring_at(5000.0)))
    assert not list(moved_edges(ring_at(40_000.0)))


def test_the_check_says_what_an_edge_is_worth() -> None:
    """The axial resonance of this 6204 under 70 N is 1.9 kHz, beside the edge at 1,800 Hz."""
    texts = " ".join(doubt.text for doubt in edge_doubts(SCENE))
    wanted = "the axial resonance at 1.9 kHz makes the medium band depend on its edge at 1.8 kHz"
    assert wanted in texts
