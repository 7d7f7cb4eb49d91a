"""Mean of differences over pairs, its error and how sure its sign is, by Student's t.

The scatter of the pairs is taken from the first six of them. It decides how many pairs a wanted ±
needs, and it stays when they are there: a rule that stops when the scatter of all pairs happens to
look small would promise too much (Stein's two-stage procedure).

Pairs that lie on one surface may be correlated. Their scatter is then smaller than that of
independent pairs, and their mean is less certain than their number says. With the correlations R of
n values of variance s^2, and A = I - 1/n (which takes the mean away):

    sum of squares about the mean    s^2 tr(A R)           (s^2 (n - 1) if independent)
    variance of the mean             s^2 / n_e,  n_e = n^2 / (sum of all elements of R)
    degrees of freedom               tr(A R)^2 / tr(A R A R)

References
----------
C. Stein, A two-sample test for a linear hypothesis whose power is independent of the variance,
Annals of Mathematical Statistics 16, 1945, 243-258. B. L. Welch, The generalization of Student's
problem, Biometrika 34, 1947, 28-35, for the degrees of freedom of a sum of parts.
G. V. Bayley and J. M. Hammersley, The "effective" number of independent observations in an
autocorrelated time series, Supplement to the Journal of the Royal Statistical Society 8, 1946,
184-197, for n_e. G. E. P. Box, Some theorems on quadratic forms applied in the study of analysis of
variance problems, Annals of Mathematical Statistics 25, 1954, 290-302, theorem 3.1, for the degrees
of freedom.
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
# Share of the squares of independent pairs that correlated pairs keep about their mean, below which
# they are one pair: their scatter tells nothing.
LEAST_SHARE = 0.02
ROUNDING = 1e-9  # of a number of pairs


class PairedMean(NamedTuple):
    """Mean over pairs, its standard error, and the degrees of freedom of that.

    independent : float. Number of independent pairs that would give as certain a mean.
    """

    mean: float
    error: float
    freedom: float
    independent: float

    @property
    def uncertainty(self) -> float:
        """Standard uncertainty by Student's t; NaN for a single pair."""
        return self.error * student_factor(self.freedom)


def looks(most: int) -> list[int]:
    """Return the numbers of pairs after which a ± is looked at, the last of which is the most."""
    return [*(count for count in LOOKS if count < most), most]


def paired_mean(
    values: Array, correlation: Array | None = None, first_pairs: int = FIRST_PAIRS
) -> PairedMean:
    """Return the mean of values over pairs, with the scatter of the first six.

    The error is NaN for a single pair, and for pairs that are as good as one.

    Parameters
    ----------
    values : (pairs,) array
        A value of each pair.
    correlation : (pairs, pairs) array, optional
        Correlations of the values. Default: they are independent.
    first_pairs : int
        Number of pairs whose scatter is taken. Default: six.
    """
    mean = float(np.mean(values))
    first = values[:first_pairs]
    count = len(first)
    if correlation is None:
        correlation = np.eye(len(values))
    independent = independent_pairs(correlation)
    about_mean = np.eye(count) - 1.0 / count
    kept = about_mean @ correlation[:count, :count]
    squares = float(np.trace(kept))  # of the values about their mean, over their variance
    if count < FEWEST_PAIRS or squares < LEAST_SHARE * (count - 1):
        return PairedMean(mean, error=math.nan, freedom=math.nan, independent=independent)
    variance = float(np.sum(np.square(first - np.mean(first)))) / squares
    return PairedMean(
        mean=mean,
        error=math.sqrt(variance / independent),
        freedom=squares**2 / float(np.trace(kept @ kept)),
        independent=independent,
    )


def independent_pairs(correlation: Array) -> float:
    """Return the number of independent pairs whose mean is as certain as that of correlated ones.

    It is at least one.
    """
    count = len(correlation)
    return max(1.0, count**2 / float(np.sum(correlation)))


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


def pairs_needed(values: Array, wanted: float, correlation: Array | None = None) -> int:
    """Return the pairs after which the ± of a mean is a wanted one, by Student's t.

    Further pairs are taken to be as correlated as those that are there.
    """
    of_pairs = paired_mean(values, correlation)
    if not of_pairs.error > 0:
        return len(values)
    ratio = student_factor(of_pairs.freedom) * of_pairs.error / wanted
    return math.ceil(len(values) * ratio**2 - ROUNDING)
