"""Waves and roughness of raceways and balls against their laws, by other code."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bearings import model

import rolling
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing import assumed_surfaces
from rolling.bearing.assumed_surfaces import (
    AMPLITUDE_DB,
    FORM_DB,
    AssumedRoughness,
    AssumedWaves,
    RoughnessLaw,
    crests_db,
    exponent_db,
    order_gains,
    order_powers,
    roughness_powers,
    surfaces_db,
)
from rolling.bearing.ring_motion import move_ring
from rolling.bearing.ring_record import AXIAL, DIRECTIONS, RADIAL
from rolling.bearing.tracks import smooth_tracks, with_waves
from rolling.bearing.waves import semi_axes
from rolling.bearing_kind.bearing_simulation import record_of
from rolling.bearing_kind.body_forms import assumed_roughness, assumed_waves, form_of
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.contact_uncertainty import roughness_powers as marched_powers
from rolling.bearing_kind.joined_tracks import bearing_tracks
from rolling.scene.height_format import HeightFormatError
from rolling.scene.roundness_files import MAX_BYTES, read_waves
from rolling.scene.surfaces import GRADES
from rolling.surface import made
from rolling.surface.ball_form import BallForm, form_heights, random_amplitudes
from rolling.surface.wave_law import ROUNDNESS_OF_AMPLITUDE, WaveLaw

NODES = 8192
BANDS = {"low": (50.0, 300.0), "medium": (300.0, 1800.0)}


def orders_of(heights: np.ndarray) -> np.ndarray:
    """Return the amplitudes of the orders of a turn."""
    return 2 / len(heights) * np.abs(np.fft.rfft(heights))


def raceway(**keys) -> rolling.Raceway:
    """Return a superfinished raceway with other values."""
    return rolling.Raceway(**({"finish": "superfinished", "seed": 1} | keys))


def bearing_scene(**surfaces) -> rolling.BearingScene:
    """Return a 6204 at 1,800 rpm under 70 N with some surfaces."""
    bearing = {"named": "6204", "speed_rpm": 1800, "axial_load_n": 70, "surfaces": surfaces}
    return rolling.BearingScene(bearing=bearing)


# ---- the law of waves


@pytest.mark.law("Raceways: amplitudes over the order have the stated exponent and size.")
@pytest.mark.parametrize(("exponent", "amplitude_m"), [(1.0, 2e-7), (1.3, 5e-7), (0.8, 1e-7)])
def test_waves_fall_with_the_stated_power_of_their_order(
    exponent: float, amplitude_m: float
) -> None:
    """A fit over forty turns; the mean square of Rayleigh amplitudes scatters by 1/sqrt(n)."""
    squares = np.mean(
        [
            orders_of(
                WaveLaw(amplitude_m=amplitude_m, exponent=exponent, seed=(seed,)).heights(
                    NODES, NODES // 4
                )
            )
            ** 2
            for seed in range(40)
        ],
        axis=0,
    )
    number = np.arange(2, NODES // 4)
    # The mean logarithm of a mean of 40 exponential numbers lies 1/80 below its logarithm.
    fit = np.polyfit(np.log(number), np.log(squares[2 : NODES // 4]) + 1 / 80, 1)
    assert -fit[0] / 2 == pytest.approx(exponent, abs=0.01)
    at_100 = math.exp((fit[0] * math.log(100) + fit[1]) / 2)
    assert at_100 == pytest.approx(amplitude_m * 100**-exponent, rel=0.02)
    eighth = math.sqrt(squares[8] / amplitude_m**2) * 8**exponent
    assert abs(eighth - 1) < 3 / (2 * math.sqrt(40))
    assert squares[:2].max() < 1e-30


def test_more_orders_leave_the_lower_ones_and_another_amplitude_the_luck() -> None:
    law = WaveLaw(amplitude_m=1e-7, exponent=1.0, seed=(3,))
    np.testing.assert_array_equal(law.waves(50), law.waves(900)[:51])
    np.testing.assert_allclose(replace(law, amplitude_m=2e-7).waves(50), 2 * law.waves(50))
    coarse = orders_of(law.heights(512, 128))[:129]
    np.testing.assert_allclose(coarse, orders_of(law.heights(NODES, 128))[:129], atol=1e-20)


def test_the_amplitude_of_a_finish_gives_its_deviation_from_roundness() -> None:
    """The mean peak-to-valley height of the orders 2 to 15 of 400 raceways is 0.5 um."""
    amplitude = raceway().wave_amplitude_um
    law = WaveLaw(amplitude_m=1e-6 * amplitude, exponent=1.0, seed=(0,))
    heights = [np.ptp(replace(law, seed=(seed,)).heights(512, 15)) for seed in range(400)]
    assert np.mean(heights) == pytest.approx(ROUNDNESS_OF_AMPLITUDE * 1e-6 * amplitude, rel=0.04)
    assert 1e6 * np.mean(heights) == pytest.approx(0.5, rel=0.05)


def test_a_raceway_has_waves_of_its_own_for_each_seed_and_each_specimen() -> None:
    one = form_of(raceway(), Path())
    assert form_of(raceway(seed=2), Path()) != one != form_of(raceway(), Path(), draw=1)
    first, second = (form_heights(form_of(raceway(), Path(), draw), NODES) for draw in (1, 2))
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.9


# ---- roughness across the lay


@pytest.mark.law("Raceways: a stylus across the lay reads the stated Ra with the named cut-off.")
@pytest.mark.parametrize("keys", [{}, {"roughness_ra_um": 0.05}, {"cut_off_um": 250.0}])
def test_a_stylus_across_the_lay_reads_ra(keys: dict[str, float]) -> None:
    """Profiles across are filtered by another program: Gaussian weights over their own waves."""
    surface = raceway(**keys)
    spacing = 1e-6
    law = surface.law
    assert law.correlation_length_um == 500
    heights = made.of_law((64, 32768), spacing, replace(law.in_si, lengths_m=(1e-6, 1e-5)), 5)
    waves = np.fft.rfftfreq(heights.shape[1], spacing)
    passing = [np.exp(-math.log(2) * (wave * waves) ** 2) for wave in (surface.cut_off_m, 2.5e-6)]
    read = np.fft.irfft(np.fft.rfft(heights, axis=1) * (1 - passing[0]) * passing[1], axis=1)
    ra_um = 1e6 * np.abs(read).mean()
    assert ra_um == pytest.approx(surface.roughness_ra_um, rel=0.01)


def test_the_cut_off_is_that_of_iso_4288_unless_it_is_given() -> None:
    cut_offs = [raceway(roughness_ra_um=ra).cut_off_m for ra in (0.02, 0.05, 0.1, 0.4)]
    assert cut_offs == pytest.approx([0.08e-3, 0.25e-3, 0.25e-3, 0.8e-3])
    assert raceway(cut_off_um=250).cut_off_m == pytest.approx(0.25e-3)
    with pytest.raises(rolling.SceneError, match="up to 28 with a cut-off of 80 um"):
        raceway(correlation_length_across_um=40)


# ---- balls


def test_grades_are_those_of_iso_3290() -> None:
    """Ra and deviation from spherical form [um] of the table of ISO 3290-1:2014."""
    wanted = {"G3": (0.010, 0.08), "G5": (0.014, 0.13), "G10": (0.020, 0.25), "G16": (0.025, 0.4)}
    wanted |= {"G20": (0.032, 0.5), "G24": (0.040, 0.6), "G28": (0.050, 0.7), "G40": (0.060, 1.0)}
    wanted |= {"G60": (0.080, 1.5), "G100": (0.100, 2.5), "G200": (0.150, 5.0)}
    assert {name: tuple(limits) for name, limits in GRADES.items()} == wanted


def test_waves_of_balls_go_on_from_their_form_and_leave_it() -> None:
    graded = rolling.GradedBall(grade="G10", seed=4)
    further = rolling.BearingBall(grade="G10", seed=4, wave_exponent=1.0)
    form = orders_of(form_heights(graded.form, NODES))
    with_waves = orders_of(form_heights(further.form, NODES))
    np.testing.assert_allclose(with_waves[:16], form[:16], atol=1e-20)
    assert form[16:].max() < 1e-20
    expected = random_amplitudes(further.form, NODES // 4)
    np.testing.assert_allclose(expected[2:16], form[2:16], rtol=1e-3)
    assert expected[16] == pytest.approx(form[15] * 15 / 16, rel=1e-3)
    squares = with_waves[16 : NODES // 4] ** 2 / expected[16:] ** 2
    assert squares.mean() == pytest.approx(1, abs=3 / math.sqrt(len(squares)))


# ---- files of roundness


def written(folder: Path, text: str, name: str = "ring.csv") -> Path:
    """Write a file of roundness."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_measured_roundness_keeps_its_waves_and_the_law_goes_on_beyond(tmp_path: Path) -> None:
    """Parseval: the mean square of the heights is half the sum of the squares of amplitudes."""
    path = written(tmp_path, "order;amplitude;phase\n1;3;0\n2;0.1;30\n8;0.05;-60\n\n40;0.002;170\n")
    waves = read_waves(path, "um")
    assert [wave[0] for wave in waves] == [2, 8, 40]
    heights = form_heights(BallForm(measured_m=waves), NODES)
    squares = sum(amplitude_m**2 for _, amplitude_m, _ in waves) / 2
    assert np.mean(heights**2) == pytest.approx(squares, rel=1e-12)
    angle = 2 * np.pi * 1000 / NODES
    summed = sum(amplitude * math.cos(order * angle + phase) for order, amplitude, phase in waves)
    assert heights[1000] == pytest.approx(summed, rel=1e-9)
    form = form_of(raceway(roundness={"path": "ring.csv"}), tmp_path)
    found = orders_of(form_heights(form, NODES))
    assert found[2] == pytest.approx(1e-7) and found[8] == pytest.approx(5e-8)
    assert found[3:8].max() < 1e-20 and found[9:40].max() < 1e-20 and found[41] > 1e-11


