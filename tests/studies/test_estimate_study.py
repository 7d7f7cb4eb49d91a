"""The estimate of errors agrees with a finer grid over the whole track, on a light scene."""

import pytest
from estimate_study import compare, row, scene_of

LIGHT = {"rolling.load_n": 0.1, "surface.width_um": 128, "rolling.duration_s": 0.16}


@pytest.mark.slow
def test_estimates_agree_with_a_finer_grid_on_the_whole_track() -> None:
    table = compare(scene_of("Ra 0.1, 0.3 N", **LIGHT))
    laeq, bands = table.loc["LAeq"], table.drop(index="LAeq")
    assert len(bands) > 10 and bands.right.mean() >= 0.9
    assert laeq.right and laeq.off < 0.3
    # The sign of errors above 1 dB is known, where the uncertainty does not hide it.
    loud = bands[(bands.true.abs() > 1.0) & (bands.true.abs() > 2 * bands.uncertainty)]
    assert (loud.estimated * loud.true > 0).all()
    assert row("light", table)["bands right"] == f"{bands.right.sum()} of {len(bands)}"
