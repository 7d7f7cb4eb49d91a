"""Linear response of a sound to bands of waves: by how much it falls where a band is lowered."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acoustics.arrays import Array
from acoustics.weighting import a_weighting_db
from rolling.contact.track import Motion
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.dynamics.bodies import Chain
from rolling.sound.radiators import approach_lines, chain_at_lines
from rolling.sound.receivers import Listener


def shares_of_parts(
    bodies: BallOnPlate,
    listener: Listener,
    chain: Chain,
    motion: Motion,
    approach: Array,
    parts: Sequence[Array],
    step: float,
    closed: bool,
) -> Array | None:
    """Return the shares of parts of an approach in the A-weighted mean square pressure.

    The share of a part is the derivative of the level by the level of this part [dB/dB]. A linear
    chain of ball, contact and plate makes the sound. Shares may be negative, because parts
    interfere; those of all parts of an approach add up to 1.

    Parameters
    ----------
    bodies, listener, chain, motion, step, closed
        As of `radiators.chain_at_lines`.
    approach : (positions,) array, m
        Approach under the constant load at the ends of the steps.
    parts : sequence of (positions,) arrays, m
        Parts of it.

    Returns
    -------
    shares : (parts,) array, or None
        None where the approach does not fluctuate within hearing.
    """
    moved = chain_at_lines(bodies, listener, chain, motion, approach, step, closed)
    if moved is None:
        return None
    gain = (moved.gain * 10 ** (a_weighting_db(moved.points) / 10)).mean(axis=1)
    phasor = moved.lines.phasor
    whole = float(np.square(np.abs(phasor)) @ gain)
    shares = np.zeros(len(parts))
    for number, part in enumerate(parts):
        if np.ptp(part) > 0:
            of_part = approach_lines(motion, part, step, closed).phasor
            shares[number] = float(np.real(np.conj(phasor) * of_part) @ gain) / whole
    return shares