@pytest.mark.parametrize("text", ["8, 0.05, 120", "8;0,05;120", "8\t0.05\t120", "8 5e-2 1.2e2"])
def test_orders_are_read_between_all_usual_signs(tmp_path: Path, text: str) -> None:
    ((order, amplitude_m, phase),) = read_waves(written(tmp_path, f"# a ring\n{text}\n"), "um")
    assert (order, amplitude_m) == (8, pytest.approx(5e-8))
    assert phase == pytest.approx(math.radians(120))


def test_measured_roundness_moves_the_approach_of_a_bearing(tmp_path: Path) -> None:
    """Its wave of order 9 stands in the track of the raceway, as the contact averages it."""
    written(tmp_path, "9, 100, 0\n", "ring.txt")
    keys = {"kind": "raceway", "finish": "superfinished"}
    keys |= {"roundness": {"path": "ring.txt", "height_unit": "nm"}}
    scene = bearing_scene(outer=keys)
    scene._folder = tmp_path
    plan = contact_plan(scene)
    track = bearing_tracks(plan).outer.approach_m[0]
    assert 2 / len(track) * abs(np.fft.rfft(track)[9]) == pytest.approx(1e-7, rel=0.02)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "holds no waves"),
        ("2, 0.1\n", 'ring.csv:1: got "2 0.1", allowed: order, amplitude and phase'),
        ("2, 0.1, 0\n2, 0.2, 0\n", "ring.csv:2: the order 2 stands twice"),
        ("2.5, 0.1, 0\n", "a whole order from 0 to 50000"),
        ("2, -0.1, 0\n", "an amplitude from 0 to 1000 um"),
        ("2, nan, 0\n", 'got "2 nan 0"'),
        ("2, 0.1, 0\nend of file\n", 'ring.csv:2: got "end of file"'),
        ("9" * 400 + ", 0.1, 0\n", "ring.csv:1: got"),
    ],
)
def test_a_bad_file_of_roundness_has_one_clear_message(
    tmp_path: Path, text: str, words: str
) -> None:
    with pytest.raises(HeightFormatError) as error:
        read_waves(written(tmp_path, text), "um")
    assert words in error.value.of("ring.csv")


