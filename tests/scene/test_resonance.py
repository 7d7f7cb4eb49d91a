"""The contact resonance agrees with a hand calculation; its warning weighs speed and surface."""

from __future__ import annotations

import math

import pytest
from scene_text import WIDE

from rolling.check import findings, resonance
from rolling.scene.file import loads


def frequency(*overrides: str) -> float:
    return resonance.frequency(loads(WIDE, overrides))


def warning(*overrides: str) -> str | None:
    return {one.key: one.warning for one in findings.findings(loads(WIDE, overrides))}["resonance"]


def test_frequency_by_hand() -> None:
    # 2 E* a = 2 x 230.77 GPa x 68.75 um = 3.173e7 N/m; 7850 kg/m3 x 4/3 pi (5 mm)^3 = 4.110 g;
    # sqrt(k/m) / 2 pi = 13.98 kHz.
    assert frequency() == pytest.approx(13.98e3, rel=1e-3)


@pytest.mark.parametrize("density", [2500, 3200, 7850, 14900])
def test_frequency_falls_with_the_root_of_the_density(density: float) -> None:
    assert frequency(f"sphere.density_kg_m3={density}") == pytest.approx(
        frequency() * math.sqrt(7850 / density), rel=1e-12
    )


def test_stiffness_is_of_both_bodies_and_elastic() -> None:
    # Two bodies of steel: E* halves, a grows by 2^(1/3), the stiffness falls by 2^(2/3), the
    # frequency by 2^(1/3).
    both = frequency("sphere.youngs_modulus_gpa=210", "sphere.poissons_ratio=0.3")
    assert both == pytest.approx(frequency() / 2 ** (1 / 3), rel=1e-12)
    assert frequency("plate.hardness_gpa=0.5") == frequency("plate.hardness_gpa=") == frequency()


def test_message_says_which_density_was_taken() -> None:
    assert "a free ball as if of steel, 7850 kg/m3 (sphere.density_kg_m3) would bounce" in str(
        warning()
    )
    glass = str(warning("sphere.density_kg_m3=2500", "rolling.load_n=5"))
    assert (
        "a free ball of 2500 kg/m3 would bounce on its contact at 19.7 kHz" in glass
        and "steel" not in glass
    )


def test_warning_weighs_the_speed() -> None:
    """A model of the dynamics at 20 N gives -44 dB at 0.1 m/s, -25 at 0.3 and -6 at 1 m/s."""
    for speed, part in (
        (0.1, "30 dB or more below"),
        (0.3, "its part is heard"),
        (1, "a large part of the sound"),
    ):
        text = str(warning(f"rolling.speed_m_s={speed}"))
        assert f"at {speed} m/s" in text and part in text
    assert "waves of 7.15 um" in str(warning())  # 0.1 m/s over 13.98 kHz
    # Only the maximum speed that the record reaches counts.
    assert "a large part" in str(warning("rolling.speed_m_s=[[0, 0.1], [0.1, 1]]"))
    assert "30 dB or more" in str(warning("rolling.speed_m_s=[[0, 0.1], [5, 0.1], [6, 9]]"))


def test_warning_weighs_the_surface() -> None:
    """Without waves of the resonance there is no warning.

    At 1 m/s and 100 um the model gives -23 dB.
    """
    assert "its part is heard" in str(
        warning("rolling.speed_m_s=1", "surface.correlation_length_um=100")
    )


@pytest.mark.parametrize(
    "overrides",
    [
        ("numerics.step_nodes=4",),  # the steps carry 6.25 kHz
        ("sphere.radius_mm=2",),  # 35 kHz
        ("sphere.density_kg_m3=2500",),  # 24.8 kHz
        # 12.5 kHz at the speed that is reached
        ("rolling.speed_m_s=[[0, 0.05], [1, 0.05], [2, 1]]",),
    ],
)
def test_no_warning_where_the_record_does_not_hold_it(overrides: tuple[str, ...]) -> None:
    assert warning(*overrides) is None


def test_density_is_a_key_of_the_scene_and_absent_by_default() -> None:
    assert "density_kg_m3" not in loads(WIDE).to_dict()["sphere"]
    scene = loads(WIDE, ["sphere.density_kg_m3=2500", "sweep.sphere.density_kg_m3=[2500, 7850]"])
    assert scene.sweep == {"sphere.density_kg_m3": (2500, 7850)}
    assert loads(WIDE, ["sphere.density_kg_m3=3200"]).mass == pytest.approx(
        3200 * 4 / 3 * math.pi * 1.25e-7
    )
