"""The study solves each case once, and continues to the same numbers after a stop."""

from __future__ import annotations

import json
import math
import os
import shutil
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from old_results import save_old

from acoustics.spectrum import article_line_level_db, line_spectrum
from acoustics.weighting import a_weighting_db
from rolling import cli
from rolling.accuracy import variants
from rolling.contact import closed_forms, of_scene
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.state import Window
from rolling.lee2025 import half_spacing, reproduce, study
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.simulation import result_file, simulate
from rolling.sound.contact_sound import contact_sound
from rolling.verification.dense import dense_contact

pytestmark = pytest.mark.slow

SCENES = Path(__file__).parents[2] / "scenarios" / "lee2025"
READINGS = sorted(folder.name for folder in SCENES.iterdir())
VARIATIONS = ("two-bodies-gaussian", "two-bodies-gaussian-10pct")
# of which reading
TWINS = {"elastic-gaussian": "as-stated", "elastic-exponential": "hardness-3y-exponential"}
TEXT = """\
name: small
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 128, seed: 1}
rolling: {load_n: 0.5, speed_m_s: 0.1, duration_s: 0.004}
sweep: {surface.seed: [1, 2], rolling.load_n: [0.5, 1]}
"""


@pytest.fixture
def small(tmp_path: Path, monkeypatch) -> Path:
    """Return a study of a reading with four cases of 200 steps."""
    folder = tmp_path / "scenes" / "lee2025" / "only"
    folder.mkdir(parents=True)
    (folder / "all.yaml").write_text(TEXT)
    monkeypatch.setattr(reproduce, "SCENES", tmp_path / "scenes")
    return folder


def surface(scene: Scene) -> Gaussian:
    assert isinstance(scene.surface, Gaussian)
    return scene.surface


TRACKS = {  # s of rolling of what counts for no verdict, or needs no more
    "two-bodies-gaussian": 0.015,
    "two-bodies-gaussian-10pct": 0.015,
    "correlation-length": 0.025,
}


def test_readings_are_the_articles_cases() -> None:
    """The readings have four roughnesses and five loads, two of them on two or three surfaces.

    They have 256 nodes across at 2 um, or more where contact is wider.
    """
    assert len(READINGS) == 8
    for name in READINGS:
        scenes = study.scenes(SCENES / name)
        if name in TWINS:
            continue
        assert all(one.name == f"lee2025-{name}" for one in scenes)
        assert all(
            one.motion.fastest(0.05) == 0.1 and one.rolling.duration_s == TRACKS.get(name, 0.05)
            for one in scenes
        )
        if name == "correlation-length":
            assert [surface(one).correlation_length_um for one in scenes] == [2, 5, 10, 20, 40]
            assert all(surface(one).spacing_um <= 2 / 5 for one in scenes)
            continue
        full = name in ("as-stated", "hardness-3y-exponential")
        cases = {(surface(one).roughness_ra_um, one.load, surface(one).seed) for one in scenes}
        expected = {
            (ra, w, s)
            for ra in (0.01, 0.1, 1, 5)
            for w in (5, 10, 20, 50, 100)
            for s in range(1, (4 if ra < 1 else 3) if full else 2)
        }
        assert cases == expected and len(scenes) == len(cases)
        for one in scenes:
            assert surface(one).spacing_um == 2 and surface(one).correlation_length_um == 10
            assert surface(one).n_across == 256 or surface(one).roughness_ra_um >= 1


def test_variations_are_told_by_the_scenes_themselves() -> None:
    """A reading with another sphere than a rigid one of 10 mm diameter is a variation."""
    departures = {name: study.departures(study.scenes(SCENES / name)) for name in READINGS}
    for name, found in departures.items():
        if name in VARIATIONS:
            assert found == [
                "a radius of 10 mm (stated: a diameter of 10 mm)",
                "an elastic sphere (stated: a rigid one)",
            ]
            assert study.description(SCENES / name).startswith(
                "A variation: a radius of 10 mm, two elastic bodies"
            )
        else:
            assert found == (["no hardness (stated: 2.1 GPa)"] if name in TWINS else [])


def test_twins_are_scenes_of_a_reading_without_hardness() -> None:
    """Twins differ from their scenes in hardness and tolerance only.

    They have Ra 0.1 and 1 um at 5, 20 and 100 N, on the same surfaces.
    """
    for name, of in TWINS.items():
        scenes = study.scenes(SCENES / name)
        assert [study.varied(one)[:3] for one in scenes] == [
            (ra, w, 1) for ra in (0.1, 1) for w in (5, 20, 100)
        ]
        others = {study.varied(one): one for one in study.scenes(SCENES / of)}
        for one in scenes:
            ours, theirs = one.to_dict(), others[study.varied(one)].to_dict()
            assert theirs["plate"].pop("hardness_gpa") and "hardness_gpa" not in ours["plate"]
            for data in (ours, theirs):
                del data["name"], data["numerics"]["tolerance"]
            assert ours == theirs


