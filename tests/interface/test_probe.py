"""The solved positions of check agree with a march of the same scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from checked import Row, checked

from acoustics.arrays import Array
from rolling.check import findings, probe
from rolling.contact import march
from rolling.contact.subcells import half_space_of
from rolling.in_si import contact_of_scene
from rolling.scene import file
from rolling.scene.scene import Scene

TEXT = """\
name: trial
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 160, seed: 1}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.008}
"""


def scene(*overrides: str) -> Scene:
    return file.loads(TEXT, overrides)


def solved_values(got: probe.Probe, name: str) -> Array:
    """Return a quantity of all solved positions."""
    return np.array([getattr(position, name) for position in got.solved])


def solved(given: Scene) -> dict[str, Row]:
    return {finding.key: finding for finding in checked(given, *probe.probes([given]))}


def test_a_scene_below_the_hertz_limit_yields_at_its_asperities() -> None:
    """Asperities yield at 1 N, where Hertz's pressure is 0.75 GPa and the hardness 2.1 GPa."""
    closed_forms = {finding.key: finding for finding in checked(scene())}
    assert closed_forms["hardness"].value == (
        "2.1 GPa, above the Hertz pressure of a smooth sphere; asperities may yield"
    )
    assert "contact_area" not in closed_forms
    got = solved(scene())
    assert got["hardness"].value.startswith("2.1 GPa, yields on ")
    assert got["positions"].value == "8 of 8"
    assert got["max_pressure"].value == "2.1 GPa"
    smooth = solved(scene("surface.roughness_ra_um=1e-6"))
    assert smooth["hardness"].value == "2.1 GPa, stays elastic where solved"
    assert smooth["plastic_area"].value == "0 um2"
    elastic = solved(scene("plate.hardness_gpa="))
    assert elastic["hardness"].value == "none, purely elastic" and "plastic_area" not in elastic


def test_numbers_are_those_of_a_march() -> None:
    """Every solved position has the areas of the march to a thousandth.

    The mean of the march over 400 positions lies within the range of the eight.
    """
    given = scene()
    (got,) = probe.probes([given])
    contact = contact_of_scene.rolling_contact(given)
    states = list(
        march.march(
            contact,
            0,
            399,
            half_space_of(contact.spacing, contact.contact_modulus, contact.subcells),
        )
    )
    places = np.arange(8) * 400 // 8
    for name in ("contact_area", "plastic_area", "max_pressure"):
        values = solved_values(got, name)
        marched = np.array([getattr(state, name) for state in states])
        np.testing.assert_allclose(values, marched[places], rtol=0.02)
        assert values.min() * (1 - 1e-9) <= marched.mean() <= values.max() * (1 + 1e-9)
    windows = np.array([(state.window.rows, state.window.columns) for state in states])
    mean = [solved_values(got, name).mean() for name in ("rows", "columns")]
    np.testing.assert_allclose(mean, windows.mean(axis=0), rtol=0.15)


def test_the_expected_time_is_that_of_the_solved_steps() -> None:
    given = scene("rolling.duration_s=0.004")
    (got,) = probe.probes([given])
    finding = next(f for f in got.findings(given) if f.key == "expected_time")
    seconds = solved_values(got, "step_ms").mean() * 1e-3 * given.track.solved_steps
    assert finding.seconds == pytest.approx(seconds)


def test_positions_that_fail_are_said(capsys: pytest.CaptureFixture[str]) -> None:
    # 2.1 GPa times 800 x 160 um is 269 N.
    text = str(findings.check_scene(scene("rolling.load_n=300")))
    warning = next(line for line in text.splitlines() if "positions solved: " in line)
    assert "8 of 8 positions fail, and so will the run" in warning
    assert "more than the surface can carry" in warning


def test_large_surfaces_and_slow_contacts_are_left_out_with_the_limit() -> None:
    larger = scene("rolling.duration_s=3")  # 150,000 x 80 nodes
    (got,) = probe.probes([larger])
    assert got.left_out == "making 12 million nodes would take long, the limit is 10 million"
    stated = {finding.key: finding for finding in checked(larger, got)}
    assert stated["positions"].value == f"none: {got.left_out}"
    assert "asperities may yield" in stated["hardness"].value
    size = "surface.spacing_um=0.05", "rolling.duration_s=0.0004", "surface.width_um=100"
    (slow,) = probe.probes([scene("rolling.load_n=2000", *size)])
    assert slow.left_out.startswith("it would take about ")
    assert slow.left_out.endswith("the limit is 60 s")


def test_long_sweeps_solve_the_first_and_the_last_run() -> None:
    loads = [round(0.01 * k, 2) for k in range(1, 14)]
    runs = [run for _, run in scene(f"sweep.rolling.load_n={loads}").runs()]
    reasons = [each.left_out for each in probe.probes(runs)]
    assert reasons == ["", *["first and last of 13 runs only"] * 11, ""]


def test_probes_stand_in_the_order_of_the_runs() -> None:
    """Runs that share a surface are solved in succession, whatever their order."""
    sweep = "sweep.rolling.load_n=[1, 2]", "sweep.surface.seed=[1, 2]"
    areas = [
        solved_values(got, "contact_area").mean()
        for got in probe.probes([r for _, r in scene(*sweep).runs()])
    ]
    assert min(areas[2:]) > 1.5 * max(areas[:2])  # seeds vary fastest


def test_a_track_of_fewer_steps_than_positions(tmp_path: Path) -> None:
    np.save(tmp_path / "z.npy", np.zeros((100, 80)))
    text = TEXT[: TEXT.index("surface:")] + "surface: {kind: file, path: z.npy, spacing_um: 2}\n"
    text += "rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.00006}\n"
    given = file.loads(text, folder=tmp_path)
    assert given.track.solved_steps == 3
    (got,) = probe.probes([given])
    assert (got.tried, len(got.solved)) == (3, 3)
