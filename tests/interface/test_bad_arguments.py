"""Every public function names the argument that it refuses, and takes arrays of every layout."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import acoustics
import rolling as rc

RATE = 48000
TONE = np.sin(2 * np.pi * 1000 * np.arange(4800) / RATE)
FLAT = np.zeros((64, 64))
X = np.arange(-12, 13) * 2e-6
GAP = (X[:, None] ** 2 + X**2) / 0.01
STEEL = rc.HalfSpace(2e-6, 230e9)
CONTACT = {
    "heights": FLAT, "spacing": 4e-6, "radius": 1e-3, "contact_modulus": 230e9, "hardness": 2e9,
    "load": 0.05, "step": 4e-6, "start": 0.0, "tolerance": 1e-5,
}  # fmt: skip
ROLLING = rc.RollingContact(**CONTACT)
HERTZ = {"load": 5.0, "radius": 5e-3, "contact_modulus": 230e9}
RECORD = {"pressure_pa": TONE, "sample_rate_hz": RATE}
SIGNAL = {"signal": TONE, "sample_rate_hz": RATE}
forms = rc.closed_forms

# Valid arguments of every public function; the arguments that are left out may be anything.
CALLS: dict[Callable[..., Any], dict[str, Any]] = {
    rc.HalfSpace: {"spacing": 2e-6, "contact_modulus": 230e9},
    STEEL.deflection: {"pressure": FLAT + 1e9},
    rc.solve_contact: {
        "half_space": STEEL, "gap": GAP, "load": 0.02, "start": None, "hardness": 2e9,
        "shape": GAP, "tolerance": 1e-5, "single": True,
    },
    rc.RollingContact: CONTACT | {
        "loads": np.full(5, 0.05), "subcells": 1, "radius_across": 1e-3, "single": True,
        "blended": True, "slopes": True,
    },
    rc.march: {
        "contact": ROLLING, "first": 0, "last": 1, "half_space": rc.HalfSpace(4e-6, 230e9)
    },
    rc.surface_parameters: {"heights": GAP, "spacing_um": 2.0},
    rc.HeightArray: {"heights": GAP, "spacing_um": 2.0},
    forms.contact_modulus: {
        "youngs_modulus": 210e9, "poissons_ratio": 0.3, "other_modulus": 70e9, "other_ratio": 0.2
    },
    forms.hertz_radius: HERTZ,
    forms.hertz_pressure: HERTZ,
    forms.hertz_approach: HERTZ,
    forms.hertz_ellipse: {"radius": 1.0, "radius_across": 0.5},
    forms.hertz_force: {"energy": 1e-3, "radius": 5e-3, "contact_modulus": 230e9},
    forms.hertz_impact_time: {"mass": 1e-3, "speed": 1.0, "radius": 5e-3, "contact_modulus": 1e11},
    forms.smooth_release_power: HERTZ | {"speed": 1.0},
    forms.left_end_excess: {"step": 1e-6, "contact_radius": 5e-5},
    acoustics.a_weighting_db: {"frequency_hz": acoustics.MID_HZ},
    acoustics.band_uncertainty_db: {"duration_s": 1.0},
    acoustics.reliable: {"duration_s": 1.0},
    acoustics.third_octave_mean_square: {
        "frequency_hz": np.array([990.0, 1010.0]), "line_mean_square": np.array([1.0, 2.0])
    },
    acoustics.level_db: {"mean_square": 1.0, "reference": 4e-10},
    acoustics.laeq_db: RECORD,
    acoustics.lae_db: RECORD,
    acoustics.is_single_event: RECORD,
    acoustics.sound_levels: RECORD | {"highest_hz": 20e3, "closed": True},
    acoustics.loudest_octave: SIGNAL,
    acoustics.modulated_octave: SIGNAL | {
        "frequency_hz": 20.0, "closed": True, "gain": np.ones(len(TONE))
    },
    acoustics.envelope_spectrum: SIGNAL | {
        "band_hz": (500.0, 2000.0), "closed": False, "gain": np.ones(len(TONE))
    },
    acoustics.line_spectrum: SIGNAL,
    acoustics.welch: SIGNAL,
    acoustics.intensity: {"power_w": TONE, "distance_m": 1.0, "q": 1.0},
    acoustics.sound_pressure: {"intensity_fluctuation": TONE, "gain_pa_per_w_m2": 1.0},
    acoustics.level_uncertainty: RECORD | {
        "levels": acoustics.sound_levels(TONE, RATE), "own_factor": True, "laps": 1.0
    },
    acoustics.wav.listening: {"gain": 0.5, "loops": False, "pressure_pa": TONE, "comment": ""},
    acoustics.wav.listening_gain: {"pressure_pa": TONE, "target_rms": 0.1, "peak": 0.9},
    acoustics.kurtosis: {"record": TONE},
    acoustics.kurtosis_uncertainty: {"record": TONE},
}  # fmt: skip
BAD_NUMBERS = (np.nan, "1", 1j, [1.0, 2.0], np.ones(3), object(), -1.0)
BAD_ARRAYS = (
    "1", object(), 1.0, [], [[1], [1, 2]], np.zeros((2, 2, 2)), np.full((5, 5), 1j),
    np.full((5, 5), np.nan), np.full(5, np.inf), np.full(5, 1j), np.full(5, np.nan),
)  # fmt: skip
# Values that are bad elsewhere and have a meaning here.
ANY_SIGN = {"start", "first", "last", "mean_square", "q", "gain"}
ANY_SHAPE = {"power_w", "frequency_hz"}  # of one function each
CASES = [
    (call, name)
    for call, arguments in CALLS.items()
    for name, value in arguments.items()
    if not isinstance(value, str)
]
# Numbers that are infinite, beyond double precision, or so far off that sums lose their digits.
EXTREME = (np.inf, -np.inf, np.float64(np.inf), 10**400, True)
MAY_BE_INFINITE = {"hardness", "highest_hz", "other_modulus"}


def title(value: Any) -> str:
    return getattr(value, "__name__", str(value))


def bad_values(name: str, valid: Any) -> list[Any]:
    """List values that an argument with such a valid value refuses."""
    if isinstance(valid, np.ndarray):
        meant = name in ANY_SHAPE and len(valid) != 2
        return [bad for bad in BAD_ARRAYS if not (meant and acceptable(bad))]
    if isinstance(valid, tuple):
        return [*BAD_ARRAYS, (2.0, 1.0), (1.0,), (-1.0, 1.0)]
    if isinstance(valid, bool):
        return [None, 0, 1.0, "yes", np.nan, [True], np.array([True, False]), object()]
    if isinstance(valid, float | int):
        meant = {float} if name in ANY_SIGN else {list} if name == "spacing_um" else set()
        return [x for x in BAD_NUMBERS if type(x) not in meant or x != x]
    return ["1", object(), 1.0]


@pytest.mark.parametrize(
    ("call", "name"),
    [(f, x) for f, x in CASES if type(CALLS[f][x]) in (int, float) and x not in MAY_BE_INFINITE],
    ids=title,
)
@pytest.mark.filterwarnings("error")
def test_an_extreme_number_is_refused_by_its_name(call: Callable[..., Any], name: str) -> None:
    """No infinity, no number that double precision cannot hold, no truth value is a number."""
    for extreme in EXTREME:
        if name in ANY_SHAPE and extreme is True:
            continue
        with pytest.raises((ValueError, TypeError), match=rf"^{name}: got .*allowed: "):
            used(call, CALLS[call] | {name: extreme})


@pytest.mark.parametrize(
    ("changes", "allowed"),
    [
        ({"start": 1e12}, "start: got 1e.12, allowed: a number from -4000 to 4000"),
        ({"start": -4001.0}, "start: got -4001, allowed: a number from -4000 to 4000"),
        ({"loads": [0.05]}, "loads: got 1 number, allowed: the loads of two positions or more"),
        ({"single": None}, "single: got None, allowed: True or False"),
        ({"tolerance": 5}, "tolerance: got 5, allowed: a number > 0 and <= 1"),
        ({"subcells": 65}, "subcells: got 65, allowed: a whole number from 1 to 64"),
        ({"radius": np.inf}, "radius: got inf, allowed: a number > 0"),
    ],
)
def test_a_rolling_contact_names_the_range(changes: dict[str, Any], allowed: str) -> None:
    with pytest.raises(ValueError, match=allowed):
        rc.RollingContact(**CONTACT | changes)


@pytest.mark.parametrize("position", [10**12, -(10**12), 10**400])
def test_a_march_refuses_positions_that_double_precision_cannot_tell_apart(position: int) -> None:
    for name in ("first", "last"):
        places = {"first": 0, "last": 0} | {name: position}
        with pytest.raises(ValueError, match=f"{name}: got .*, allowed: -1000000000 to 1000000000"):
            next(rc.march(ROLLING, half_space=rc.HalfSpace(4e-6, 230e9), **places))


@pytest.mark.parametrize(("unit", "size"), [("um", 1e6), ("mm", 1e3), ("nm", 1e9)])
def test_heights_in_another_unit_are_refused_with_the_unit(unit: str, size: float) -> None:
    """A rough surface has slopes near 0.1; in another unit they are impossible in metres."""
    rough = 2e-7 * np.random.default_rng(1).standard_normal((64, 64))  # rms slope 0.14 at 2 um
    x = (np.arange(64) - 32) * 2e-6
    ball = (x[:, None] ** 2 + x**2) / 0.01
    rc.RollingContact(**CONTACT | {"heights": rough, "spacing": 2e-6})
    with pytest.raises(ValueError, match=rf"heights: got an rms slope .*in {unit}"):
        rc.RollingContact(**CONTACT | {"heights": size * rough, "spacing": 2e-6})
    for hardness in (np.inf, 2.1e9):
        assert rc.solve_contact(STEEL, ball - rough, 0.1, hardness=hardness).load > 0
        with pytest.raises(ValueError, match=rf"gap: got an rms slope .*in {unit}"):
            rc.solve_contact(STEEL, ball - size * rough, 20.0, hardness=hardness)


def test_heights_beyond_the_radius_are_refused() -> None:
    """A wave of 3 mm under a sphere of 1 mm is flat between nodes, and still no plate."""
    wave = 3e-3 * np.sin(2 * np.pi * np.arange(4096) / 4096)[:, None] * np.ones(8)
    with pytest.raises(ValueError, match=r"heights: got an rms height .* radius of the sphere"):
        rc.RollingContact(**CONTACT | {"heights": wave})


def test_the_sides_of_a_punch_may_be_high() -> None:
    """Its rms slope is 280, but the sides never touch."""
    gap = np.full((24, 24), 1e-3)
    gap[4:20, 4:20] = 0.0
    assert rc.solve_contact(STEEL, gap, 0.3).contact_area == pytest.approx(256 * 4e-12)


def test_edges_and_names_are_those_of_scenes_and_states() -> None:
    """An area has one name in a contact and in a state."""
    scene = rc.read_scene("quickstart")
    assert ROLLING.blended and scene.numerics.edges == "blended"
    contact = rc.solve_contact(STEEL, GAP, 0.02)
    state = next(rc.march(ROLLING, 0, 0, rc.HalfSpace(4e-6, 230e9)))
    shared = {"pressure", "deflection", "approach", "contact_area", "max_deflection", "residual"}
    assert all(hasattr(solved, name) for solved in (contact, state) for name in shared)


def acceptable(value: Any) -> bool:
    """Tell whether a value is a finite real number, or an array of such numbers."""
    try:
        array = np.asarray(value)
        return array.dtype.kind in "fiu" and bool(np.isfinite(array).all())
    except ValueError:
        return False


def used(call: Callable[..., Any], arguments: dict[str, Any]) -> Any:
    """Call a function; generators are run to their end."""
    outcome = call(**arguments)
    return list(outcome) if inspect.isgenerator(outcome) else outcome


@pytest.mark.parametrize(("call", "name"), CASES, ids=title)
@pytest.mark.filterwarnings("error")
def test_a_bad_argument_is_refused_by_its_name(call: Callable[..., Any], name: str) -> None:
    """ValueError or TypeError with the argument, neither silence nor an error from within."""
    faults = []
    for bad in bad_values(name, CALLS[call][name]):
        try:
            used(call, CALLS[call] | {name: bad})
        except (ValueError, TypeError) as error:
            message = str(error)
            if not (re.match(rf"{name}\b", message) and "got" in message):
                faults.append(f"{bad!r}: {error!r}")
        except Exception as error:
            faults.append(f"{bad!r}: {error!r}")
        else:
            faults.append(f"{bad!r}: taken")
    assert not faults, "\n".join(faults)


MASKABLE = [
    (call, name)
    for call, arguments in CALLS.items()
    for name, valid in arguments.items()
    if isinstance(valid, np.ndarray) and call is not rc.surface_parameters
]


@pytest.mark.parametrize(("call", "name"), MASKABLE, ids=title)
def test_masked_values_are_refused_and_not_read(call: Callable[..., Any], name: str) -> None:
    """The number below a mask means nothing; heights may be filled by a key, and say so."""
    valid = CALLS[call][name]
    masked = np.ma.masked_array(valid, np.zeros(valid.shape, bool))
    used(call, CALLS[call] | {name: masked})  # without a masked value it is an array like any other
    masked[(0,) * valid.ndim] = np.ma.masked
    for values in (masked, list(masked)):
        with pytest.raises(ValueError, match=rf"^{name}: .*(masked values|surface.unmeasured)"):
            used(call, CALLS[call] | {name: values})


def test_masked_heights_are_unmeasured_points() -> None:
    """Parameters, heights for a scene and written files take them as they take NaN."""
    masked = np.ma.masked_greater(GAP, 5e-8)
    gaps = np.ma.filled(masked, np.nan)
    got, want = (rc.surface_parameters(heights, spacing_um=2) for heights in (masked, gaps))
    assert got == pytest.approx(want, nan_ok=True)
    own, same = (
        rc.HeightArray(heights, spacing_um=2, unmeasured="fill") for heights in (masked, gaps)
    )
    assert own == same


def test_the_half_space_of_a_march_has_the_spacing_and_modulus_of_the_contact() -> None:
    for wrong in ((2e-6, 230e9), (4e-6, 200e9)):
        with pytest.raises(ValueError, match=r"half_space: got .*, allowed: that of contact"):
            next(rc.march(ROLLING, 0, 1, rc.HalfSpace(*wrong)))


@pytest.mark.parametrize("name", ["pressure", "deflection"])
def test_a_start_names_its_field(name: str) -> None:
    solved = rc.solve_contact(STEEL, GAP, 0.02)
    fields = {"pressure": solved.pressure, "deflection": solved.deflection}
    for bad in (GAP[:5], GAP * np.nan, "1"):
        with pytest.raises(ValueError, match=rf"start\.{name}: got .*, allowed: "):
            rc.solve_contact(STEEL, GAP, 0.02, rc.WarmStart(**fields | {name: bad}))


def test_an_infinite_load_is_refused() -> None:
    with pytest.raises(ValueError, match="load: got inf, allowed: a number > 0"):
        rc.solve_contact(STEEL, GAP, np.inf)


def test_arrays_of_every_layout_give_the_same_contact() -> None:
    """Lists, reversed and strided views, Fortran order and read-only arrays are taken."""
    wide = np.repeat(np.repeat(GAP, 2, 0), 2, 1)[::2, ::2]
    locked = GAP.copy()
    locked.setflags(write=False)
    expected = rc.solve_contact(STEEL, GAP, 0.02)
    for gap in (GAP.tolist(), wide, GAP[::-1, ::-1][::-1, ::-1], np.asfortranarray(GAP), locked):
        start = rc.WarmStart(np.asfortranarray(expected.pressure))
        for contact in (
            rc.solve_contact(STEEL, gap, 0.02),
            rc.solve_contact(STEEL, gap, 0.02, start),
        ):
            assert contact.contact_area == expected.contact_area
            assert contact.approach == pytest.approx(expected.approach, rel=1e-4)
