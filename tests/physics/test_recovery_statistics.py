"""Statistics of recovery events agree with tables made by hand."""

import numpy as np
import pytest

from rolling.contact.recovery import event_statistics


def table(first, last, energy, peak):
    return {
        "node": np.zeros((len(first), 2), np.int32),
        "first": np.array(first),
        "last": np.array(last),
        "energy": np.array(energy, dtype=float),
        "peak": np.array(peak, dtype=float),
    }


def test_eleven_events():
    # 1 to 11 J: median 6, the ninth decile lies on the tenth value; a tenth of eleven, rounded up,
    # is two: 21 of 66 J.
    energy = [3, 1, 2, 11, 10, 9, 4, 5, 6, 7, 8]
    found = event_statistics(table([0] * 11, [2] * 10 + [13], energy, [1] * 10 + [4]), length=0.5)
    assert found is not None
    assert (found.count, found.per_metre, found.peak) == (11, 22.0, 4.0)
    assert (found.energy_mean, found.energy_median, found.energy_p90) == pytest.approx(
        (6.0, 6.0, 10.0)
    )
    assert found.duration_mean == pytest.approx((10 * 2 + 13) / 11)
    assert found.top_tenth_share == pytest.approx(21 / 66)


def test_one_event_releases_all():
    found = event_statistics(table([3], [4], [2.5], [2.5]), length=1e-3)
    assert found is not None
    assert (found.count, found.per_metre, found.duration_mean, found.top_tenth_share) == (
        1,
        1000.0,
        1.0,
        1.0,
    )
    assert found.energy_mean == found.energy_median == found.energy_p90 == found.peak == 2.5


def test_no_events_are_none():
    assert event_statistics(table([], [], [], []), length=1.0) is None


def test_equal_events_share_equally():
    # Of a hundred equal events the top tenth releases a tenth.
    found = event_statistics(table([0] * 100, [1] * 100, [7e-12] * 100, [7e-12] * 100), length=1.0)
    assert found is not None and found.top_tenth_share == pytest.approx(0.1, rel=1e-12)
