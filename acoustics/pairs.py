"""Mean of differences over pairs, its error and how sure its sign is, by Student's t.

The scatter of the pairs is taken from the first six of them. It decides how many pairs a wanted ±
needs, and it stays when they are there: a rule that stops when the scatter of all pairs happens to
look small would promise too much (Stein's two-stage procedure).

References
----------
C. Stein, A two-sample test for a linear hypothesis whose power is independent of the variance,
Annals of Mathematical Statistics 16, 1945, 243-258. B. L. Welch, The generalization of Student's
problem, Biometrika 34, 1947, 28-35, for the degrees of freedom of a sum of parts.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import stdtr, stdtrit

from acoustics.arrays import Array

FIRST_PAIRS = 6  # whose scatter is that of all pairs
FEWEST_PAIRS = 2  # that have a scatter
# Numbers of pairs after which a ± is looked at. They are fixed beforehand, so that neither a fast
# machine nor an interruption changes an answer.
LOOKS = (4, 6, 8, 10, 12, 16, 20, 24, 30, 36, 42, 48, 54, 60)
MOST_PAIRS = LOOKS[-1]
SURE = 0.95  # from which on the sign of a difference is sure
ONE_SIGMA = 0.8413447460685429  # share of a normal distribution below one standard deviation
MOST_FREEDOM = 1e6  # from which on Student's distribution is normal


class PairedMean(NamedTuple):
    """Mean over pairs, its standard error, and the degrees of freedom of that."""

    mean: float
    error: float
    freedom: float

    @property
    def uncertainty(self) -> float:
        """Standard uncertainty by Student's t; NaN for a single pair."""
        return self.error * student_factor(self.freedom)


def looks(most: int) -> list[int]:
    """Return the numbers of pairs after which a ± is looked at, the last of which is the most."""
    return [*(count for count in LOOKS if count < most), most]


def paired_mean(values: Array) -> PairedMean:
    """Return the mean of values over pairs, with the scatter of the first six.

    The error is NaN for a single pair.
    """
    mean = float(np.mean(values))
    first = values[:FIRST_PAIRS]
    if len(first) < FEWEST_PAIRS:
        return PairedMean(mean=mean, error=math.nan, freedom=math.nan)
    scatter = float(np.std(first, ddof=1))
    return PairedMean(
        mean=mean,
        error=scatter / math.sqrt(len(values)),
        freedom=float(len(first) - 1),
    )


def joint_freedom(of_pairs: PairedMean, total: float) -> float:
    """Return the degrees of freedom of a total uncertainty, of which the pairs are one part."""
    if not of_pairs.error > 0:
        return MOST_FREEDOM
    return min(MOST_FREEDOM, of_pairs.freedom * (total / of_pairs.error) ** 4)


def student_factor(freedom: float) -> float:
    """Return the factor by which an error holds the mean with the probability of one sigma."""
    return float(stdtrit(freedom, ONE_SIGMA))


def sureness(mean: float, total: float, freedom: float) -> float:
    """Return the probability that the sign of a mean with a total error is right."""
    if total > 0:
        return float(stdtr(freedom, abs(mean) / total))
    return 1.0 if mean else 0.5


def pairs_needed(values: Array, wanted: float) -> int:
    """Return the pairs after which the ± of a mean is a wanted one, by Student's t."""
    of_pairs = paired_mean(values)
    scatter = of_pairs.error * math.sqrt(len(values))
    if not scatter > 0:
        return len(values)
    return math.ceil((student_factor(of_pairs.freedom) * scatter / wanted) ** 2)
