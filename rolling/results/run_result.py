"""Finished runs with their sound: the input of figures and page, and the results in Python.

A run is written as result.h5, summary.json, signal.wav and listen.wav.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from acoustics import wav
from acoustics.arrays import Array
from acoustics.traps import ignoring_underflow
from acoustics.uncertainty import widened
from rolling.contact.recovery import EventStatistics, event_statistics
from rolling.marches import force_law
from rolling.marches.observers import STATE_SERIES, STEP_SERIES
from rolling.marches.result import Result
from rolling.results import labels, listening, result_file, runs_table
from rolling.results.listening import listen, reason_against, released
from rolling.results.result_arrays import DEFINITION
from rolling.results.run_folder import RESULT, SUMMARY, RunFolder, read_summary
from rolling.results.summary import pass_numbers, provenance, record_scatter, summarize
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound, contact_sound, middle_speeds
from rolling.sound.long_listening import Listening
from rolling.sound.vibration_sound import Vibration, heard, vibrate
from rolling.sound.wavelengths import WavelengthOctave, wavelength_octaves
from rolling.surface.scene_surface import scene_surface
from rolling.terminal import progress
from rolling.terminal.files import make_below, write_bytes, write_json, write_temporary

if TYPE_CHECKING:
    import pandas as pd
    import xarray

SIGNAL, LISTEN = "signal.wav", "listen.wav"
PASSES = "passes.wav"  # of a plate that remembers


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False)
class Run(RunFolder):
    """A run with its sound. It equals no other run, so it can be the key of a dictionary.

    Attributes
    ----------
    label : str
        Label that distinguishes the run from the other runs, such as `load 5 N`.
    values : dict
        Swept values of the run, by dotted key.
    folder : Path
        Run folder; the working directory for a run that is in memory only.
    scene : Scene
        Scene without a sweep.
    result : Result
        Series of the solved lap, pressure maps, snapshot and recovery events.
    sound : ContactSound
        Sound pressure, levels and their uncertainty.
    summary : dict
        Numbers of summary.json; a run that was opened has the stored ones.
    vibration : Vibration or None
        Vibration of sphere and plate; None unless the scene has dynamics.

    Examples
    --------
    >>> import rolling
    >>> scene = rolling.read_scene("quickstart", ["rolling.load_n=1", "rolling.duration_s=0.005"])
    >>> run = rolling.simulate(scene, workers=1, progress=False)
    >>> run
    <run quickstart, load 1 N: level of the released power (q = 1) ... dB(A)..., 250 steps>
    >>> frame = run.to_dataframe()
    >>> frame.shape[0], frame.attrs["contact_area"], frame.attrs["release_power"]
    (251, 'm2', 'W')
    """

    label: str
    result: Result
    sound: ContactSound
    summary: dict[str, Any]
    vibration: Vibration | None = None

    # `save` writes a run folder. Its module stands above this one and binds it.
    save: ClassVar[Callable[..., Path]]

    @cached_property  # joining the pieces of the track takes time
    def events(self) -> dict[str, NDArray[Any]] | None:
        """The table of recovery events, or None if none were requested."""
        return self.result.events()

    @cached_property
    def event_statistics(self) -> EventStatistics | None:
        """Statistics of the recovery events on the solved track, or None without events."""
        length = self.result.solved_steps * self.result.step
        return event_statistics(self.events, length) if self.events else None

    @cached_property
    def pass_sounds(self) -> list[ContactSound]:
        """Sound of the release of each pass; empty for a plate without memory."""
        result, scene = self.result, self.scene
        if result.passes is None:
            return []
        closed, has_seam = released(scene, result)[1], scene_surface(scene).has_seam
        steps, lap = np.arange(result.steps) % result.solved_steps, result.solved_steps
        energies = result.passes.series["release_energy"][:, steps]
        return [contact_sound(scene, x, result.step, closed, lap, has_seam) for x in energies]

    @property
    def title(self) -> str:
        """The scene and the label."""
        return labels.title(self.scene.name, self.label)

    @cached_property
    def wavelength_octaves(self) -> list[WavelengthOctave]:
        """Octaves of roughness wavelength with their parts of the sound; none for a silent run."""
        heights = None
        if self.vibration:
            heights = self.result.left_by_passes(scene_surface(self.scene).heights)
        approach = self.result.series["approach"]
        return wavelength_octaves(self.scene, self.sound, heights, approach)

    @property
    def laps(self) -> float:
        """Number of times that the record holds the solved track, at least 1."""
        return max(1.0, self.result.steps / self.result.solved_steps)

    @property
    def record_laeq_db(self) -> float | None:
        """LAeq of the record itself [dB].

        It differs from the LAeq that is stated where this is the mean over a comb.
        """
        if self.vibration is not None and self.sound.source == "vibration":
            return self.vibration.levels.laeq_db
        return self.sound.levels.laeq_db

    @cached_property
    def long(self) -> Listening | None:
        """The record of `sound.listen_s` seconds; None where there is none, or a reason against."""
        seconds = self.scene.sound.listen_s
        return None if seconds is None or self.no_long else listen(self, seconds)

    @cached_property
    def no_long(self) -> str:
        """Reason why a run has no long record; empty if it has one."""
        return reason_against(self)

    def listen(
        self, seconds: float = 20.0, speed: float | tuple[float, float] | None = None, seed: int = 0
    ) -> Listening:
        """Let the ball roll on beyond the solved track, and return the long record.

        The solved track comes first. Its random continuation has the spectra and cross-spectra of
        the force law along the track, or of the release for a run without dynamics, and the motion
        over it is computed as on the track.

        Parameters
        ----------
        seconds : float, s
            Length of the record, up to 120. Default: 20.
        speed : float or pair of float, m/s
            Speed, or speeds at start and end, which change evenly. Default: the scene's, which goes
            on at its last speed.
        seed : int
            Number of the random continuation. Default: 0.

        Returns
        -------
        listening : Listening
            Pressure [Pa] at `sample_rate`, and `numbers`, such as `laeq_db`.

        Raises
        ------
        ListeningError
            A number is not allowed, the run is silent, its solved track too short, or its release
            unlike noise. It is a ValueError.

        Examples
        --------
        >>> import rolling
        >>> words = ["rolling.load_n=1", "rolling.duration_s=0.01"]
        >>> scene = rolling.read_scene("quickstart", words)
        >>> long = rolling.simulate(scene, workers=1, progress=False).listen(2, speed=(0.05, 0.1))
        >>> f"{long.numbers['seconds']:g} s, {long.numbers['solved_share']:.1%} of it solved"
        '2 s, 1.0% of it solved'
        """
        return listen(self, seconds, speed, seed)

    @cached_property
    def series(self) -> Mapping[str, Array]:
        """All series of the whole run by name, in SI units.

        Energies, powers, `speed` and `step_time` have the shape (steps,) and stand at `distance`
        and `time`. States, such as `contact_area`, have the shape (steps + 1,) and stand at
        `position` and `position_time`. `step_time` is NaN in a run that was opened.
        """
        step = self.result.step
        _, speed = middle_speeds(self.scene.motion, self.result.steps, step)
        series = {name: self.result.whole(name) for name in STEP_SERIES} | {"speed": speed}
        for kind in ("release", "loading"):
            series[f"{kind}_per_metre"] = series[f"{kind}_energy"] * (1 / step)
            series[f"{kind}_power"] = series[f"{kind}_energy"] * (speed / step)
        return MappingProxyType(series | {name: self.result.whole(name) for name in STATE_SERIES})

    @property
    def release_power(self) -> Array:
        """(steps,) W. Elastic energy released per time, at `distance` and `time`."""
        return self.series["release_power"]

    @cached_property
    def distance(self) -> Array:
        """(steps,) m. Distance along the track at the middle of each step."""
        middles = (np.arange(self.result.steps) + 0.5) * self.result.step
        return np.asarray(self.result.start + middles, dtype=float)

    @cached_property
    def time(self) -> Array:
        """(steps,) s. Time at the middle of each step."""
        return middle_speeds(self.scene.motion, self.result.steps, self.result.step)[0]

    @cached_property
    def position(self) -> Array:
        """(steps + 1,) m. Distance along the track at each position; a step joins two positions."""
        ends = np.arange(self.result.steps + 1) * self.result.step
        return np.asarray(self.result.start + ends, dtype=float)

    @cached_property
    def position_time(self) -> Array:
        """(steps + 1,) s. Time at each position."""
        ends, motion = np.arange(self.result.steps + 1) * self.result.step, self.scene.motion
        return np.asarray(motion.time(np.minimum(ends, motion.final_distance)), dtype=float)

    def play(self) -> Any:
        """Return a player for a notebook; in a script, name listen.wav and open a player for it.

        The record is heard for at least five seconds, in laps, or as the long record of a scene
        with `sound.listen_s`. The gain makes all runs equally loud, so levels are compared by their
        numbers. A run without files writes a temporary one. The system's player is opened on a
        terminal only, and the script goes on at once.

        Returns
        -------
        player : IPython.display.Audio, or None
        """
        if progress.in_notebook():
            from IPython.display import Audio

            record, _ = listening.heard(self)
            samples = record * wav.listening_gain(record)
            return Audio(samples.T, rate=self.sound.sample_rate, normalize=False)
        path = self.folder / "listen.wav"
        if "provenance" not in self.summary or not path.is_file():  # only in memory
            content, _ = listening.listen_wav(self)
            path = write_temporary(f"{self.scene.name}-listen-", ".wav", content)
        print(f"listen: {path}   {listening.heard(self)[1]}")
        listening.open_player(path)
        return None

    def to_dataframe(self) -> pd.DataFrame:
        """Tabulate the series along the track, one row per position.

        Energies, powers and speed of a row belong to the step that begins at its position; the
        last position has none.

        Returns
        -------
        table : pandas.DataFrame
            Series by position, m. `attrs` has the unit of each column by its name.
        """
        import pandas as pd  # slow to import, for tables only

        definition = DEFINITION[""]
        series = {"position_time": self.position_time, **self.series}
        columns = {name: pd.Series(x) for name, x in series.items() if name in definition}
        table = pd.DataFrame(columns).set_index(pd.Index(self.position, name="position"))
        table.attrs = {name: definition[name].unit for name in ("position", *table)}
        return table

    def to_xarray(self) -> xarray.DataTree:
        """Return the content of result.h5 as a tree.

        The root holds the series. The groups are snapshot, pressure_maps, events, error_estimate,
        slow_motion, force_law, moving_release, passes, contact_force and sound, as far as the run
        has them.

        Returns
        -------
        tree : xarray.DataTree
            Every variable has `units` and `long_name` in `attrs`. Whole numbers, such as
            iterations, are integers.
        """
        return result_file.result_tree(self)

    def __repr__(self) -> str:
        level = runs_table.level_text(self.summary, runs_table.level_key(self.summary))
        judged = self.summary.get("verdict")
        word = f", {judged['word']}" if judged else ""
        name = runs_table.level_name(self.summary)
        return f"<run {self.title}: {name} {level} dB(A){word}, {self.result.steps} steps>"

    def _repr_html_(self) -> str:
        """Write levels and caveats for a notebook."""
        judged = self.summary.get("verdict")
        levels = dict[str, str]()
        for key in runs_table.shown_levels(self.summary):
            name, unit = runs_table.LEVELS[key]
            text = runs_table.level_text(self.summary, key)
            if text != "-":
                levels[name] = f"{text} {unit}"
        first, _ = runs_table.LEVELS[runs_table.level_key(self.summary)]
        rows = {
            runs_table.level_name(self.summary): levels.pop(first),
            "beside it": runs_table.beside_text([self.summary]),
            "verdict": judged and f"{judged['word']}: {judged['reason']}",
            **levels,
        }
        lines = (f"<td>{name}</td><td>{html.escape(x)}</td>" for name, x in rows.items() if x)
        table = "".join(f"<tr>{line}</tr>" for line in lines)
        texts = (html.escape(caveat["text"]) for caveat in self.summary["caveats"])
        caveats = "".join(f"<li>{text}</li>" for text in texts)
        return f"<h4>{html.escape(self.title)}</h4><table>{table}</table><ul>{caveats}</ul>"


def with_sound(
    place: RunFolder, label: str, result: Result, summary: dict[str, Any] | None = None
) -> Run:
    """Make the sound of a whole result, and its numbers unless they are stored already.

    Raises
    ------
    ContactError : the marches make no force law.
    """
    scene, lap = place.scene, result.solved_steps
    (energy, closed), has_seam = released(scene, result), scene_surface(scene).has_seam
    release = contact_sound(scene, energy, result.step, closed, lap, has_seam)
    vibration = _vibration(scene, result, release)
    vibrates = vibration is not None and scene.sound.source == "vibration"
    sound = heard(release, vibration) if vibration and vibrates else release
    run = Run(place.values, scene, place.folder, label, result, sound, summary or {}, vibration)
    if summary is None:
        run.summary.update(summarize(run, release))
        if result.passes is not None:
            run.summary["passes"] = [*pass_numbers(run)]
        if scene.sound.listen_s is not None:
            run.summary["listening"] = run.long.numbers if run.long else {"refused": run.no_long}
    return run


def _vibration(scene: Scene, result: Result, release: ContactSound) -> Vibration | None:
    """Return the vibration of a run; None without dynamics."""
    if scene.dynamics is None:
        return None
    whole_laps = scene.track.closed and result.steps % result.solved_steps == 0
    law = force_law.force_law(scene, result)
    motion, laps = force_law.law_motion(scene, result), result.steps / result.solved_steps
    whole_laps = whole_laps and release.constant_speed
    vibration = vibrate(scene, law, release.highest, whole_laps, laps, motion)
    if not vibration.motion.flight_share or vibration.once:
        return vibration
    # A record with impacts is no Gaussian noise.
    scatter = record_scatter(vibration.pressure, laps if vibration.motion.settled else 1.0)
    return replace(vibration, uncertainty=widened(vibration.uncertainty, scatter))


# ---- files


def write_run(run: Run) -> None:
    """Write the files of a run into its folder, last summary.json, which tells that all are whole.

    Raises
    ------
    OSError : a file cannot be written. An earlier file of this name is kept.
    """
    listen_wav, listen = listening.listen_wav(run)
    contents = {LISTEN: listen_wav, RESULT: result_file.write_result(run)}
    if run.result.passes is not None:
        contents[PASSES], _ = listening.passes_wav(run)
    make_below(run.home, run.folder)
    run.sound.write_wav(run.folder / SIGNAL, listening.facts(run), listening.wav_title(run))
    for name, content in contents.items():
        write_bytes(run.folder / name, content)
    facts = {"listen": listen, "provenance": provenance(run.scene, run.label)}
    write_json(run.folder / SUMMARY, run.summary | facts)


def read_run(run: RunFolder, label: str) -> Run:
    """Read a run from its folder, with its stored numbers, under a label.

    Raises
    ------
    FolderError : a file is missing or damaged, or the result is that of another scene or surface.
    SceneError : the heights of the scene cannot be read.
    """
    summary = read_summary(run.folder / SUMMARY)
    return with_sound(run, label, result_file.read_result(run.folder / RESULT, run.scene), summary)
