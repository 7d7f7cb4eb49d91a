"""What a stylus with its filters reads of random heights across their lay."""

import math

ALPHA = math.sqrt(math.log(2) / math.pi)  # 0.4697, of the Gaussian filters of ISO 16610
# Cut-off wavelengths [m] of ISO 4288 for the Ra [m] of random profiles, up to each limit.
_CUT_OFFS = ((2e-8, 0.08e-3), (1e-7, 0.25e-3), (2e-6, 0.8e-3), (1e-5, 2.5e-3))
_LONGEST_CUT_OFF_M = 8e-3
SHORTEST_M = 2.5e-6  # cut-off of short waves that ISO 3274 has beside long ones of up to 0.8 mm


def cut_off(ra_m: float) -> float:
    """Return the cut-off wavelength [m] with which ISO 4288 has an Ra [m] measured."""
    for most, wavelength in _CUT_OFFS:
        if ra_m <= most:
            return wavelength
    return _LONGEST_CUT_OFF_M


def read_share(length_m: float, cut_off_m: float, shortest_m: float = SHORTEST_M) -> float:
    """Return the share of the mean square of heights that a profile keeps after its filters.

    The autocorrelation of the heights is exp(-(r/L)^2), so their spectral density over the wave
    number k falls as exp(-(k L)^2/4). A Gaussian filter of ISO 16610-21 lets waves longer than its
    cut-off w pass with exp(-pi (ALPHA w k/(2 pi))^2). All of it are Gaussian functions, whose
    integrals have a closed form.

    Parameters
    ----------
    length_m : float, m
        Correlation length L along the profile.
    cut_off_m : float, m
        Cut-off wavelength beyond which waves are waviness, and are filtered out.
    shortest_m : float, m
        Cut-off wavelength below which waves are filtered out.
    """

    def passing(*cut_offs_m: float) -> float:
        """Return the share that passes filters which let long waves pass."""
        width = sum((ALPHA * wavelength) ** 2 for wavelength in cut_offs_m) / math.pi
        return 1 / math.sqrt(1 + width / length_m**2)

    short = (shortest_m, shortest_m)
    long_waves = 2 * passing(*short, cut_off_m) - passing(*short, cut_off_m, cut_off_m)
    return passing(*short) - long_waves