def test_a_file_of_roundness_is_bounded_and_missing_ones_are_named(tmp_path: Path) -> None:
    written(tmp_path, "2, 0.1, 0\n" * (MAX_BYTES // 10 + 1))
    scene = bearing_scene(inner={"kind": "raceway", "finish": "ground", "roundness": {"path": "x"}})
    scene._folder = tmp_path
    with pytest.raises(rolling.SceneError, match=r"inner.roundness.path: .*allowed: .csv or .txt"):
        contact_plan(scene)
    with pytest.raises(HeightFormatError, match=f"larger than {MAX_BYTES:,} bytes"):
        read_waves(tmp_path / "ring.csv", "um")
    with pytest.raises(HeightFormatError, match="no such file"):
        read_waves(tmp_path / "none.csv", "um")


# ---- what is assumed


@pytest.mark.law("Raceways: linear theory gives the mean velocity by the waves of a law.")
def test_the_expected_power_of_orders_is_that_of_the_moved_ring() -> None:
    """Single waves on each body, whose motion is integrated, against the power by orders."""
    case = model()
    for body, order, direction in (("inner", 9, RADIAL), ("outer", 16, AXIAL), ("balls", 4, AXIAL)):
        amplitudes = np.zeros(32)
        amplitudes[order] = 1e-8
        waves = AssumedWaves(body, amplitudes, 1.0, False, 0.0, np.zeros(32))
        gains = order_gains(waves.body, case, BANDS, len(waves.amplitudes_m))
        powers = order_powers(waves, case, gains)[direction]
        waved = {0: {order: 1e-8}} if body == "balls" else {order: 1e-8}
        tracks = with_waves(smooth_tracks(case.geometry), **{body: waved})
        record = record_of(move_ring(case, tracks, 0.25, 48_000), case.kinematics)
        moved = sum(record.bands[direction].rms_m_s[band] ** 2 for band in BANDS)
        bodies = case.geometry.balls if body == "balls" else 1
        assert sum(power.sum() for power in powers.values()) / bodies == pytest.approx(
            moved, rel=0.04
        ), body


def test_assumed_amplitudes_count_by_their_share_and_raceways_together() -> None:
    """Both raceways alone have the whole ±; beside as much power of something else half of it."""
    case = model()
    amplitudes = np.zeros(32)
    amplitudes[9] = 1e-8
    bodies = [
        AssumedWaves(body, amplitudes, 1.0, False, 40.0, np.zeros(32))
        for body in ("inner", "outer")
    ]
    powers = [
        order_powers(waves, case, order_gains(waves.body, case, BANDS, len(waves.amplitudes_m)))
        for waves in bodies
    ]
    own: dict[str, dict[str, float]] = {}
    for direction in DIRECTIONS:
        sums = {band: sum(power[direction][band].sum() for power in powers) for band in BANDS}
        own[direction] = {band: math.sqrt(value) for band, value in sums.items()}
    alone = surfaces_db(bodies, case, own, BANDS)
    assert alone[RADIAL]["low"] == pytest.approx(40.0, rel=1e-3)
    more = {
        direction: {band: math.sqrt(2) * value for band, value in bands.items()}
        for direction, bands in own.items()
    }
    assert surfaces_db(bodies, case, more, BANDS)[RADIAL]["low"] == pytest.approx(20.0, rel=1e-3)
    nothing = {direction: dict.fromkeys(BANDS, 0.0) for direction in DIRECTIONS}
    assert surfaces_db([], case, nothing, BANDS)[AXIAL] == {"low": 0.0, "medium": 0.0}


@pytest.mark.parametrize(("order", "exponent"), [(16, 1.0), (100, 1.0), (360, 1.0), (100, 1.3)])
def test_waves_without_crests_are_averaged_over_the_width_too(order: int, exponent: float) -> None:
    """A plain sum over equal steps of the wave number across, of the inner contact."""
    case = model()
    contact = case.geometry.inner
    axes = semi_axes(contact, case.balances()[0].ball_load_n.mean())
    along = order / contact.radius_m
    across = np.linspace(0, 400 * along, 400_001)
    density = (along**2 + across**2) ** -(exponent + 0.5)
    phase = np.hypot(along * axes.along, across * axes.across)
    mean = (density * np.sinc(phase / np.pi) ** 2).sum() / density.sum()
    wanted = 10 * math.log10(mean / np.sinc(along * axes.along / np.pi) ** 2)
    waves = AssumedWaves("inner", np.ones(1024), exponent, True, 0.0, np.zeros(1024))
    assert crests_db(waves, case)[order] == pytest.approx(wanted, abs=0.15)


def test_isotropic_waves_stand_in_the_tracks_and_known_orders_keep_their_crests() -> None:
    keys = {"kind": "raceway", "finish": "superfinished", "seed": 3, "waviness": {9: 1.0}}
    tracks = []
    for crests in ("across", "isotropic"):
        plan = contact_plan(bearing_scene(inner=keys | {"wave_crests": crests}))
        smooth = replace(plan, rough={})  # the waves alone, without the roughness
        tracks.append(np.fft.rfft(bearing_tracks(smooth).inner.approach_m[0]))
    across, isotropic = tracks
    scene = bearing_scene(inner=keys)
    waves = AssumedWaves("inner", np.ones(512), 1.0, True, 0.0, np.zeros(512))
    wanted = crests_db(waves, scene.model)
    shares = 20 * np.log10(np.abs(isotropic[2:400]) / np.abs(across[2:400]))
    others = np.delete(shares - wanted[2:400], 7)
    assert np.abs(others).max() < 1.0  # the lightest load has a smaller contact than the mean one
    assert shares[7] == pytest.approx(0, abs=0.05)


def test_what_a_scene_states_itself_is_not_assumed() -> None:
    scene = bearing_scene(
        balls={"kind": "graded", "grade": "G10", "wave_exponent": 1},
        inner={"kind": "raceway", "finish": "superfinished"},
        outer={"kind": "raceway", "finish": "superfinished"}
        | {"wave_amplitude_um": 0.1, "wave_exponent": 1.2},
    )
    balls, inner = assumed_waves(scene)
    assert (balls.body, balls.amplitude_db) == ("balls", FORM_DB)
    assert (inner.body, inner.amplitude_db) == ("inner", AMPLITUDE_DB)
    assert inner.exponent_db[3] == pytest.approx(0) and inner.exponent_db[2] < 0
    assert exponent_db(400)[300] == pytest.approx(20 * math.log10(100) * 0.2 / math.sqrt(3))
    rows = {row.key: row.value for row in scene.check()}
    assert "surfaces.inner.wave_amplitude_um" in rows["assumed"]
    assert "surfaces.outer.wave_amplitude_um" not in rows["assumed"]


# ---- roughness that is assumed


@pytest.mark.law("Raceways: long roughness moves a contact by all of its height.")
def test_a_contact_follows_roughness_that_is_longer_than_itself() -> None:
    """The mean square over all orders is that of the heights, where each has a gain of 1."""
    law = RoughnessLaw(rq_m=3e-8, along_m=3e-3, across_m=8e-3)
    gains = {direction: {"all": np.ones(2048)} for direction in DIRECTIONS}
    powers = roughness_powers("inner", law, model(), gains)
    assert powers[RADIAL]["all"] == pytest.approx(2 * law.rq_m**2, rel=0.05)


def test_the_power_of_roughness_is_that_of_its_heights() -> None:
    """Made heights of 16 mm of track, whose waves scatter by 1 dB where no resonance picks few."""
    rough = {"kind": "raceway", "finish": "honed", "correlation_length_um": 60.0}
    scene = bearing_scene(outer=rough | {"seed": 3}).with_({"bearing.contact_loss_factor": 0.3})
    (roughness,) = assumed_roughness(scene)
    gains = order_gains("outer", scene.model, VELOCITY_BANDS_HZ, orders=8192)
    powers = roughness_powers("outer", roughness.law, scene.model, gains)[RADIAL]
    made_power = marched_powers(contact_plan(scene), {}, scene.model)["outer"]
    for band in ("medium", "high"):
        wanted = float(made_power.of_band(RADIAL, band).sum())
        assert 10 * math.log10(powers[band] / wanted) == pytest.approx(0, abs=1.0), band


def test_orders_beyond_the_shortest_roughness_have_no_power() -> None:
    """A ring that hardly turns has 300 million orders below the end of the bands."""
    scene = bearing_scene(outer={"kind": "raceway", "finish": "honed"})
    (roughness,) = assumed_roughness(scene)
    laws = [roughness.law]
    for ends in roughness.others.values():
        laws.extend(ends)
    orders = assumed_surfaces._orders_of(roughness, scene.model)
    some = order_gains("outer", scene.model, VELOCITY_BANDS_HZ, orders=orders)
    many = order_gains("outer", scene.model, VELOCITY_BANDS_HZ, orders=4 * orders)
    for law in laws:
        few = roughness_powers("outer", law, scene.model, some)[RADIAL]
        assert few == pytest.approx(roughness_powers("outer", law, scene.model, many)[RADIAL])
    slow = scene.with_({"bearing.speed_rpm": 0.001})
    gains = order_gains("outer", slow.model, VELOCITY_BANDS_HZ, orders=orders)
    assert len(gains[RADIAL]["high"]) == orders < 20_000


def test_assumed_roughness_counts_by_the_range_of_its_power() -> None:
    """Alone, Ra from half to twice has 20 log10(4) / sqrt(12); beside all else it has nothing."""
    case = model()
    law = RoughnessLaw(rq_m=3e-8, along_m=5e-4, across_m=1e-5)
    ends = law._replace(rq_m=1.5e-8), law._replace(rq_m=6e-8)
    rough = [AssumedRoughness(body, law, {"ra": ends}) for body in ("inner",)]
    nothing = {direction: dict.fromkeys(BANDS, 0.0) for direction in DIRECTIONS}
    alone = surfaces_db(rough, case, nothing, BANDS)
    assert alone[RADIAL]["medium"] == pytest.approx(20 * math.log10(4) / math.sqrt(12))
    much = {direction: dict.fromkeys(BANDS, 1.0) for direction in DIRECTIONS}
    assert surfaces_db(rough, case, much, BANDS)[RADIAL]["medium"] < 0.01


def test_roughness_is_assumed_as_far_as_its_finish_assumes_it() -> None:
    """A Ra with a source and a length of one's own are not; ends of Ra move the stylus's filter."""
    scene = bearing_scene(
        inner={"kind": "raceway", "finish": "superfinished", "correlation_length_um": 80.0},
        outer={"kind": "raceway", "finish": "honed"},
    )
    inner, outer = assumed_roughness(scene)
    assert set(inner.others) == {"length_across"}
    assert set(outer.others) == {"ra", "length", "length_across"}
    low, high = outer.others["ra"]
    law = raceway(finish="honed", roughness_ra_um=0.02).law
    assert low.rq_m == pytest.approx(law.rq_m) and high.rq_m > outer.law.rq_m > low.rq_m
    assert [law.along_m for law in outer.others["length"]] == pytest.approx([2.5e-4, 1e-3])