def test_each_reading_says_what_it_takes_for_granted(tmp_path: Path) -> None:
    said = {name: study.description(SCENES / name) for name in READINGS}
    assert (
        all(len(words) > 20 and words.endswith(".") for words in said.values())
        and len({*said.values()}) == 8
    )
    for name in READINGS:  # all files of a reading say the same
        firsts = {
            file.read_text(encoding="utf-8").splitlines()[0]
            for file in (SCENES / name).glob("*.yaml")
        }
        assert firsts == {f"# {said[name]}"}
    (tmp_path / "bare.yaml").write_text(TEXT)
    assert study.description(tmp_path) == ""


def test_quick_takes_one_surface_and_three_loads() -> None:
    scenes = study.scenes(SCENES / "as-stated", study.QUICK)
    assert {(one.load, surface(one).seed) for one in scenes} == {(5, 1), (20, 1), (100, 1)} and len(
        scenes
    ) == 12
    assert all(
        one.rolling.duration_s == study.QUICK.duration_s and one.step == pytest.approx(6e-6)
        for one in scenes
    )
    lengths = study.scenes(SCENES / "correlation-length", study.QUICK)
    assert len(lengths) == 5 and all(one.step == pytest.approx(6e-6) for one in lengths)


def test_a_case_in_numbers(small: Path, tmp_path: Path) -> None:
    """A case has the areas of its run over Hertz's, and fluctuations that add up over the bands."""
    done = reproduce.reproduce("lee2025", out=tmp_path / "out", workers=1)
    assert done.exit_code == 0 and len(done.cases) == 4
    (one, *_) = study.runs(tmp_path / "out" / "only", study.scenes(small))
    (result,) = study.open_results([one])
    case = done.cases[0]
    assert (case.reading, case.load_n, case.seed, case.nodes_across) == ("only", 0.5, 1, 64)
    hertz = np.pi * closed_forms.hertz_radius(0.5, 5e-3, one.scene.contact_modulus) ** 2
    assert case.plastic_ratio == pytest.approx(
        result.series["plastic_area"][:-1].mean() / hertz, rel=0.02
    )
    assert case.max_pressure == result.series["max_pressure"].max()
    sound = contact_sound(
        one.scene, result.whole("release_energy"), result.step, True, result.solved_steps
    )
    frequency, square = line_spectrum(sound.power, len(sound.power) / sound.duration)
    heard = square[(frequency >= 17.8) & (frequency < 22387)].sum()
    # The bands' own lines, which undo the mean over a step: 0.6 dB at 10 kHz, little of the whole.
    assert np.nansum(np.square(case.band_w)) == pytest.approx(heard, rel=0.05)
    assert case.laeq_db == sound.levels.laeq_db and case.maximum_db < case.laeq_db + 5
    # With 20 lg the level doubles, its weighting does not: 20 lg of each line, weighted, again from
    # the power.
    line_hz, line_db = article_line_level_db(sound.power, len(sound.power) / sound.duration, 1.0)
    inside = (line_hz >= 17.8) & (line_hz < 22387)
    unweighted = line_db - a_weighting_db(line_hz)
    assert case.maximum_20_db == pytest.approx(
        (2 * unweighted + a_weighting_db(line_hz))[inside].max(), abs=1e-9
    )
    # The mean is over all positions; each value is the maximum of its window.
    assert case.deflection == result.series["max_deflection"].mean()
    assert (
        result.snapshot and result.snapshot.deflection.max() == result.series["max_deflection"][200]
    )
    assert 0 < case.laeq_uncertainty_db < case.weighted_uncertainty_db
    stored = json.loads((tmp_path / "out" / "cases.json").read_text())
    assert len(stored) == 4 and stored[0]["plastic_ratio"] == case.plastic_ratio


def test_a_result_without_deflections_is_read_and_has_none(small: Path, tmp_path: Path) -> None:
    """A file of version 0.1.0 gives a case without deflections."""
    out = tmp_path / "out"
    first = reproduce.reproduce("lee2025", out=out, workers=1).cases
    for file in (out / "only").rglob("result.h5"):
        save_old(file, result_file.load(file), deflection=False)
    again = reproduce.reproduce("lee2025", out=out, workers=1).cases
    assert all(math.isnan(case.deflection) for case in again)
    assert [case.laeq_db for case in again] == [case.laeq_db for case in first]
    table = json.loads((out / "claims.json").read_text())
    words = {row["key"]: {one["verdict"] for one in row["findings"]} for row in table["claims"]}
    assert words["deflection-roughest"] == words["deflection-roughness"] == {"not run"}


def test_keys_that_came_with_a_later_version_do_not_make_another_case(
    small: Path, tmp_path: Path
) -> None:
    """A lacking key with a default, a comment or a title makes no other case."""
    out = tmp_path / "out"
    reproduce.reproduce("lee2025", out=out, workers=1)
    for file in (out / "only").rglob("resolved.yaml"):
        text = file.read_text()
        assert "precision: single" in text
        file.write_text("# an earlier version\n" + text.replace("  precision: single\n", ""))
    assert len(reproduce.reproduce("lee2025", out=out, workers=1).cases) == 4


