"""Errors of band levels from synthetic releases whose filter and noise are known."""

from dataclasses import replace

import numpy as np
import pytest

from acoustics.bands import BAND_NAMES, BANDWIDTH_HZ, EDGES_HZ, MID_HZ
from rolling.sound import error_estimate
from rolling.sound.error_estimate import (
    LevelErrors,
    RecordLevels,
    StretchSignals,
    band_powers,
    level_errors,
    worst_uncertainty_db,
)

STEP = 2e-6  # at 0.1 m/s: 50 kHz
SPEED = 0.1
STEPS = 200
FLAT = RecordLevels(np.ones(31), np.ones(31), own_factor=False)


def band(name: str) -> int:
    return BAND_NAMES.index(name)


def filtered(signal: np.ndarray, gain_db: np.ndarray) -> np.ndarray:
    """Filter whole rows with a gain by line of their transform."""
    lines = np.fft.rfft(signal, axis=-1) * 10 ** (gain_db / 20)
    return np.fft.irfft(lines, signal.shape[-1], axis=-1)


@pytest.fixture(autouse=True)
def scatter_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let uncertainties hold the scatter of stretches alone."""
    monkeypatch.setattr(error_estimate, "DOUBT", 0.0)


def stretches(
    gain_db: float = 0.0,
    noise: float = 0.0,
    solver_noise: float = 0.0,
    order: float = 1.0,
    count: int = 16,
    seed: int = 1,
    speeds: np.ndarray | None = None,
    top_db: float | None = None,
    tolerance_ratio: float = 0.1,
) -> StretchSignals:
    """Make releases whose error halves `order` times with each halving of the spacing.

    At the own spacing the error is a gain that rises linearly from `gain_db` to `top_db` at the
    Nyquist frequency, and independent noise.
    """
    rng = np.random.default_rng(seed)
    long = 4 * STEPS
    true = 1 + 0.1 * rng.standard_normal((count, long))
    rise = np.linspace(gain_db, gain_db if top_db is None else top_db, long // 2 + 1)
    rise[0] = 0.0

    def level(times: float, tolerance: float) -> np.ndarray:
        share = times**-order
        extra = noise * share * errors + solver_noise * tolerance * solver_errors
        return (filtered(true, rise * share) + extra)[:, STEPS : 2 * STEPS]

    errors, solver_errors = 0.1 * rng.standard_normal((2, count, long))
    return StretchSignals(
        own=level(1, 1.0),
        tight=level(1, tolerance_ratio),
        fine=level(2, tolerance_ratio),
        coarse=level(0.5, 1.0),
        step=STEP,
        speeds=np.full((count, 1), SPEED) if speeds is None else speeds,
        tolerance_ratio=tolerance_ratio,
    )


def errors_of(releases: StretchSignals, record: RecordLevels = FLAT) -> LevelErrors:
    return level_errors(band_powers(releases), record)


def test_a_known_gain_is_the_error_of_every_band_and_of_laeq() -> None:
    found = errors_of(stretches(gain_db=0.1))
    assert found.grid_db == pytest.approx(0.1, abs=1e-3)
    assert found.order == pytest.approx(1.0, abs=0.02) and found.order_measured
    # A gain of 0.1 dB is off by 1.2 % of the signal.
    assert found.grid_signal_db == pytest.approx(20 * np.log10(10 ** (0.1 / 20) - 1), abs=0.1)


@pytest.mark.parametrize("order", [0.6, 1.0, 1.4])
def test_the_order_of_the_signal_extrapolates_its_error(order: float) -> None:
    found = errors_of(stretches(gain_db=0.1, order=order))
    assert found.order == pytest.approx(order, abs=0.05)
    assert found.grid_db == pytest.approx(0.1, abs=3e-3)


@pytest.mark.parametrize("order", [0.6, 1.0, 1.5])
@pytest.mark.parametrize("common", [False, True])
def test_an_order_extrapolates_only_the_common_shape_of_errors(
    order: float, common: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Errors of -20 dB are known within 1.5 dB; below order 1 a common shape is in doubt."""
    monkeypatch.setattr(error_estimate, "DOUBT", 0.5)
    rng = np.random.default_rng(7)
    true, shared = rng.standard_normal((2, 16, STEPS))
    own, fine, coarse = (
        true + 0.1 * share * (shared if common else rng.standard_normal((16, STEPS)))
        for share in (1.0, 2**-order, 2**order)
    )
    found = errors_of(replace(stretches(), own=own, tight=own, fine=fine, coarse=coarse))
    assert abs(found.grid_signal_db + 20) < max(1.5, 2 * found.grid_signal_uncertainty_db)
    assert found.grid_signal_uncertainty_db < 4


