"""A film of oil is as thick as Hamrock and Dowson say, and takes waves as its laws say."""

from __future__ import annotations

from dataclasses import replace
from math import inf, pi, sin
from types import SimpleNamespace

import numpy as np
import pytest
from bearings import bearing, line, model

import rolling
from rolling.bearing import oil_film
from rolling.bearing.band_uncertainty import BandUncertainty
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.oil_film import ContactFilm, FilmContact, Oil, contact_film
from rolling.bearing.ring_motion import move_ring
from rolling.bearing.tracks import smooth_tracks, with_waves
from rolling.bearing_kind.bearing_check import scene_rules
from rolling.bearing_kind.contact_doubts import contact_doubts
from rolling.bearing_kind.contact_plan import ContactPlan, contact_plan
from rolling.bearing_kind.contact_uncertainty import contact_uncertainty
from rolling.bearing_kind.joined_tracks import acting_rows, bearing_tracks
from rolling.marches.piece import contact_identity

LOAD_N = 36.4
SPEED_M_S = 1.494


def film(ring: str, viscosity_mpa_s: float) -> FilmContact:
    """Return a contact of a 6204 at 70 N and 1,800 rpm in an oil of 18 /GPa."""
    oil = Oil(1e-3 * viscosity_mpa_s, 18e-9)
    return FilmContact(getattr(bearing(), ring), LOAD_N, SPEED_M_S, oil)


@pytest.mark.law("Oil: films are as thick as Hamrock and Dowson say.")
def test_films_of_a_6204() -> None:
    """Thickness at 10, 20, 50 and 100 mPa s by another program, to its two digits."""
    wanted = {"inner": [0.10, 0.16, 0.29, 0.46], "outer": [0.12, 0.20, 0.36, 0.57]}
    for ring, thickness_um in wanted.items():
        found = [1e6 * film(ring, viscosity).thickness_m for viscosity in (10, 20, 50, 100)]
        assert found == pytest.approx(thickness_um, abs=0.01)
    faster = FilmContact(bearing().inner, LOAD_N, 2 * SPEED_M_S, Oil(20e-3, 18e-9))
    assert faster.thickness_m / film("inner", 20).thickness_m == pytest.approx(2**0.67)


@pytest.mark.law("Oil: viscosity follows Walther's line over temperature.")
def test_viscosity_at_a_temperature() -> None:
    """A spindle oil of 30 and 5.23 mm2/s at 40 and 100 degrees has 14.5 at 60 (libvisc).

    That program adds 0.8 mm2/s as DIN 51563 does, and not 0.7.
    """
    slope = oil_film.viscosity_slope(30.0, 5.23)
    found = [oil_film.kinematic_viscosity_mm2_s(t, 30.0, slope) for t in (40, 60, 100)]
    assert found == pytest.approx([30.0, 14.525, 5.23], rel=0.01)
    assert oil_film.kinematic_viscosity_mm2_s(20, 30.0) > 70  # 1.65 mm2/s colder by a degree


@pytest.mark.law("Oil: a film presses long waves flat and leaves short ones as they are.")
def test_waves_in_a_film() -> None:
    """Shares that press by both laws, at 150 um; long waves act as in a dry contact."""
    shares = {
        (ring, viscosity): film(ring, viscosity).pressed_shares(np.array([150e-6]))
        for ring in ("inner", "outer")
        for viscosity in (20, 100)
    }
    for ring in ("inner", "outer"):
        circular, line = (float(share[0]) for share in shares[ring, 20])
        assert 0.8 < circular < 0.95 and 0.5 <= line < 0.65
        circular, line = (float(share[0]) for share in shares[ring, 100])
        assert 0.55 < circular < 0.8 and 0.2 < line < 0.35
    waves = np.array([1e-6, 1e-5, 1e-4, 1e-3, 1.0, inf])
    for share in film("outer", 50).pressed_shares(waves):
        assert np.all(np.diff(share) > 0)
        assert share[0] < 0.1
        assert share[-2] == pytest.approx(1.0, abs=1e-3) and share[-1] == 1.0


