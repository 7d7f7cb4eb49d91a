"""Finished runs: the results in Python, the input of figures and page, and their files.

A run is written as result.h5 and summary.json, as signal.wav and listen.wav of what plays, as
released_signal.wav and released.wav of the release, and each quantity of its channels as a WAV.
"""

from __future__ import annotations

import html
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acoustics.traps import ignoring_underflow
from rolling.contact.processor_time import ProcessorTime
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import LISTEN, RELEASED, RESULT, RunFolder
from rolling.kinds.shown_run import ShownRun
from rolling.marches import effort, marched_law
from rolling.marches.result import Result
from rolling.numbers.ball_numbers import RunNumbers, Source
from rolling.numbers.file_facts import FileFacts
from rolling.numbers.run_file import StoredNumbers
from rolling.results import listening, result_arrays, result_file, stated_sound, verdict
from rolling.results.channels import by_quantity, channel_wavs, wav_facts
from rolling.results.former_numbers import former_names
from rolling.results.level_words import level_rows
from rolling.results.provenance import provenance
from rolling.results.release_sound import sound_of_release
from rolling.results.run_numbers import record_scatter, run_numbers
from rolling.results.solved_run import NumberedRun, SolvedRun
from rolling.results.stated_sound import StatedSound
from rolling.results.stored_numbers import read_stored, write_stored
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound
from rolling.sound.long_listening import Listening
from rolling.sound.vibration_sound import (
    Vibration,
    sound_of_vibration,
    vibrate,
    with_impacts,
)
from rolling.terminal.whole_files import make_below, write_bytes

if TYPE_CHECKING:
    import pandas as pd
    import xarray

