"""A figure has the numbers of its cases, their units, and the limit of the theory."""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from claim_cases import FIGURES

from rolling.figures.picture import Picture
from rolling.lee2025 import figure_data, figures, page, study
from rolling.lee2025.checks import Finding
from rolling.lee2025.figure_data import Reading, Scales
from rolling.lee2025.results import Extent, JudgedClaim, Judgement, Score, Table
from rolling.lee2025.statements import CLAIMS, Claim
from rolling.lee2025.study import Case
from rolling.scene import file
from rolling.surface import heights as surface
from rolling.surface import scene_surface

pytestmark = pytest.mark.slow

SCENE = """\
name: small
sphere: {radius_mm: 1}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 1, correlation_length_um: 10, \
spacing_um: 2, width_um: 400, seed: 1}
rolling: {load_n: 0.5, speed_m_s: 0.1, duration_s: 0.005}
numerics: {tolerance: 1.0e-3}
sweep: {surface.roughness_ra_um: [1, 5], rolling.load_n: [0.2, 0.5]}
"""
HOSTILE = '"><img src=x onerror=alert(1)>'


@pytest.fixture(autouse=True)
def _no_warnings() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Reading:
    """Return a solved reading of four cases on a short track."""
    folder = tmp_path_factory.mktemp("reading")
    (folder / "small.yaml").write_text(SCENE)
    runs = study.runs(folder / "out", study.scenes(folder))
    results = study.open_results(runs)
    assert not study.solve_all(runs, results, 1, "small").failures
    cases = [study.case("small", one, result) for one, result in zip(runs, results, strict=True)]
    return figure_data.gather("small", runs, results, cases)


def case(
    roughness: float, load: float, seed: int = 1, length: float = 10.0, **others: float
) -> Case:
    """Return a case by closed form: level 60 + load / 10 + 2 seed, plastic ratio 0.1 Ra seed."""
    maximum = 60.0 + load / 10 + 2 * seed
    made = Case(
        reading="synthetic",
        roughness_um=roughness,
        load_n=load,
        seed=seed,
        correlation_um=length,
        hardness_gpa=2.1,
        bodies="R 5 mm",
        nodes_across=256,
        duration_s=0.05,
        plastic_ratio=0.1 * roughness * seed,
        contact_ratio=1.0,
        max_pressure=2.1e9,
        deflection=1e-6,
        laeq_db=maximum + 3,
        laeq_uncertainty_db=0.4,
        weighted_uncertainty_db=0.8,
        maximum_db=maximum,
        maximum_20_db=2 * maximum,
        line_hz=20.0 * 2 ** (np.arange(100) / 12),
        line_db=maximum - 0.1 * np.arange(100.0),
        band_w=np.full(31, np.nan),
        a_weighted_w=1e-4,
    )
    return replace(made, **others)


@pytest.fixture(scope="module")
def synthetic() -> Reading:
    cases = [
        case(ra, load, seed)
        for ra in (0.1, 1.0, 5.0)
        for load in (5.0, 20.0, 100.0)
        for seed in (1, 2, 3)
    ]
    return Reading("synthetic", cases, {(0.1, 10.0): 0.03, (1.0, 10.0): 0.25, (5.0, 10.0): 1.23})


def drawn(reading: Reading, on: Scales | None = None) -> dict[str, Picture]:
    on = on or figure_data.scales([reading])
    return {picture.name: picture for picture in figures.gallery(reading, on)}


def table(picture: Picture) -> dict[str, list[float | None]]:
    rows = list(csv.DictReader(io.StringIO(picture.csv().decode())))
    return {name: [float(row[name]) if row[name] else None for row in rows] for name in rows[0]}


def words(picture: Picture) -> str:
    texts = [text.get_text() for text in picture.figure.texts]
    for ax in picture.figure.axes:
        texts += [text.get_text() for text in ax.texts]
    return "\n".join(texts)


def note(picture: Picture) -> str:
    return picture.figure.texts[-1].get_text()


def test_every_figure_of_a_solved_reading_is_there_and_draws(solved: Reading) -> None:
    pictures = drawn(solved)
    assert tuple(pictures) == FIGURES
    for picture in pictures.values():
        assert picture.png()[:4] == b"\x89PNG" and picture.svg().startswith(b"<?xml")


def test_every_figure_with_ra_5_says_that_theory_ends_there(
    solved: Reading, synthetic: Reading
) -> None:
    for picture in [*drawn(solved).values(), *drawn(synthetic).values()]:
        assert re.search(
            r"Ra 5 µm: rms slope .* along each direction, norm .* > 0\.3: half-space",
            words(picture),
        )
        assert "half-space theory does not hold" in picture.alt


