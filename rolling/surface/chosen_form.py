"""The form that a measurement is described without, decided from its heights."""

from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.surface.parameters import without_plane

LEAST_FORM = 0.05  # of the variance that a plane leaves, from which on second order is form
# Each term of second order explains so many times the variance that a term of higher order does. Of
# random waves both explain as much, and a ratio of this size is rare (F of 3 and 4 degrees of
# freedom, or of 1 and 3 along a profile).
BEYOND_CHANCE = 10.0
_MOST_NODES = 200_000  # of the heights that are looked at


class ChosenForm(NamedTuple):
    """Form to remove, a value of the key `surface.level`, and the reason."""

    level: str
    reason: str


def chosen_form(heights: Array) -> ChosenForm:
    """Choose the F-operator for heights [m] (along, across), NaN where unmeasured.

    It is the least-squares plane, or the surface of second order where that explains much more of
    the variance than random waves would let it.
    """
    rest = without_plane(heights)
    stride = int(np.ceil(np.sqrt(rest.size / _MOST_NODES)))
    sample = rest[:: stride if rest.shape[0] > 1 else 1, :: stride if rest.shape[1] > 1 else 1]
    places = np.nonzero(~np.isnan(sample))
    z = sample[places]
    axes = [
        2 * place / max(size - 1, 1) - 1 for place, size in zip(places, sample.shape, strict=True)
    ]
    is_profile = 1 in sample.shape
    if is_profile:
        axes = [axes[0] if sample.shape[1] == 1 else axes[1]]
    shares = []
    # A profile has one term in each order, so that three higher orders are needed for comparison.
    orders = (1, 2, 5) if is_profile else (1, 2, 3)
    for order in orders:
        terms = np.stack(_terms(axes, order), axis=1)
        factors = np.linalg.lstsq(terms.T @ terms, terms.T @ z)[0]
        left = float(np.mean(np.square(z - terms @ factors)))
        shares.append(1 - left / (float(np.mean(np.square(z))) or 1.0))
    second = max(shares[1] - shares[0], 0.0)
    higher = max(shares[2] - shares[1], 0.0)
    own_terms, higher_terms = (1, 3) if is_profile else (3, 4)
    share = f"second order would take {rounded(100 * second, 2)} % of the variance"
    if second < LEAST_FORM:
        return ChosenForm("plane", f"{share} that a plane leaves")
    if second / own_terms < BEYOND_CHANCE * higher / higher_terms:
        return ChosenForm("plane", f"{share}, and so do random waves, as higher orders show")
    return ChosenForm("quadratic", share.replace("would take", "takes"))


def _terms(axes: list[Array], order: int) -> list[Array]:
    """Return the powers of the places up to an order."""
    if len(axes) == 1:
        return [axes[0] ** i for i in range(order + 1)]
    x, y = axes
    return [x**i * y**j for i in range(order + 1) for j in range(order + 1 - i)]
