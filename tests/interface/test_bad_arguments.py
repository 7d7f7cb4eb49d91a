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
        "shape": GAP, "tolerance": 1e-5,
    },
    rc.RollingContact: CONTACT | {"loads": np.full(5, 0.05), "subcells": 1, "radius_across": 1e-3},
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
    acoustics.sound_levels: RECORD | {"highest_hz": 20e3},
    acoustics.loudest_octave: SIGNAL,
    acoustics.modulated_octave: SIGNAL | {"frequency_hz": 20.0, "gain": np.ones(len(TONE))},
    acoustics.envelope_spectrum: SIGNAL | {
        "band_hz": (500.0, 2000.0), "gain": np.ones(len(TONE))
    },
    acoustics.line_spectrum: SIGNAL,
    acoustics.welch: SIGNAL,
    acoustics.intensity: {"power_w": TONE, "distance_m": 1.0, "q": 1.0},
    acoustics.sound_pressure: {"intensity_fluctuation": TONE, "gain_pa_per_w_m2": 1.0},
    acoustics.level_uncertainty: RECORD | {
        "levels": acoustics.sound_levels(TONE, RATE), "own_factor": True, "laps": 1.0
    },
    acoustics.kurtosis: {"record": TONE},
    acoustics.kurtosis_uncertainty: {"record": TONE},
}  # fmt: skip
BAD_NUMBERS = (np.nan, "1", 1j, [1.0, 2.0], np.ones(3), object(), -1.0)
BAD_ARRAYS = (
    "1", object(), 1.0, [], [[1], [1, 2]], np.zeros((2, 2, 2)), np.full((5, 5), 1j),
    np.full((5, 5), np.nan), np.full(5, np.inf), np.full(5, 1j), np.full(5, np.nan),
)  # fmt: skip
# Values that are bad elsewhere and have a meaning here.
ANY_SIGN = {"start", "first", "last", "mean_square", "q"}
ANY_SHAPE = {"power_w", "frequency_hz"}  # of one function each
CASES = [
    (call, name) for call, arguments in CALLS.items() for name in arguments if name != "own_factor"
]


def title(value: Any) -> str:
    return getattr(value, "__name__", str(value))


def bad_values(name: str, valid: Any) -> list[Any]:
    """List values that an argument with such a valid value refuses."""
    if isinstance(valid, np.ndarray):
        meant = name in ANY_SHAPE and len(valid) != 2
        return [bad for bad in BAD_ARRAYS if not (meant and acceptable(bad))]
    if isinstance(valid, tuple):
        return [*BAD_ARRAYS, (2.0, 1.0), (1.0,), (-1.0, 1.0)]
    if isinstance(valid, float | int):
        meant = {float} if name in ANY_SIGN else {list} if name == "spacing_um" else set()
        return [x for x in BAD_NUMBERS if type(x) not in meant or x != x]
    return ["1", object(), 1.0]


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
    wide, locked = np.repeat(np.repeat(GAP, 2, 0), 2, 1)[::2, ::2], GAP.copy()
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
