"""Finished runs: the results in Python, the input of figures and page, and their files.

A run is written as result.h5, summary.json, signal.wav and listen.wav, and each quantity of its
channels as a WAV.
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
from rolling.in_si.scene_surface import scene_surface
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import LISTEN, RESULT, RunFolder
from rolling.kinds.shown_run import ShownRun
from rolling.marches import effort, marched_law
from rolling.marches.result import Result, released_energy
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.file_facts import FileFacts
from rolling.numbers.run_file import StoredNumbers
from rolling.results import listening, result_arrays, result_file, verdict
from rolling.results.channels import by_quantity, channel_wavs, wav_facts
from rolling.results.former_numbers import former_names
from rolling.results.level_words import level_rows
from rolling.results.provenance import provenance
from rolling.results.run_numbers import record_scatter, run_numbers
from rolling.results.solved_run import NumberedRun, SolvedRun
from rolling.results.stored_numbers import read_stored, write_stored
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound, contact_sound
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

    def write_wav(self, path: Path | str, comment: str = "", title: str = "") -> Path:
        """Write the record of the sound as a 32-bit float WAV in which 1.0 is 1 Pa.

        Parameters
        ----------
        path : Path or str
            File to write; an earlier file is replaced.
        comment, title : str
            Metadata of the file. Default: the meaning of its samples alone.

        Returns
        -------
        path : Path
            The file.

        Raises
        ------
        OSError
            The file cannot be written. An earlier file is kept.
        """
        write_bytes(Path(path), self.sound.wav_bytes(comment, title))
        return Path(path)

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
    energy, is_closed = released_energy(scene, result)
    has_seam = scene_surface(scene).has_seam
    release = contact_sound(
        energy,
        step=result.step,
        motion=scene.motion,
        listener=listener_of(scene),
        tolerance=scene.tolerance,
        closed=is_closed,
        lap_steps=result.solved_steps,
        has_seam=has_seam,
    )
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
    listen = listening.ListenSound(run)
    contents = {LISTEN: listen.wav(), RESULT: result_file.write_result(run)}
    if run.result.passes is not None:
        contents[PASSES], _ = listening.passes_wav(run)
    contents |= channel_wavs(run, listening.wav_title(run, run.label))
    make_below(run.home, run.folder)
    title = f"{listening.wav_title(run, run.label)}, sound pressure in pascals"
    run.write_wav(run.folder / SIGNAL, listening.wav_comment(run), title)
    for name, content in contents.items():
        write_bytes(run.folder / name, content)
    groups = by_quantity(run.channels)
    facts = FileFacts(
        signal=listening.signal_facts(run.sound),
        listen=listen.facts(),
        channel_wavs={name: wav_facts(channels) for name, channels in groups.items()} or None,
    )
    stored = StoredNumbers(
        numbers=_with_sound(run.numbers, began),
        files=facts,
        provenance=provenance(run.scene, run.label),
    )
    write_stored(run.folder, stored)


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