def test_a_mean_over_stretches_is_in_doubt_by_its_whole_difference() -> None:
    """A difference of 10 % is extrapolated with order 1.5, 1.55 times as far."""
    fine = np.full(4, 2e-12)
    error, spread = error_estimate.mean_error(1.1 * fine, fine)
    assert error == pytest.approx(1.1**1.547 - 1, rel=1e-3)
    assert spread == pytest.approx(1.1**1.547 * np.log(1.1), rel=1e-3)
    assert np.isnan(error_estimate.mean_error(0 * fine, fine)).all()
    single = np.eye(4)[0] * 1e-12
    assert not np.isfinite(error_estimate.mean_error(single, 2 * single)[1])


@pytest.mark.parametrize(("order", "limit"), [(0.3, 0.5), (2.0, 1.5)])
def test_the_order_is_limited(order: float, limit: float) -> None:
    assert errors_of(stretches(gain_db=0.1, order=order)).order == limit


def test_too_loud_is_positive_and_too_quiet_negative() -> None:
    assert np.all(errors_of(stretches(gain_db=0.5)).grid_db > 0)
    assert np.all(errors_of(stretches(gain_db=-0.5)).grid_db < 0)


def test_errors_follow_the_frequency() -> None:
    found = errors_of(stretches(top_db=0.5, count=32))
    expected = np.interp(MID_HZ, [0, 25e3], [0, 0.5])
    for name in ("2000", "4000", "8000", "16000"):
        k = band(name)
        assert found.grid_db[k] == pytest.approx(expected[k], abs=0.02)


def test_independent_noise_is_found_within_its_standard_error() -> None:
    """Twice the standard errors hold for 95 % of the bands."""
    noise = 10 ** (-12 / 20)
    added = 10 * np.log10(1 + noise**2)
    outside = 0
    total = 0
    for seed in range(60):
        found = errors_of(stretches(noise=noise, seed=seed))
        judged = slice(band("2000"), band("20000"))
        # The mean square falls fourfold, the signal's order 1 extrapolates as if it fell twofold.
        expected = 2 * (added - 10 * np.log10(1 + noise**2 / 4))
        off = np.abs(found.grid_db[judged] - expected) > 2 * found.grid_uncertainty_db[:-1][judged]
        outside = outside + int(off.sum())
        total = total + off.size
        assert found.grid_signal_db == pytest.approx(-12, abs=1.0)
    assert outside < 0.06 * total


def test_a_jackknife_that_sees_no_scatter_leaves_that_of_independent_lines() -> None:
    """Differences of a share e of the power scatter n lines by 4.34 sqrt(2 e / n) dB.

    Lines of a Hann window overlap: n of them are as many as 18/35 n independent lines.
    """
    powers = band_powers(stretches(noise=0.3, count=4))
    same = np.broadcast_to(powers.sums.mean(axis=0), powers.sums.shape)  # no scatter is seen
    found = level_errors(replace(powers, sums=same), FLAT)
    group = list(powers.groups[-1])
    fine, grid = (same[0, row, group].sum() for row in (2, 4))
    lines = 4 * powers.lines[group].sum() * 18 / 35
    expected = 2 * 4.34 * np.sqrt(2 * grid / fine / lines)  # order 1
    # The lines of all groups hold more degrees of freedom than the jackknife, which says zero.
    assert 0.6 * expected < found.grid_uncertainty_db[group] < 1.1 * expected