def test_a_film_has_the_weight_of_its_ratio() -> None:
    weights = [oil_film.film_weight(ratio) for ratio in (0.2, 1.0, 2.0, 3.0, inf)]
    assert weights == [0.0, 0.0, 0.5, 1.0, 1.0]
    contact = bearing().inner
    thick: ContactFilm = contact_film(contact, LOAD_N, SPEED_M_S, Oil(50e-3, 18e-9), 0.05e-6)
    assert thick.ratio == pytest.approx(0.294 / 0.05, rel=0.01)
    assert contact_film(contact, LOAD_N, SPEED_M_S, thick.oil, 0.0).ratio == inf


# ---- bearings in oil


def scene(**oil: float) -> rolling.BearingScene:
    """Return a 608 with rough raceways on a short window, in an oil."""
    rough = {"kind": "gaussian", "roughness_ra_um": 0.02, "correlation_length_um": 30}
    return rolling.BearingScene(
        bearing={
            "named": "608",
            "speed_rpm": 1800,
            "axial_load_n": 20,
            "angle": "fixed",
            "ring": "rigid",
            "surfaces": {
                "inner": rough | {"seed": 1, "waviness": {150: 0.01}},
                "outer": rough | {"seed": 2},
            },
            "oil": oil or None,
        },
        numerics={"window_mm": 1, "spacing_um": 4},
    )


def marched(plan: ContactPlan) -> dict[str, SimpleNamespace]:
    """Return marches of the contacts of a plan, as if half of the linear response came through."""
    return {
        contact_identity(contact.at_load(load)): SimpleNamespace(approach_m=0.5 * row)
        for contact in plan.rough.values()
        for load, row in zip(contact.loads_n, contact.own_linear_rows, strict=True)
    }


THIN = {"viscosity_40_mm2_s": 2.5, "temperature_c": 90, "viscosity_100_mm2_s": 1.2}
THICK = {"viscosity_40_mm2_s": 68}