def test_warning_is_of_the_slope_measured_on_the_surface(solved: Reading, tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SCENE)
    scene = file.read_scene(
        tmp_path / "s.yaml", ["surface.roughness_ra_um=5", "rolling.load_n=0.5"]
    )
    norm = surface.statistics(scene_surface.heights(scene), scene.spacing).rms_slope
    assert solved.slopes[5.0, 10.0] == norm
    # Ra 5 um, Gaussian with 1/e at 10 um: Rq sqrt(2)/length = 0.89 along each direction; half a
    # percent less over one spacing, and a tenth for a surface as small as this one.
    assert norm / np.sqrt(2) == pytest.approx(0.88, rel=0.1)
    assert f"norm {norm:.2g} > 0.3" in words(drawn(solved)["fig9_maximum_level"])


def test_no_warning_where_surfaces_are_flat_enough(synthetic: Reading) -> None:
    flat = replace(synthetic, cases=[one for one in synthetic.cases if one.roughness_um < 5])
    for picture in drawn(flat).values():
        assert "half-space" not in words(picture) + picture.alt


def test_axes_are_named_with_units(solved: Reading, synthetic: Reading) -> None:
    heights = {
        "fig1_surfaces": "height [µm]",
        "fig5_contact_pressure": "pressure [GPa]",
        "fig6_deflection": "deflection [µm]",
    }
    for name, label in heights.items():
        ax = drawn(solved)[name].figure.axes[0]
        assert ax.get_zlabel() == label and ax.get_ylabel() == "across [µm]"  # type: ignore[attr-defined]
    pictures = drawn(synthetic)
    for name, x, y in (
        ("fig7_plastic_ratio", "load [N]", "plastic area / Hertz area"),
        ("fig9_maximum_level", "load [N]", "maximum A-weighted line level [dB re 1 pW/m²]"),
    ):
        assert (
            pictures[name].figure.axes[0].get_xlabel(),
            pictures[name].figure.axes[0].get_ylabel(),
        ) == (x, y)
    panels = pictures["fig8_spectra"].figure.axes
    assert panels[0].get_ylabel() == "A-weighted line level\n[dB re 1 pW/m²]"
    assert panels[2].get_xlabel() == "frequency [Hz]"


def test_plastic_ratio_is_mean_and_deviation_over_surfaces(synthetic: Reading) -> None:
    columns = table(drawn(synthetic)["fig7_plastic_ratio"])
    assert columns["load [N]"] == [5, 20, 100]
    # Ratios 0.1 Ra (1, 2, 3): mean 0.2 Ra, deviation 0.1 Ra; nine digits are written.
    for ra in (0.1, 1, 5):
        assert columns[f"Ra {ra} µm: plastic area / Hertz area [1]"] == pytest.approx(
            [0.2 * ra] * 3, rel=1e-8
        )
        assert columns[f"Ra {ra} µm: standard deviation [1]"] == pytest.approx(
            [0.1 * ra] * 3, rel=1e-8
        )
    one = replace(synthetic, cases=synthetic.at(seed=1))
    assert table(drawn(one)["fig7_plastic_ratio"])["Ra 5 µm: standard deviation [1]"] == [None] * 3
    assert "no error bars" in note(drawn(one)["fig7_plastic_ratio"])


def test_maximum_levels_and_their_doubles(synthetic: Reading) -> None:
    picture = drawn(synthetic)["fig9_maximum_level"]
    columns = table(picture)
    # 60 + load/10 + 2 seed: mean 64 + load/10, deviation 2; 20 lg doubles, from that of Ra 1 um at
    # 20 N.
    assert columns["Ra 0.1 µm: maximum A-weighted line level [dB re 1 pW/m²]"] == pytest.approx(
        [64.5, 66, 74]
    )
    assert columns["Ra 0.1 µm: standard deviation [dB]"] == pytest.approx([2, 2, 2])
    assert columns["Ra 0.1 µm, 20 lg: relative to Ra 1 µm, 20 N [dB]"] == pytest.approx([-3, 0, 16])
    assert columns["Ra 0.1 µm, 20 lg: standard deviation [dB]"] == pytest.approx([4, 4, 4])
    ax = picture.figure.axes[0]
    (other,) = ax.child_axes
    picture.figure.draw_without_rendering()
    assert other.get_ylabel() == "20 lg, re maximum of Ra 1 µm, 20 N [dB]"
    assert other.get_ylim() == pytest.approx([2 * (edge - 66) for edge in ax.get_ylim()])


def test_spectra_are_the_lines_of_the_cases(synthetic: Reading) -> None:
    one = replace(synthetic, cases=synthetic.at(seed=2))
    columns = table(drawn(one)["fig8_spectra"])
    for each in one.cases:
        level = columns[f"Ra {each.roughness_um:g} µm, {each.load_n:g} N [dB re 1 pW/m²]"]
        assert level == pytest.approx(each.line_db.tolist(), rel=1e-8)  # nine digits are written
    assert columns["frequency [Hz]"] == pytest.approx(one.cases[0].line_hz.tolist(), rel=1e-8)


