"""The runs of a sweep have different names for any values."""

from __future__ import annotations

import itertools
from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_text import PLAIN

from rolling.scene.file import loads
from rolling.scene.sweep import LONGEST, run_name, run_names


def names_of(*overrides: str) -> list[str]:
    return run_names([values for values, _ in loads(PLAIN, overrides).runs()])


def test_short_and_different_names_stay() -> None:
    assert names_of("sweep.rolling.load_n=[5, 0.5]", "sweep.sphere.radius_mm=[2.0]") == [
        "load_n=5,radius_mm=2",
        "load_n=0.5,radius_mm=2",
    ]
    assert names_of("sweep.surface.seed=[10000000000000000, 1]") == ["seed=1e+16", "seed=1"]
    assert run_names([{}]) == [""]


def test_seeds_that_print_alike_have_folders_of_their_own() -> None:
    names = names_of("sweep.surface.seed=[10000000000000000, 10000000000000001, 5]")
    assert names == ["seed=10000000000000000", "seed=10000000000000001", "seed=5"]


def test_long_names_are_shortened_to_different_ones() -> None:
    keys = [
        "sphere.radius_mm",
        "plate.youngs_modulus_gpa",
        "plate.poissons_ratio",
        "plate.hardness_gpa",
        "surface.roughness_ra_um",
        "surface.correlation_length_um",
        "surface.seed",
        "rolling.load_n",
        "rolling.speed_m_s",
        "rolling.duration_s",
        "sound.distance_m",
        "sound.q",
    ]
    values = [
        dict.fromkeys(keys, 0.123456789) | {"sound.q": q, "rolling.load_n": w}
        for q in (0.1, 0.2)
        for w in (1, 2)
    ]
    names = run_names(values)
    assert len({*names}) == 4 and names == run_names(values)  # the same every time
    assert all(len(name.encode()) == LONGEST for name in names)
    assert all(name.startswith("radius_mm=0.123456789,youngs_modulus_gpa=") for name in names)
    assert len(run_name(values[0])) > 255  # too long for a file system


NUMBERS = st.one_of(
    st.integers(-(10**18), 10**18),
    st.integers(10**15, 10**300),
    st.floats(-1e299, 1e299, allow_nan=False),
    st.sampled_from(
        [2**53, 2**53 + 1, float(2**53), 10**16, 10**16 + 1, 1e16, 0.1, 0.1 + 2**-55, 1e-320]
    ),
)
SWEPT = ["rolling.load_n", "surface.seed", "plate.poissons_ratio", "sphere.poissons_ratio"]
KEYS = st.lists(st.sampled_from(SWEPT), min_size=1, max_size=3, unique=True)


@settings(max_examples=60, deadline=None)
@given(keys=KEYS, data=st.data())
def test_names_differ_whatever_the_values(keys: list[str], data: st.DataObject) -> None:
    lists = [data.draw(st.lists(NUMBERS, min_size=1, max_size=3, unique=True)) for _ in keys]
    runs = [dict(zip(keys, values, strict=True)) for values in itertools.product(*lists)]
    names = run_names(runs)
    assert len({name.casefold() for name in names}) == len(runs)
    printed = Counter(map(run_name, runs))
    for name, values in zip(names, runs, strict=True):
        assert 0 < len(name.encode()) <= LONGEST
        assert not {*name} & {*'/\\:*?"<>|\0'} and name not in (".", "..")
        short = run_name(values)
        if printed[short] == 1 and len(short) <= LONGEST:
            assert name == short


def test_shared_names_are_refused() -> None:
    with pytest.raises(AssertionError, match="share a name"):
        run_names([{"rolling.load_n": 1}, {"rolling.load_n": 1}])
