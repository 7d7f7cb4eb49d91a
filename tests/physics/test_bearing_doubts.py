"""Each rule about a bearing is asked, and raises its doubt where it applies."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from bearing_runs import PLATE, WAVY, loads_bearing, solved

from rolling.bearing.band_uncertainty import WINDOW, BandUncertainty
from rolling.bearing.ring_record import DIRECTIONS, RingRecord
from rolling.bearing.tracks import smooth_tracks
from rolling.bearing_kind import bearing_doubts, contact_doubts
from rolling.bearing_kind.bearing_doubts import JudgedBearing
from rolling.bearing_kind.contact_doubts import JudgedContacts
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.bearing_kind.velocities import rigid_velocities, velocities_below_bending
from rolling.numbers.bearing_numbers import HOUSING, MarchedContact
from rolling.numbers.doubt import Doubt, Severity

RATE = 48_000
GAUSSIAN = "{{kind: gaussian, roughness_ra_um: {ra}, correlation_length_um: {length}, seed: 1}}"


def noisy_bearing(*overrides: str) -> SolvedBearing:
    """Return a bearing in a plate with a short record of noise, lost contact and lost energy."""
    balls = {"kind": "graded", "grade": "G10"}
    scene = loads_bearing(WAVY + PLATE, overrides).with_({"bearing.surfaces.balls": balls})
    velocity = 1e-4 * np.random.default_rng(1).standard_normal((RATE // 10, 3))
    record = RingRecord(
        rate_hz=RATE,
        velocity_m_s=velocity,
        acceleration_m_s2=velocity,
        ball_load_n=np.ones((len(velocity), scene.bearing.balls)),
        cage_hz=scene.kinematics.cage_hz,
        energy_error=0.1,
        lost_contact_share=0.05,
    )
    return solved(scene, record, smooth_tracks(scene.geometry))


def judged_bearing(bearing: SolvedBearing) -> JudgedBearing:
    """Return a bearing with a doubt about its contacts, to be judged."""
    no_parts = BandUncertainty()
    return JudgedBearing(
        bearing,
        rigid=rigid_velocities(bearing, no_parts),
        below_bending=velocities_below_bending(bearing, no_parts),
        of_contacts=[Doubt("window", "a short window", Severity.INDICATIVE)],
    )


def test_each_rule_about_a_run_raises_its_doubt() -> None:
    """Dry contacts have an assumed loss factor, and those in oil the viscosity of their films."""
    judged = judged_bearing(noisy_bearing())
    wet = judged_bearing(noisy_bearing("bearing.oil={viscosity_40_mm2_s: 32}"))
    rules = {rule for rule in bearing_doubts.RULES if [*rule(judged)]}
    in_oil = {rule for rule in bearing_doubts.RULES if [*rule(wet)]}
    assert set(bearing_doubts.RULES) - rules == {bearing_doubts.film_damping}
    assert set(bearing_doubts.RULES) - in_oil == {bearing_doubts.assumed_loss_factor}
    found = {doubt.key: doubt for doubt in bearing_doubts.doubts_of(judged)}
    assert {"window", "short_record", "loss_factor", "surfaces"} <= found.keys()
    assert "contact_angle" in found
    assert {"lost_contact", "energy_balance"} <= found.keys()
    assert found["housing_linear"].about == (HOUSING,)
    whole = judged.rigid.radial.high.value
    below = judged.below_bending.radial.high.value
    assert found["ring_bending"].decibels == pytest.approx(20 * math.log10(whole / below))
    assert found["energy_balance"].decibels == pytest.approx(10 / math.log(10) * 0.1)


def judged_contacts(folder: Path, *overrides: str, **changes: object) -> JudgedContacts:
    """Return the contacts of a bearing without marches."""
    plan = contact_plan(loads_bearing(WAVY, overrides, folder=folder))
    contacts = JudgedContacts(plan, [], math.inf, BandUncertainty())
    return contacts._replace(**changes)


def test_each_rule_about_rough_contacts_raises_its_doubt(tmp_path: Path) -> None:
    """No contact is marched; what a march would show is given."""
    heights = 0.1 * np.sin(np.linspace(0, 20 * np.pi, 4000))
    np.savetxt(tmp_path / "turn.csv", np.repeat(heights[:, None], 3, axis=1), delimiter=",")
    turn = "{kind: file, path: turn.csv, height_unit: um, spacing_um: 32.409091}"
    short_lengths = GAUSSIAN.format(ra=0.05, length=2)
    long_lengths = GAUSSIAN.format(ra=0.05, length=20)
    window = {direction: dict.fromkeys(("low", "medium", "high"), 1.2) for direction in DIRECTIONS}
    marched = MarchedContact(
        name="inner",
        load_n=40.0,
        approach_rms_m=1e-7,
        linear_db=0.1,
        approach_loss=0.0,
        stiffness_change=-0.1,
        max_pressure_pa=9e9,
        march_cpu_s=1.0,
    )
    rough = [f"bearing.surfaces.balls={long_lengths}", f"bearing.surfaces.inner={short_lengths}"]
    cases = [
        judged_contacts(
            tmp_path,
            *rough,
            "bearing.surfaces.outer={kind: smooth, waviness: {400: 1}}",
            "numerics={spacing_um: 4, window_mm: 2}",
            marched=[marched],
            hardness_pa=8e9,
            uncertainty=BandUncertainty({WINDOW: window}),
        ),
        judged_contacts(tmp_path, f"bearing.surfaces.outer={turn}"),
    ]
    parted = judged_contacts(tmp_path, *rough, "bearing.oil={viscosity_40_mm2_s: 1000}")
    assert not [*contact_doubts.superposition(parted)]  # the response through a film is linear
    raised = {rule for rule in contact_doubts.RULES for case in cases if [*rule(case)]}
    assert raised == set(contact_doubts.RULES)
    keys = {doubt.key for rule in contact_doubts.RULES for case in cases for doubt in rule(case)}
    assert keys == {
        *("superposition", "narrow_turn", "contact_nodes", "steep_waves", "window"),
        *("unmarched_contacts", "rough_stiffness", "yielding_peaks"),
    }
