"""A run that has a sound: what pictures and report are made of. Depends on sound, summary and store."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rolling.contact.recovery import EventStatistics, event_statistics
from rolling.scene.scene import Scene, track
from rolling.simulation import labels, summary
from rolling.simulation.result import Result
from rolling.sound import ContactSound, contact_sound
from rolling.surface.scene_surface import scene_surface


@dataclass(frozen=True, eq=False)
class Heard:
    """A run with its sound; it equals no other, and things can be kept by it.

    label : what tells it from its neighbours, such as `load 5 N`.
    values : what its sweep gave it, by dotted key.
    numbers : what summary.json says of it.
    """

    label: str
    values: dict[str, float]
    folder: Path
    scene: Scene
    result: Result
    sound: ContactSound
    numbers: dict[str, Any]

    @property
    def home(self) -> Path:
        """The run folder it was made in: that of the sweep, if it is a part of one."""
        return self.folder.parent if self.values else self.folder

    @cached_property  # joined from the pieces of the track
    def events(self) -> dict[str, NDArray[Any]] | None:
        """The table of recovery events, None when none were asked for."""
        return self.result.events()

    @cached_property
    def event_statistics(self) -> EventStatistics | None:
        """Numbers of the recovery events on what is solved, None where there are none."""
        solved = int(np.isfinite(self.result.series["release_energy"]).sum())
        return event_statistics(self.events, solved * self.result.step) if self.events else None

    @property
    def title(self) -> str:
        """The scene and what tells the run from its neighbours."""
        return labels.title(self.scene.name, self.label)


def hear(label: str, values: dict[str, float], folder: Path, scene: Scene, result: Result) -> Heard | None:
    """The sound of what is solved of a run, None when that is less than two steps."""
    steps = result.done_steps
    if steps < 2:
        return None
    began = time.perf_counter()
    closed = result.complete and steps % result.solved_steps == 0 and track(scene).closed
    energy = result.whole("release_energy")[:steps]
    sound = contact_sound(scene, energy, result.step, closed, result.solved_steps, scene_surface(scene).has_seam)
    numbers = summary.summarize(scene, result, sound, time.perf_counter() - began)
    return Heard(label, values, folder, scene, result, sound, numbers)
