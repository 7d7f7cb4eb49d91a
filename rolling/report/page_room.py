"""The room in which the sounds of a page may be heard, for listening only.

The page convolves what it plays with the response of `acoustics.room`, which it holds as a sound.
Levels, records and saved files stay those of the free field.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from acoustics import room, wav
from acoustics.arrays import Array
from rolling.report import page_sounds
from rolling.results.listening import words_of_room
from rolling.results.run_result import Run

REVERBERATION_S = 0.5  # of a furnished living room
_PEAK = 0.9  # of the response on the page, so that its coding does not clip


@dataclass(frozen=True)
class PageRoom:
    """A room for the sounds of a page.

    Attributes
    ----------
    src : str
        The response of the diffuse sound at both ears, a sound in a data URI.
    words : str
        What it is.
    gains : list of dict
        For each run the gains of the direct sound, and of the sound through the response. Together
        they are as loud as the direct sound alone, so that a room clips nothing.
    """

    src: str
    words: str
    gains: list[dict[str, float]]


def page_room(runs: Sequence[Run]) -> PageRoom:
    """Return the room of a page of runs, whose listeners may be at other distances.

    Parameters
    ----------
    runs : sequence of Run, at least one
    """
    first = _response(runs[0].scene.listener_distance_m)
    shown = first * (_PEAK / np.abs(first).max())
    gains = []
    for run in runs:
        energy = _energy(_response(run.scene.listener_distance_m))
        direct = 1.0 / np.sqrt(1.0 + energy)
        diffuse = direct * np.sqrt(energy / _energy(shown))
        gains.append({"direct": round(float(direct), 6), "diffuse": round(float(diffuse), 6)})
    return PageRoom(
        src=page_sounds.compressed(shown, compression=0.0),
        words=words_of_room(REVERBERATION_S),
        gains=gains,
    )


@cache
def _response(distance_m: float) -> Array:
    """Return the response of the room at both ears (n, 2) to a unit of direct sound."""
    return room.diffuse_response(REVERBERATION_S, distance_m, wav.SAMPLE_RATE_HZ, seed=0)


def _energy(response: Array) -> float:
    """Return the energy of a response over that of the direct sound, the mean of both ears."""
    return float(np.mean(np.square(response).sum(axis=0)))