def test_what_is_solved_is_not_solved_again(small: Path, tmp_path: Path, monkeypatch) -> None:
    out = tmp_path / "out"
    first = reproduce.reproduce("lee2025", out=out, workers=1)
    solved: list[int] = []
    inner = simulate.simulate_piece
    monkeypatch.setattr(
        simulate, "simulate_piece", lambda *a, **k: (solved.append(a[2] - a[1]), inner(*a, **k))[1]
    )
    again = reproduce.reproduce("lee2025", out=out, workers=1)
    assert solved == [] and [c.laeq_db for c in again.cases] == [c.laeq_db for c in first.cases]
    # as if stopped before it
    shutil.rmtree(next(one for one in (out / "only").iterdir() if "seed=2" in one.name))
    assert len(reproduce.reproduce("lee2025", out=out, workers=1).cases) == 4
    assert solved == [200]


def test_a_case_of_another_scene_is_not_overwritten(small: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    command = ["reproduce", "lee2025", "--out", str(out), "--workers", "1"]
    assert cli.main(command) == 0
    before = {file: file.read_bytes() for file in out.rglob("*") if file.is_file()}
    (small / "all.yaml").write_text(TEXT.replace("hardness_gpa: 2.1", "hardness_gpa: 3"))
    capsys.readouterr()
    assert cli.main(command) == 2
    assert "made with other settings; take another --out" in capsys.readouterr().err
    assert {file: file.read_bytes() for file in out.rglob("*") if file.is_file()} == before


def test_bad_input_is_refused_before_anything_is_written(
    small: Path, tmp_path: Path, capsys
) -> None:
    out = tmp_path / "out"
    assert cli.main(["reproduce", "lee2025", "--readings", "onli", "--out", str(out)]) == 2
    assert (
        capsys.readouterr().err == "--readings: got onli, allowed: only, nearest: only\n"
        and not out.exists()
    )
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "letter.txt").write_text("mine")
    assert cli.main(["reproduce", "lee2025", "--out", str(tmp_path / "full")]) == 2
    assert "holds something that is no study" in capsys.readouterr().err
    assert [one.name for one in (tmp_path / "full").iterdir()] == ["letter.txt"]


def test_power_levels() -> None:
    """1 W at 1 m is 1/(4 pi) W/m2, 109 dB, and a tenth of it is 10 or 20 dB less."""
    assert study.power_level_db(1.0, 10) == pytest.approx(109.0, abs=0.01)
    for factor in (10, 20):
        assert study.power_level_db(1.0, factor) - study.power_level_db(
            0.1, factor
        ) == pytest.approx(factor)


@pytest.mark.parametrize(
    ("reading", "roughness"),
    [("as-stated", 0.01), ("as-stated", 0.1), ("hardness-3y-exponential", 0.1)],
)
def test_the_articles_own_method_agrees(reading: str, roughness: float) -> None:
    """Influence matrix and active set give pressures within 1e-6 of the peak at 5 N.

    Edges are sharp, as in the article (Fig. 3).
    """
    (scene,) = (
        one for one in study.scenes(SCENES / reading, study.QUICK) if _is(one, roughness, 5)
    )
    contact = replace(of_scene.rolling_contact(scene), blended=False, tolerance=1e-9)
    (state,) = march(contact, 0, 0, HalfSpace(contact.spacing, contact.contact_modulus))
    w = state.loaded
    block = Window(w.row - 2, w.column - 2, w.rows + 4, w.columns + 4)
    pressure, approach = dense_contact(
        contact.gap(0, block),
        contact.load,
        contact.spacing,
        contact.contact_modulus,
        contact.hardness,
    )
    assert (
        np.abs(state.window.moved(state.pressure, block) - pressure).max() < 1e-6 * pressure.max()
    )
    assert state.approach == pytest.approx(approach, rel=1e-7)


def _is(scene: Scene, roughness: float, load: float) -> bool:
    return surface(scene).roughness_ra_um == roughness and scene.load == load


def test_checks_at_half_the_spacing_follow_the_cases_and_go_on_after_a_stop(
    small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    keys = [("only", (0.1, 0.5)), ("only", (0.1, 1.0))]
    monkeypatch.setattr(half_spacing, "wanted", lambda table, cases: keys)
    marched: list[float] = []
    march = variants.march_piece

    def one_before_a_stop(scene, variant, *rest):
        marched.append(scene.load)
        if len(marched) == 1:
            os.kill(os.getpid(), signal.SIGINT)  # which comes before the next piece
            return march(scene, variant, *rest[:2], lambda: False, *rest[3:])
        return march(scene, variant, *rest)

    monkeypatch.setattr(variants, "march_piece", one_before_a_stop)
    done = reproduce.reproduce("lee2025", out=out, workers=1)
    assert done.interrupted and done.exit_code == 130 and len(done.cases) == 4
    assert len([*(out / half_spacing.FOLDER).iterdir()]) == 1
    first = marched[0]
    marched[:] = [first]
    done = reproduce.reproduce("lee2025", out=out, workers=1)
    assert done.exit_code == 0 and len(marched) == 2 and {*marched} == {0.5, 1.0}
    assert len([*(out / half_spacing.FOLDER).iterdir()]) == 2 and (out / "index.html").is_file()