@pytest.mark.law("Oil: a film that leaves nothing of waves acts as the dry linear contact.")
def test_a_film_that_presses_all_waves_is_the_linear_bearing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The march of touching surfaces has no part in it."""
    plan = contact_plan(scene(**THICK))
    assert all(film.weight == 1.0 for film in plan.films.values())
    assert plan.stages == [[], [], []]  # so it is not made
    uncertainty = BandUncertainty()
    doubts = contact_doubts(plan, {}, inf, uncertainty)
    assert "unmarched_contacts" not in [doubt.key for doubt in doubts]
    doubts = contact_doubts(replace(plan, films={}), {}, inf, uncertainty)
    assert "unmarched_contacts" in [doubt.key for doubt in doubts]
    dry = bearing_tracks(replace(plan, films={}))  # linear, because nothing is marched

    def all_pressed(self: FilmContact, waves_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.ones_like(waves_m), np.ones_like(waves_m)

    monkeypatch.setattr(FilmContact, "pressed_shares", all_pressed)
    wet = bearing_tracks(plan, marched(plan))
    for ring in ("inner", "outer"):
        expected = getattr(dry, ring).approach_m
        np.testing.assert_allclose(getattr(wet, ring).approach_m, expected, atol=1e-15)


@pytest.mark.law("Oil: each wave acts by its linear response times the share that is pressed.")
def test_waves_act_through_a_film() -> None:
    """The order 150 of the inner raceway has 0.3 mm, where both laws leave something of it."""
    plan = contact_plan(scene(**THICK))
    contact = plan.rough["inner"]
    rows = acting_rows(plan, contact, marched(plan))
    length = contact.steps * contact.scene.step
    waves = length / np.arange(1, contact.steps // 2)
    for place, load in enumerate(contact.loads_n):
        circular, line_share = plan.films["inner"].at_load(load).pressed_shares(waves)
        wet = np.fft.rfft(rows[place])[1 : contact.steps // 2]
        linear = np.fft.rfft(contact.own_linear_rows[place])[1 : contact.steps // 2]
        np.testing.assert_allclose(wet, np.sqrt(circular * line_share) * linear, atol=1e-13)
    dry = bearing_tracks(replace(plan, films={}, rough={})).inner.approach_m
    wet = bearing_tracks(replace(plan, rough={})).inner.approach_m
    share = np.abs(np.fft.rfft(wet[0])[150]) / np.abs(np.fft.rfft(dry[0])[150])
    wave = np.array([2 * pi * plan.geometry.inner.radius_m / 150])
    pressed = plan.films["inner"].at_load(plan.loads_n[0]).pressed_shares(wave)
    assert share == pytest.approx(float(np.sqrt(pressed[0] * pressed[1])[0]), rel=1e-6)
    assert share < 0.9


@pytest.mark.law("Oil: where surfaces touch, the march is as it is; between, both are mixed.")
def test_thin_films_leave_the_march() -> None:
    plan = contact_plan(scene(**THIN))
    assert all(film.ratio < 1 for film in plan.films.values())
    assert len(plan.stages[1]) == 2
    marches = marched(plan)
    contact = plan.rough["outer"]
    dry = acting_rows(replace(plan, films={}), contact, marches)
    np.testing.assert_array_equal(acting_rows(plan, contact, marches), dry)
    half = {ring: replace(film, ratio=2.0) for ring, film in plan.films.items()}
    full = {ring: replace(film, ratio=9.0) for ring, film in plan.films.items()}
    mixed = acting_rows(replace(plan, films=half), contact, marches)
    wet = acting_rows(replace(plan, films=full), contact, marches)
    np.testing.assert_allclose(mixed, (dry + wet) / 2, atol=1e-15)


@pytest.mark.law("Oil: the ± of a band has what the laws and the mixing of films leave open.")
def test_films_are_a_part_of_the_uncertainty() -> None:
    """Laws disagree by decibels on short waves; mixing adds the range of march and film."""
    case = scene(**THICK)
    plan = contact_plan(case)
    marches = marched(plan)
    bands = SimpleNamespace(rms_m_s=dict.fromkeys(("low", "medium", "high"), 0.0))
    record = SimpleNamespace(bands={"radial": bands, "axial": bands})
    parts = {}
    for name, ratio in (("full", 9.0), ("mixed", 2.0)):
        films = {ring: replace(film, ratio=ratio) for ring, film in plan.films.items()}
        uncertainty = contact_uncertainty(replace(plan, films=films), marches, case.model, record)
        parts[name] = uncertainty.of_band("radial", "high")["film"]
    assert 0.5 < parts["full"] < 6
    assert parts["mixed"] > 0.5


@pytest.mark.law("Oil: a film damps each resonance by its time, beside the loss factor.")
def test_a_film_damps_the_ring() -> None:
    """At the axial resonance the quality is 1 / (eta + omega tau)."""
    case = model(contact_loss_factor=0.02, film_time_s=oil_film.TIME_S, turns_hz=1.0)
    ring = linear_ring(case)
    turns = ring.axial_hz / case.kinematics.ball_pass_inner_hz
    case = model(contact_loss_factor=0.02, film_time_s=oil_film.TIME_S, turns_hz=turns)
    waves = with_waves(smooth_tracks(case.geometry), inner={case.geometry.balls: 1e-9})
    seen = move_ring(case, waves, 0.05).velocity_m_s[:, 2]
    omega = 2 * pi * ring.axial_hz
    force = ring.stiffness_n_m[2, 2] * 1e-9 / sin(case.geometry.contact_angle)
    quality = abs(line(seen, ring.axial_hz)) * ring.mass_kg * omega / force
    assert quality == pytest.approx(1 / (0.02 + omega * oil_film.TIME_S), rel=0.01)


def test_check_states_films_and_what_is_assumed() -> None:
    rows = {row.key: row for row in scene_rules(scene(**THICK))}
    assert rows["inner_film"].value.endswith("lambda 5.8")
    assert "oil.viscosity_100_mm2_s" in rows["assumed"].text
    assert "mixed_film" not in rows
    touching = [row.key for row in scene_rules(scene(viscosity_40_mm2_s=5, temperature_c=40))]
    assert "mixed_film" in touching


def test_oils_that_do_not_fit_are_refused() -> None:
    with pytest.raises(rolling.SceneError, match="below viscosity_40_mm2_s"):
        scene(viscosity_40_mm2_s=10, viscosity_100_mm2_s=10)