def test_a_band_of_the_record_has_an_error_of_its_own_few_lines() -> None:
    """The third octave at 160 Hz (36.7 Hz wide) holds 5.9 lines in 0.16 s, that at 630 Hz 23.

    A noise of one shape that halves with each halving of the spacing errs by twice its difference.
    """
    powers = band_powers(stretches(noise=0.3, count=4))
    white = replace(FLAT, z=np.array(BANDWIDTH_HZ))
    long, short = (
        level_errors(powers, replace(white, seconds=seconds)).grid_uncertainty_db
        for seconds in (np.inf, 0.16)
    )
    group = list(powers.groups[0])
    fine, grid = (powers.sums[:, row, group].sum() for row in (2, 4))
    expected = 2 * 4.34 * np.sqrt(2 * grid / fine / np.array([5.9, 23.2]))
    chosen = [band("160"), band("630")]
    own = np.sqrt(short[chosen] ** 2 - long[chosen] ** 2)
    assert own[0] / own[1] == pytest.approx(np.sqrt(23.2 / 5.9), rel=0.02)
    assert own == pytest.approx(expected, rel=0.25)  # the jackknife of four stretches takes part


def test_a_band_of_a_vibration_is_quiet_by_its_approach_not_by_its_sound() -> None:
    """A chain that carries little of a band carries as little of its differences.

    The same approach with and without a chain that is 20 dB weaker below 400 Hz has the same
    uncertainty of its own in a low band.
    """
    weaker = np.where(np.array(MID_HZ) < 400, 0.01, 1.0)
    own = []
    for gain in (np.ones(31), weaker):
        signals = replace(
            stretches(noise=0.3, count=4),
            gain=lambda f, gain=gain: gain[np.searchsorted(EDGES_HZ[1:-1], f)],
        )
        powers = band_powers(signals)
        record = replace(FLAT, z=np.array(BANDWIDTH_HZ) * gain)
        long, short = (
            level_errors(powers, replace(record, seconds=seconds)).grid_uncertainty_db[band("160")]
            for seconds in (np.inf, 0.16)
        )
        own.append(short**2 - long**2)
    assert own[1] == pytest.approx(own[0], rel=0.1)


def test_stretches_that_are_most_of_the_record_know_its_error_better() -> None:
    """A band above the shared ones has its lines in common with the stretches."""
    powers = band_powers(stretches(noise=0.3, count=8))
    white = replace(FLAT, z=np.array(BANDWIDTH_HZ))
    marched_s = 8 * STEPS * STEP / SPEED
    whole, tenfold, endless = (
        level_errors(powers, replace(white, seconds=seconds)).grid_uncertainty_db[band("8000")]
        for seconds in (marched_s, 10 * marched_s, np.inf)
    )
    assert whole < 0.9 * tenfold
    assert tenfold < endless


def test_bands_that_share_an_error_are_uncertain_by_its_change_to_the_next() -> None:
    """The shared error lies a tenth of the Nyquist frequency below the next: 1 dB of 10."""
    powers = band_powers(stretches(top_db=10.0, count=32))
    found = level_errors(powers, FLAT)
    group, other = (groups[0] for groups in powers.groups[:2])
    change = abs(found.grid_db[other] - found.grid_db[group])
    assert change > 0.1
    assert found.grid_uncertainty_db[group] > 0.7 * change


def test_standard_errors_are_those_over_other_stretches() -> None:
    many = [errors_of(stretches(noise=0.3, seed=seed)) for seed in range(40)]
    spread = np.std([each.grid_db for each in many], axis=0)
    stated = np.sqrt(np.mean([each.grid_uncertainty_db**2 for each in many], axis=0))
    judged = slice(band("1600"), band("20000"))
    ratio = stated[judged] / spread[judged]
    # 40 seeds tell a spread within 11 %, and their rms over eleven bands within some 5 %.
    assert np.sqrt(np.mean(ratio**2)) == pytest.approx(1.0, abs=0.25)
    assert np.all(ratio > 0.65)
    assert np.all(ratio < 1.7)
    laeq = np.std([each.grid_db[-1] for each in many])
    assert np.mean([each.grid_uncertainty_db[-1] for each in many]) == pytest.approx(laeq, rel=0.4)


