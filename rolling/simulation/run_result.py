"""Finished runs with their sound: the input of figures and report, and the results in Python."""

from __future__ import annotations

import html
import io
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from acoustics import wav
from rolling._typing import Array
from rolling.contact.recovery import EventStatistics, event_statistics
from rolling.folders import files
from rolling.scene import file
from rolling.scene.scene import Scene
from rolling.scene.sweep import Value
from rolling.simulation import _result_layout, labels
from rolling.simulation import summary as numbers_of
from rolling.simulation.moving_release import moving_numbers, moving_release
from rolling.simulation.result import Result
from rolling.simulation.run_errors import RunErrors, run_errors
from rolling.simulation.vibration import numbers as vibration_numbers
from rolling.simulation.vibration import vibration_of
from rolling.simulation.whole_series import WholeSeries, whole_series
from rolling.sound.contact_sound import ContactSound, contact_sound
from rolling.sound.vibration_sound import Vibration, heard
from rolling.surface.scene_surface import scene_surface

if TYPE_CHECKING:
    import xarray

Writer = Callable[["RunResult", Path, bool, bool], Path]  # run, folder, force, report
_LEVELS = (  # name, key of the summary and of its uncertainty, unit
    ("LAeq", "laeq_db", "laeq", "dB(A)"),
    ("LZeq", "level_db", "level", "dB"),
    ("LAFmax", "laf_max_db", "laf_max", "dB(A)"),
    ("steady level", "steady_level_db", "steady", "dB re 1 pW/m²"),
)