SIGNAL = "signal.wav"
RELEASED_SIGNAL = "released_signal.wav"
SIGNALS = {LISTEN: SIGNAL, RELEASED: RELEASED_SIGNAL}  # the same in pascals
PASSES = "passes.wav"  # of a plate that remembers


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False)
class Run(NumberedRun, ShownRun):
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
    numbers : RunNumbers
        All numbers by subject; a run that was opened has the stored ones.
    vibration, released_power : Quantity
        The two numbers of the run.
    vibration_sound : Vibration or None
        Motion and sound of sphere and plate; None unless the scene has dynamics.
    stored : StoredNumbers or None
        What the run folder holds beside the result; None for a run that was not opened.
    channels : tuple of Channel
        Signals of plate, ball and contact that `sound.channels` asks for.

    Examples
    --------
    >>> import rolling
    >>> scene = rolling.read_scene("quickstart", ["rolling.load_n=1", "rolling.duration_s=0.005"])
    >>> run = rolling.simulate(scene, workers=1, progress=False)
    >>> run
    <run quickstart, load 1 N: vibration ..., estimated; released power ..., upper bound; 250 steps>
    >>> frame = run.to_dataframe()
    >>> frame.shape[0], frame.attrs["contact_area"], frame.attrs["release_power"]
    (251, 'm2', 'W')
    >>> run.write_wav("sound.wav").name
    'sound.wav'
    """

    def write_wav(
        self,
        path: Path | str,
        comment: str = "",
        title: str = "",
        source: Source | None = None,
    ) -> Path:
        """Write a sound of the run as a 32-bit float WAV in which 1.0 is 1 Pa.

        Its level is the one that is stated, as far as its ± allows.

        Parameters
        ----------
        path : Path or str
            File to write; an earlier file is replaced.
        comment, title : str
            Metadata of the file. Default: the meaning of its samples alone.
        source : vibration or release
            What the file holds. Default: what plays.

        Returns
        -------
        path : Path
            The file.

        Raises
        ------
        OSError
            The file cannot be written. An earlier file is kept.
        ValueError
            The run has no sound of this source.
        """
        sound = self.stated(source).sound
        write_bytes(Path(path), sound.wav_bytes(comment, title))
        return Path(path)

    def stated(self, source: Source | None = None) -> StatedSound:
        """Return the sound of a source, by default of what plays, at the level that is stated."""
        return stated_sound.stated_sound(
            self, self.numbers, source or stated_sound.playing_source(self, self.numbers)
        )

    def listen(
        self,
        seconds: float = 20.0,
        speed: float | tuple[float, float] | None = None,
        seed: int = 0,
        source: Source | None = None,
    ) -> Listening:
        """Let the ball roll on beyond the solved track, and return the long record.

        The solved track comes first. Its random continuation has the spectra and cross-spectra of
        the force law along the track, of the approach for a vibration that is estimated, or of the
        release. The motion over it is computed, or estimated, as on the track.

        Parameters
        ----------
        seconds : float, s
            Length of the record, up to 120. Default: 20.
        speed : float or pair of float, m/s
            Speed, or speeds at start and end, which change evenly. Default: the scene's, which goes
            on at its last speed.
        seed : int
            Number of the random continuation. Default: 0.
        source : vibration or release
            What is heard. Default: what plays.

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
        >>> f"{long.numbers.seconds:g} s, {long.numbers.solved_share:.1%} of it solved"
        '2 s, 1.0% of it solved'
        """
        return stated_sound.listen(self, self.numbers, seconds, speed, seed, source)

    def to_dataframe(self) -> pd.DataFrame:
        """Tabulate the series along the track, one row per position.

        Energies, powers and speed of a row belong to the step that begins at its position; the
        last position has none.

        Returns
        -------
        table : pandas.DataFrame
            Series by position, m. `attrs` has the unit of each column by its name.
        """
        return result_arrays.series_frame(self)

    def to_xarray(self) -> xarray.DataTree:
        """Return the content of result.h5 as a tree.

        The root holds the series. The groups are snapshot, pressure_maps, events, error_estimate,
        slow_motion, force_law, moving_release, passes, contact_force, channels and sound, as far as
        the run has them.

        Returns
        -------
        tree : xarray.DataTree
            Every variable has `units` and `long_name` in `attrs`. Whole numbers, such as
            iterations, are integers.
        """
        return result_file.result_tree(self)

    @property
    def summary(self) -> Mapping[str, Any]:
        """Numbers by the names of version 0.8; read `numbers` instead."""
        warnings.warn(
            "Run.summary has the names of version 0.8; read the attributes of Run.numbers, such as"
            " run.numbers.contact.max_pressure_pa",
            DeprecationWarning,
            stacklevel=2,
        )
        return former_names(self.numbers)

    def __repr__(self) -> str:
        numbers = f"vibration {self.vibration}; released power {self.released_power}"
        return f"<run {self.title}: {numbers}; {self.result.steps} steps>"

    def _repr_html_(self) -> str:
        """Write what rolls, the two numbers, other levels and doubts for a notebook."""
        table = ""
        for name, text in level_rows(self.numbers).items():
            table += f"<tr><td>{name}</td><td>{html.escape(text)}</td></tr>"
        doubts = ""
        for doubt in verdict.listed(self.numbers):
            doubts += f"<li>{html.escape(doubt.line)}</li>"
        title = html.escape(self.title)
        sentence = html.escape(self.numbers.sentence)
        return f"<h4>{title}</h4><p>{sentence}</p><table>{table}</table><ul>{doubts}</ul>"


def make_run(
    place: RunFolder, label: str, result: Result, stored: StoredNumbers | None = None
) -> Run:
    """Make the sound of a whole result, and its numbers unless they are stored already.

    Raises
    ------
    ContactError : the marches make no force law.
    """
    began = ProcessorTime.now()
    scene = place.scene
    release = sound_of_release(scene, result)
    vibration = _vibration(scene, result, release)
    sound = release
    if vibration is not None and scene.sound.source == "vibration":
        sound = sound_of_vibration(release, vibration)
    solved = SolvedRun(
        values=place.values,
        scene=scene,
        folder=place.folder,
        label=label,
        result=result,
        sound=sound,
        vibration_sound=vibration,
    )
    if stored is not None:
        return _numbered(solved, stored.numbers, stored)
    numbers = run_numbers(solved, release)
    return _numbered(solved, _with_sound(numbers, began))


def _numbered(solved: SolvedRun, numbers: RunNumbers, stored: StoredNumbers | None = None) -> Run:
    """Return a solved run with its numbers; what followed from it already is kept."""
    known = {field.name: getattr(solved, field.name) for field in fields(solved)}
    run = Run(**known, numbers=numbers, stored=stored)
    vars(run).update(vars(solved))
    return run


def _with_sound(numbers: RunNumbers, began: ProcessorTime) -> RunNumbers:
    """Return numbers with the processor time from a moment on added to the sound of the run."""
    spent = ProcessorTime.now().since(began)
    parts = effort.with_work(numbers.effort.parts_cpu_s or {}, effort.SOUND, spent)
    return replace(numbers, effort=replace(numbers.effort, parts_cpu_s=parts))


def _vibration(scene: Scene, result: Result, release: ContactSound) -> Vibration | None:
    """Return the vibration of a run; None without dynamics."""
    if scene.dynamics is None:
        return None
    laps = result.steps / result.solved_steps
    is_whole_laps = scene.track.closed and result.steps % result.solved_steps == 0
    law = marched_law.force_law(scene, result)
    motion = marched_law.law_motion(scene, result)
    repeats = is_whole_laps and release.constant_speed
    vibration = vibrate(
        bodies_of(scene),
        listener_of(scene),
        scene.travel,
        law,
        highest=release.highest,
        whole_laps=repeats,
        laps=laps,
        motion=motion,
    )
    if not vibration.motion.flight_share or vibration.once:
        return vibration
    # A record with impacts is no Gaussian noise.
    scatter = record_scatter(vibration.pressure, laps if vibration.motion.settled else 1.0)
    return with_impacts(vibration, scatter)


# ---- files


def write_run(run: Run) -> None:
    """Write the files of a run into its folder, last summary.json, which tells that all are whole.

    Raises
    ------
    OSError : a file cannot be written. An earlier file of this name is kept.
    """
    began = ProcessorTime.now()
    contents = {RESULT: result_file.write_result(run)}
    for_the_ear = {sound.file: sound for sound in listening.listen_sounds(run)}
    contents |= {name: sound.wav() for name, sound in for_the_ear.items()}
    if run.result.passes is not None:
        contents[PASSES], _ = listening.passes_wav(run)
    contents |= channel_wavs(run, listening.wav_title(run, run.label))
    make_below(run.home, run.folder)
    signals = {
        name: _write_signal(run, name, for_the_ear[file].group)
        for file, name in SIGNALS.items()
        if file in for_the_ear
    }
    for name, content in contents.items():
        write_bytes(run.folder / name, content)
    groups = by_quantity(run.channels)
    released = for_the_ear.get(RELEASED)
    facts = FileFacts(
        signal=listening.signal_facts(signals[SIGNAL], LISTEN),
        listen=for_the_ear[LISTEN].facts(),
        channel_wavs={name: wav_facts(channels) for name, channels in groups.items()} or None,
    )
    if released is not None:
        facts = replace(
            facts,
            released_signal=listening.signal_facts(signals[RELEASED_SIGNAL], RELEASED),
            released=released.facts(),
        )
    stored = StoredNumbers(
        numbers=_with_sound(run.numbers, began),
        files=facts,
        provenance=provenance(run.scene, run.label),
    )
    write_stored(run.folder, stored)


def _write_signal(run: Run, name: str, source: Source) -> ContactSound:
    """Write a sound of a run in pascals, and return it."""
    stated = run.stated(source)
    title = f"{listening.wav_title(run, run.label)}, sound pressure in pascals"
    comment = f"{stated.name}, {stated.level.words}; {listening.wav_comment(run, stated.sound)}"
    write_bytes(run.folder / name, stated.sound.wav_bytes(comment, title))
    return stated.sound


def read_run(run: RunFolder, label: str) -> Run:
    """Read a run from its folder, with its stored numbers, under a label.

    Raises
    ------
    FolderError : a file is missing or damaged, or the result is that of another scene or surface.
    SceneError : the heights of the scene cannot be read.
    """
    stored = read_stored(run.folder, kind_of(run.scene).name)
    result = result_file.read_result(run.folder / RESULT, run.scene)
    return make_run(run, label, result, stored)