def test_standard_errors_of_four_stretches_hold_as_often_as_those_of_gaussian_errors() -> None:
    """Gaussian errors lie in 68 % within one and in 95 % within two standard errors."""
    gain = 0.5
    noise = 0.1
    offs = []
    for seed in range(100):
        found = errors_of(stretches(gain_db=gain, noise=noise, count=4, seed=seed))
        offs.append((found.grid_db - gain) / found.grid_uncertainty_db)
    judged = np.abs(np.array(offs)[:, band("2000") : band("20000")])
    # Ten bands of 100 seeds share some lines; independent ones would count within 1.5 %.
    assert 0.60 < np.mean(judged < 1) < 0.76
    assert 0.91 < np.mean(judged < 2) < 0.985


def test_the_extrapolated_part_is_in_doubt_by_half(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(error_estimate, "DOUBT", 0.5)
    found = errors_of(stretches(gain_db=0.1, count=32))
    # At order 1 half of the error is extrapolated.
    assert found.grid_uncertainty_db == pytest.approx(0.025, rel=0.1)


def test_four_times_the_stretches_halve_the_standard_error() -> None:
    """Student's factor is nearly one, because the lines of all groups tell the scatter."""
    few, many = (
        np.mean(
            [
                worst_uncertainty_db(band_powers(stretches(noise=0.3, count=n, seed=s)))
                for s in range(6)
            ]
        )
        for n in (8, 32)
    )
    assert few / many == pytest.approx(2, rel=0.3)


def test_a_solver_error_is_told_from_an_error_of_the_grid() -> None:
    found = errors_of(stretches(solver_noise=0.2))
    judged = slice(band("2000"), band("20000"))
    assert np.nanmean(found.solver_db[judged]) == pytest.approx(10 * np.log10(1.04) / 0.9, abs=0.1)
    assert found.solver_signal_db == pytest.approx(20 * np.log10(0.2), abs=0.5)
    assert np.all(np.abs(found.grid_db[judged]) < 0.05)


def test_the_solver_error_is_unknown_where_no_tighter_tolerance_was_solved() -> None:
    found = errors_of(stretches(gain_db=0.1, tolerance_ratio=1.0))
    assert np.isnan(found.solver_db).all() and np.isnan(found.solver_signal_db)
    assert found.grid_db[-1] == pytest.approx(0.1, abs=1e-3)


def test_half_of_a_common_error_cancels_in_a_record_with_its_own_factor() -> None:
    own = RecordLevels(np.ones(31), np.ones(31), own_factor=True)
    found = errors_of(stretches(gain_db=0.1), own)
    assert found.grid_db == pytest.approx(0.05, abs=1e-3)


def test_laeq_is_weighted_by_the_bands_of_the_record() -> None:
    heard = np.zeros(31)
    heard[band("8000")] = 1.0
    found = errors_of(stretches(top_db=5.0), RecordLevels(np.ones(31), heard, own_factor=False))
    assert found.grid_db[-1] == pytest.approx(found.grid_db[band("8000")], abs=1e-9)


def test_bands_below_1_khz_share_an_estimate() -> None:
    powers = band_powers(stretches(top_db=5.0))
    found = level_errors(powers, FLAT)
    assert [BAND_NAMES[k] for k in powers.groups[0]] == list(BAND_NAMES[: band("1000")])
    assert len(set(found.grid_db[: band("1000")])) == 1
    assert found.grid_db[band("4000")] != found.grid_db[band("2500")]


def test_bands_of_a_stretch_without_enough_lines_join_the_next() -> None:
    """At lines of 1 kHz the first two usable lines are 2 and 3 kHz."""
    powers = band_powers(stretches(speeds=np.full((16, 1), 4 * SPEED)))
    assert BAND_NAMES[powers.groups[0][-1]] == "3150"
    assert np.isfinite(level_errors(powers, FLAT).grid_db).all()
    for group in powers.groups[1:]:
        low = EDGES_HZ[group[0]]
        high = EDGES_HZ[group[-1] + 1]
        assert high - low >= 1000


def test_bands_above_the_steps_have_no_error() -> None:
    powers = band_powers(stretches(gain_db=0.1, speeds=np.full((16, 1), SPEED / 10)))  # 2.5 kHz
    found = level_errors(powers, FLAT)
    assert np.isnan(found.grid_db[band("4000") : -1]).all()
    assert np.isfinite(found.grid_db[: band("2000")]).all()
    silent = FLAT.z.copy()
    silent[band("2000") :] = np.nan
    found = level_errors(powers, RecordLevels(silent, silent, own_factor=True))
    assert np.isnan(found.grid_db[band("2000") : -1]).all()
    assert found.grid_db[-1] == pytest.approx(0.05, abs=1e-3)


def test_a_stretch_counts_at_each_of_its_speeds() -> None:
    """At twice the speed the same lines stand an octave higher and hold twice the energy."""
    both = np.full((16, 2), SPEED)
    both[:, 1] *= 2
    slow, fast, together = (
        band_powers(stretches(top_db=5.0, speeds=each)) for each in (both[:, :1], both[:, 1:], both)
    )
    assert together.sums == pytest.approx(slow.sums + fast.sums)
    assert fast.sums.sum() / slow.sums[:, :, : band("12500")].sum() == pytest.approx(2, rel=0.02)
    resting = both.copy()
    resting[:, 1] = 0.0
    assert band_powers(stretches(top_db=5.0, speeds=resting)).sums == pytest.approx(slow.sums)


def test_equal_levels_have_no_order_and_no_error() -> None:
    found = errors_of(stretches())
    assert not found.order_measured and found.order == 1.0
    assert found.grid_db == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(found.grid_signal_db)


def test_silent_stretches_have_no_numbers() -> None:
    still = np.ones((4, STEPS))
    releases = StretchSignals(still, still, still, still, STEP, np.full((4, 1), SPEED), 0.1)
    powers = band_powers(releases)
    assert worst_uncertainty_db(powers) == np.inf
    found = level_errors(powers, FLAT)
    assert np.isnan(found.grid_db).all()


def test_one_stretch_has_no_standard_error() -> None:
    powers = band_powers(stretches(gain_db=1.0, count=1))
    assert worst_uncertainty_db(powers) == np.inf
    assert np.isnan(level_errors(powers, FLAT).grid_uncertainty_db).all()


def test_a_band_that_carries_no_sound_does_not_ask_for_stretches() -> None:
    powers = band_powers(stretches(noise=0.3))
    sums = powers.sums.copy()
    k = band("16000")
    sums[:, :, k] *= 1e-8 * np.random.default_rng(3).uniform(0.1, 10, sums.shape[:2])
    assert worst_uncertainty_db(replace(powers, sums=sums)) < 1.0


def test_the_gain_of_a_vibration_weighs_the_bands() -> None:
    """An error that rises with the frequency counts where the chain carries sound."""
    rising = replace(stretches(top_db=2.0), gain=lambda frequency: np.ones(len(frequency)))
    flat = errors_of(rising)
    low, high = (
        replace(rising, gain=lambda f, top=top: np.where(f < top, 1.0, 1e-6)) for top in (5e3, 2e4)
    )
    for name in ("2000", "8000"):  # ratios of powers do not depend on a gain within a band
        assert errors_of(high).grid_db[band(name)] == pytest.approx(
            flat.grid_db[band(name)], abs=0.01
        )
    assert errors_of(low).grid_signal_db < errors_of(high).grid_signal_db - 3
    # A slow pass over the same waves lasts longer.
    powers = [
        band_powers(
            replace(
                rising,
                speeds=np.full((16, 1), speed),
                gain=lambda f, speed=speed: np.where(f < 1e5 * speed, 1.0, 0.0),
            )
        ).sums.sum()
        for speed in (SPEED / 2, SPEED)
    ]
    assert powers[0] == pytest.approx(2 * powers[1], rel=0.01)