@dataclass(frozen=True, eq=False, repr=False)
class RunResult:
    """A run with its sound. It equals no other run, so it can be the key of a dictionary.

    label : str. The label that distinguishes the run from the other runs, such as `load 5 N`.
    values : dict. The swept values of the run, by dotted key.
    folder : Path. The run folder; the working directory for a run that is in memory only.
    scene : Scene. The scene without a sweep.
    result : Result. Series of the solved lap, pressure maps, snapshot and recovery events.
    sound : ContactSound. Sound pressure, levels and their uncertainty.
    summary : dict. The numbers of summary.json.
    errors : RunErrors. Errors from grid and solver; None unless the scene asks for an estimate.
    vibration : Vibration. Vibration of sphere and plate; None unless the scene has dynamics.
    writer : callable. The function behind `save`. It draws figures and writes the page, which stand
        above this module.
    """

    label: str
    values: Mapping[str, Value]
    folder: Path
    scene: Scene
    result: Result
    sound: ContactSound
    summary: dict[str, Any]
    errors: RunErrors | None = None
    vibration: Vibration | None = None
    writer: Writer | None = None

    @property
    def home(self) -> Path:
        """The folder that `rolling run` made: the folder of the sweep for a run of a sweep."""
        return self.folder.parent if self.values else self.folder

    @cached_property  # joining the pieces of the track takes time
    def events(self) -> dict[str, NDArray[Any]] | None:
        """The table of recovery events, or None if none were requested."""
        return self.result.events()

    @cached_property
    def event_statistics(self) -> EventStatistics | None:
        """Statistics of the recovery events on the solved track, or None without events."""
        solved = int(np.isfinite(self.result.series["release_energy"]).sum())
        return event_statistics(self.events, solved * self.result.step) if self.events else None

    @property
    def title(self) -> str:
        """The scene and the label."""
        return labels.title(self.scene.name, self.label)

    @property
    def laps(self) -> float:
        """Number of times that the record holds the solved track, at least 1."""
        return max(1.0, self.result.done_steps / self.result.solved_steps)

    # ---- series of the whole run

    @cached_property
    def _whole(self) -> WholeSeries:
        return whole_series(self.scene, self.result)

    @cached_property
    def series(self) -> Mapping[str, Array]:
        """All series of the whole run by name, in SI units, with NaN where a step is not solved.

        Energies, powers, `speed` and `step_time` have the shape (steps,) and stand at `distance`
        and `time`. States, such as `contact_area`, have the shape (steps + 1,) and stand at
        `position` and `position_time`.
        """
        return MappingProxyType(self._whole.of_steps | self._whole.of_positions)

    @property
    def release_power(self) -> Array:
        """(steps,) W. Elastic energy released per time, at `distance` and `time`."""
        return self._whole.of_steps["release_power"]

    @property
    def distance(self) -> Array:
        """(steps,) m. Distance along the track at the middle of each step."""
        return self._whole.distance

    @property
    def time(self) -> Array:
        """(steps,) s. Time at the middle of each step."""
        return self._whole.time

    @property
    def position(self) -> Array:
        """(steps + 1,) m. Distance along the track at each position; a step joins two positions."""
        return self._whole.position

    @property
    def position_time(self) -> Array:
        """(steps + 1,) s. Time at each position."""
        return self._whole.position_time

    # ---- files and notebooks

    def play(self) -> Any:
        """Return a player for a notebook; without IPython, print the name of the WAV file.

        The gain makes all runs equally loud, so levels are compared by their numbers. A run without
        files writes listen.wav into the working directory.

        Returns
        -------
        player : IPython.display.Audio, or None.
        """
        gain = wav.listening_gain(self.sound.pressure)
        try:
            from IPython.display import Audio  # type: ignore[import-not-found, unused-ignore]
        except ImportError:
            path = self.folder / "listen.wav"
            if not path.is_file():
                files.write_bytes(
                    path, wav.listening(self.sound.pressure, gain, self.title, self.title)
                )
            print(f"listen: {path}")
            return None
        return Audio(self.sound.pressure * gain, rate=self.sound.sample_rate, normalize=False)

    def save(self, folder: Path | str, force: bool = False, report: bool = True) -> Path:
        """Write the run folder that `rolling run` would write.

        Parameters
        ----------
        folder : Path or str. The folder to make.
        force : bool. Replace a run folder of this program. Default: false.
        report : bool. Write the report page as well. Default: true.

        Returns
        -------
        folder : Path. The new folder, for `open_run`.

        Raises
        ------
        FolderError : the folder exists already.
        TypeError : the run does not come from `simulate`, `simulate_sweep` or `open_run`.
        """
        if self.writer is None:
            raise TypeError("only runs of simulate, simulate_sweep and open_run can be saved")
        return self.writer(self, Path(folder), force, report)

    def to_xarray(self) -> xarray.DataTree:
        """Return the content of result.h5 as a tree.

        The root holds the series. The groups are snapshot, pressure_maps, events and sound.

        Returns
        -------
        tree : xarray.DataTree. Every variable has its unit in `attrs`.
        """
        import xarray

        text = file.dump(self.scene)
        content = _result_layout.image(self.result, self.scene, text, self.sound, self.vibration)
        return xarray.open_datatree(io.BytesIO(content), engine="h5netcdf").load()

    def __repr__(self) -> str:
        levels = (
            f"{self._level('laeq_db', 'laeq')} dB(A)"
            if self.summary["laeq_db"] is not None
            else "silent"
        )
        partial = "" if self.result.complete else " (partial)"
        return f"<run {self.title}: LAeq {levels}, {self.summary['steps']} steps{partial}>"

    def _repr_html_(self) -> str:
        """Write levels and caveats for a notebook."""
        rows = "".join(
            f"<tr><td>{name}</td><td>{self._level(key, uncertainty)}</td><td>{unit}</td></tr>"
            for name, key, uncertainty, unit in _LEVELS
        )
        caveats = "".join(
            f"<li>{html.escape(caveat['text'])}</li>" for caveat in self.summary["caveats"]
        )
        return f"<h4>{html.escape(self.title)}</h4><table>{rows}</table><ul>{caveats}</ul>"

    def _level(self, key: str, uncertainty: str) -> str:
        level = self.summary[key]
        if key == "steady_level_db" and self.sound.source == "vibration":
            return "-"
        return (
            "silent"
            if level is None
            else numbers_of.uncertain(level, self.summary["uncertainty_db"][uncertainty])
        )


def hear(
    label: str, values: Mapping[str, Value], folder: Path, scene: Scene, result: Result
) -> RunResult | None:
    """Make the sound of the solved steps of a run.

    Return None below two solved steps, and for a vibration whose force law is not complete.
    """
    steps = result.done_steps
    if steps < 2:
        return None
    began = time.perf_counter()
    closed = result.complete and steps % result.solved_steps == 0 and scene.track.closed
    moving = moving_release(scene, result)
    energy = result.whole("release_energy")[:steps]
    if moving is not None and not moving.fault:
        closed = closed and moving.repeats
        energy = moving.steps["release_energy"][np.arange(steps) % result.solved_steps]
    release = contact_sound(
        scene, energy, result.step, closed, result.solved_steps, scene_surface(scene).has_seam
    )
    vibration = vibration_of(scene, result, release)
    if scene.sound.source == "release":
        sound = release
    elif vibration is not None:
        sound = heard(release, vibration)
    else:
        return None
    errors = run_errors(scene, result, sound, vibration)
    summary = numbers_of.summarize(
        scene, result, sound, time.perf_counter() - began, errors, vibration, moving
    )
    summary |= vibration_numbers(scene, result, release, vibration)
    summary |= moving_numbers(result, moving)
    return RunResult(label, values, folder, scene, result, sound, summary, errors, vibration)