def test_spectra_of_several_surfaces_are_of_their_mean_power(synthetic: Reading) -> None:
    level = table(drawn(synthetic)["fig8_spectra"])["Ra 1 µm, 20 N [dB re 1 pW/m²]"][0]
    assert level == pytest.approx(10 * np.log10(np.mean([10**6.4, 10**6.6, 10**6.8])), rel=1e-8)
    assert "means of the power of 3 surfaces" in note(drawn(synthetic)["fig8_spectra"])


def test_spectra_say_from_where_third_octaves_mean_something(synthetic: Reading) -> None:
    picture = drawn(synthetic)["fig8_spectra"]
    # B T >= 5 at 0.05 s: B >= 100 Hz; the band of 400 Hz is 92 Hz wide, that of 500 Hz 115 Hz.
    assert "T = 0.05 s: third octaves are reliable from 500 Hz" in note(picture)
    ax = picture.figure.axes[0]
    grey = ax.patches[0].get_extents().transformed(ax.transData.inverted())
    assert grey.x1 == pytest.approx(10**2.65)  # lower edge of that band


def test_what_is_compared_has_the_same_axes(synthetic: Reading) -> None:
    louder = replace(
        synthetic,
        name="louder",
        cases=[
            replace(
                one,
                maximum_db=one.maximum_db + 20,
                line_db=one.line_db + 20,
                plastic_ratio=2 * one.plastic_ratio,
            )
            for one in synthetic.cases
        ],
    )
    on = figure_data.scales([synthetic, louder])
    here, there = drawn(synthetic, on), drawn(louder, on)
    alone = drawn(synthetic)
    for name in here:
        limits = [each[name].figure.axes[0].get_ylim() for each in (here, there, alone)]
        assert limits[0] == limits[1] != limits[2]


def test_missing_cases_leave_gaps(synthetic: Reading, solved: Reading) -> None:
    few = replace(
        synthetic,
        cases=[one for one in synthetic.cases if (one.roughness_um, one.load_n) != (1.0, 20.0)],
    )
    pictures = drawn(few)
    columns = table(pictures["fig9_maximum_level"])
    assert columns["Ra 1 µm: maximum A-weighted line level [dB re 1 pW/m²]"] == [
        pytest.approx(64.5),
        None,
        74,
    ]
    assert "no axis of 20 lg: Ra 1 µm, 20 N is not solved" in note(pictures["fig8_spectra"])
    assert not pictures["fig9_maximum_level"].figure.axes[0].child_axes
    # none of 100 N at Ra 0.1
    smooth = [one for one in synthetic.cases if one.roughness_um > 0.1 or one.load_n < 100]
    on = figure_data.scales([replace(synthetic, cases=[*synthetic.cases, case(1.0, 50.0)])])
    (legend,) = drawn(replace(synthetic, cases=smooth), on)["fig8_spectra"].figure.legends
    assert [text.get_text() for text in legend.get_texts()][:-1] == ["5 N", "20 N", "100 N"]
    contacts = {key: one for key, one in solved.contacts.items() if key != (1.0, 0.2)}
    pressure = drawn(replace(solved, contacts=contacts))["fig5_contact_pressure"]
    assert "Ra 1 µm, 0.2 N: not solved" in words(pressure)
    pressure.png()
    silent = [
        replace(one, maximum_db=-np.inf, line_db=np.full(100, -300.0))
        for one in synthetic.at(seed=1)
    ]
    for picture in drawn(replace(synthetic, cases=silent)).values():
        picture.png()
        assert b"inf" not in picture.csv()


def test_maps_are_of_the_solved_contact(solved: Reading) -> None:
    pictures = drawn(solved)
    fits: tuple[list[bool], list[bool]] = ([], [])
    for (ra, load), contact in solved.contacts.items():
        assert f"Ra {ra:g} µm" in words(pictures["fig5_contact_pressure"])
        assert f"{load:g} N: maximum {contact.pressure.max() * 1e-9:.2f} GPa" in words(
            pictures["fig5_contact_pressure"]
        )
        assert f"{load:g} N: maximum {contact.deflection.max() * 1e6:.2f} µm" in words(
            pictures["fig6_deflection"]
        )
        # The load is the pressure over the nodes' area, met to 1e-12.
        assert contact.pressure.sum() * 2e-6**2 == pytest.approx(load, rel=1e-9)
        # Over the deflected plate the sphere, a parabola of 1 mm that stands at the end of the 200
        # steps, is nowhere lower than where it presses. A cell with a blended edge bears its share
        # while half the range of gaps within it, about half the rms difference of neighbours,
        # is still open, and all of it in steep cells. Heights of a node off break this on
        # some surface.
        rows = np.rint((contact.along + 400e-6) / 2e-6).astype(int)
        columns = np.rint((contact.across + 199e-6) / 2e-6).astype(int)
        parabola = (contact.along[:, None] ** 2 + contact.across**2) / 2e-3
        pressed = contact.pressure > 0
        allowance = solved.slopes[ra, 10.0] / np.sqrt(2) * 2e-6
        for off in (0, 1):
            heights = np.roll(solved.patches[ra].heights, off, axis=0)
            below = heights[np.ix_(rows % heights.shape[0], columns % heights.shape[1])]
            gap = parabola - below + contact.deflection
            fits[off].append(bool(gap[pressed].max() < gap[~pressed].min() + allowance))
    assert all(fits[0]) and not all(fits[1]), fits


def test_correlation_lengths_have_a_figure_of_their_own() -> None:
    cases = [case(0.1, 20.0, 1, length, laeq_db=80 - length) for length in (2.0, 10.0, 40.0)]
    reading = Reading("lengths", cases, {(0.1, 2.0): 0.4, (0.1, 10.0): 0.02})
    (picture,) = drawn(reading).values()
    columns = table(picture)
    assert columns["correlation length [µm]"][:3] == [2, 10, 40]
    assert columns["LAeq [dB re 20 µPa]"][:3] == [78, 70, 40]
    assert columns["maximum line [dB re 1 pW/m²]"][:3] == [64, 64, 64]
    assert columns["length 40 µm [dB re 1 pW/m²]"] == pytest.approx(
        cases[2].line_db.tolist(), rel=1e-8
    )
    left, right = picture.figure.axes[:2]
    assert left.get_xlabel() == "frequency [Hz]" and right.get_xlabel() == "correlation length [µm]"
    assert "Ra 0.1 µm, length 2 µm: rms slope 0.28" in words(picture)
    picture.png()


def test_page_has_a_column_for_each_reading_and_asks_for_nothing(synthetic: Reading) -> None:
    judgements = (
        Judgement("synthetic", 10, Finding("undecided", "14 dB", decided_by="the grid")),
        Judgement("synthetic", 10, Finding("reproduced", "14 dB")),
        Judgement("synthetic", 20, Finding("not run", HOSTILE)),
        Judgement(HOSTILE, None, Finding("partly", "")),
    )
    caution = HOSTILE + "1.6 at 2 µm, 1.2 at 0.5 µm"
    claim = Claim(
        "k", "section 3", HOSTILE, "3 dB", lambda cases: Finding("partly", ""), caution=caution
    )
    scores = (Score("synthetic", 10, 1.0, 2.5, {"reproduced": 1}),)
    extent = Extent("variation", assumptions="x", departs=(HOSTILE,), lacks=("50 N",))
    table = Table({"synthetic": extent}, claims=(JudgedClaim(claim, judgements),), scores=scores)
    pictures = [*drawn(synthetic).values()]
    html = page.page(
        ["synthetic", HOSTILE], table, {"synthetic": pictures, HOSTILE: pictures}
    ).decode()
    assert HOSTILE not in html and "<img src=x" not in html
    assert html.count("data:image/svg+xml") == 2 * len(pictures)
    assert html.count("data:text/csv") == 2 * len(pictures)
    targets = re.findall(r"(?:src|href)=\"([^\"]*)\"", html)
    assert {target.partition(":")[0] for target in targets} == {"data"}
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', html)
    assert policy and policy[1].startswith("default-src 'none'")
    assert "<script" not in html and not re.search(r"<link|@import|url\(", html)
    assert '<p class="caution">' in html and "1.6 at 2 µm, 1.2 at 0.5 µm</p>" in html
    assert (
        '<th scope="col" class="variation">synthetic<span class="kind">variation</span></th>'
        in html
    )
    assert (
        '</span> undecided <span class="scale">(the grid)</span>' in html
        and "<td>1 to 2.5</td>" in html
    )
    for text in (
        "✓</span> reproduced",
        "◐</span> partly",
        "○</span> not run",
        "10 lg",
        "not solved: 50 N",
    ):
        assert text in html


def test_variations_stand_after_the_readings() -> None:
    kinds = {"a": "sweep", "b": "variation", "c": "reading", "d": "variation", "e": "reading"}
    order = page.ordered(kinds, Table({name: Extent(kind) for name, kind in kinds.items()}))
    assert order == ["c", "e", "b", "d", "a"]


def test_page_takes_a_table_without_scores_or_findings(synthetic: Reading) -> None:
    html = page.page(["synthetic"], Table(claims=(JudgedClaim(CLAIMS[0]),)), {}).decode()
    assert CLAIMS[0].statement in html and "not judged" in html
    assert "No claims were judged" in page.page(["synthetic"], Table(), {}).decode()
