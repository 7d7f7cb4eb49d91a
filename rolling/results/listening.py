"""Records for the ear: listen.wav, at least five seconds of laps or a long record; long.wav."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from acoustics import wav
from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.results.long_listening import sentence
from rolling.sound.contact_sound import ContactSound
from rolling.sound.long_listening import Listening
from rolling.terminal.files import make_below, write_bytes

if TYPE_CHECKING:
    from rolling.results.run_result import Run

LEAST_S = 5.0  # [s] of listen.wav; a shorter record is a click
CONSEQUENCES = {  # of the rule that sets a gain
    "silence": "the record is silent, and the gain is 1",
    "the largest gain": "the gain is the largest there is, that of a record at 0 dB(A): this"
    " record is below and stays quieter than others",
    "equal loudness": "the gain makes runs equally loud, so compare their levels by the"
    " numbers, not by ear",
}
PLAYERS = ("afplay", "pw-play", "paplay", "aplay", "ffplay -nodisp -autoexit", "xdg-open")


def laps(sound: ContactSound) -> Array:
    """Return the record of all channels [Pa], or as many of its laps as last five seconds."""
    samples, record = round(LEAST_S * sound.sample_rate), sound.channels
    if sound.once or len(record) >= samples:
        return record
    lap = sound.lap.samples(record)
    return np.tile(lap, (math.ceil(samples / len(lap)), *[1] * (lap.ndim - 1)))


def laps_in_words(sound: ContactSound) -> str:
    """Say how listen.wav follows from the record."""
    lap, rate = sound.lap, sound.sample_rate
    if sound.once or len(sound.pressure) >= LEAST_S * rate:
        return f"the record, {sound.ends}"
    count = f"{len(laps(sound)) // len(lap)} laps of the record"
    if sound.loops:
        return f"{count} of {rounded(sound.duration, 3)} s, which closes on itself"
    change = round(20 * math.log10(lap.factor), 1) + 0.0  # without the sign of a zero
    return (
        f"{count}, which does not close: {rounded(len(lap) / rate, 3)} s of its"
        f" {rounded(sound.duration, 3)} s, cross-faded over {rounded(lap.overlap / rate * 1e3)} ms"
        f" at points of equal slope and scaled by {change:+.1f} dB to its LAeq"
    )


def heard(run: Run) -> tuple[Array, str]:
    """Return the record [Pa] for the ear, the long one if the scene asks for it, and say it."""
    if run.long is not None:
        return run.long.channels, sentence(run.long.numbers, run.sound.levels.laeq_db)
    content = laps_in_words(run.sound)
    if run.scene.sound.listen_s is not None:
        content += f"; no long record: {run.no_long}"
    return laps(run.sound), content


def listen_wav(run: Run) -> tuple[bytes, dict[str, Any]]:
    """Write listen.wav of a run; return its bytes, and the content and meaning of its samples."""
    record, content = heard(run)
    gain = wav.listening_gain(record)
    rule = _rule(run, gain)
    comment = f"{gain:.6g} full scale per Pa, {rule}; {content}; {facts(run)}"
    repeats = run.sound.loops or len(record) > len(run.sound.pressure)
    repeats = repeats and run.long is None
    return wav.listening(record, gain, comment, wav_title(run), loops=repeats), {
        "content": content,
        "duration_s": len(record) / run.sound.sample_rate,
        "meaning": "Samples times pascal_per_full_scale are sound pressure in Pa at the listener;"
        f" {CONSEQUENCES[rule]}.",
        "pascal_per_full_scale": 1.0 / gain,
        "gain_full_scale_per_pa": gain,
        "gain_db_re_1_per_pa": 20.0 * math.log10(gain),
        "rule": rule,
    }


def write_long(run: Run, long: Listening) -> Path:
    """Write long.wav, a long record for the ear, and return its path.

    Raises
    ------
    OSError : the file cannot be written. An earlier file is kept.
    """
    gain = wav.listening_gain(long.channels)
    content = sentence(long.numbers, run.sound.levels.laeq_db)
    comment = f"{gain:.6g} full scale per Pa, {_rule(run, gain)}; {content}; {facts(run)}"
    path = run.folder / "long.wav"
    make_below(run.home, run.folder)
    write_bytes(path, wav.listening(long.channels, gain, comment, wav_title(run)))
    return path


def wav_title(run: Run) -> str:
    """Return the title of the sound files of a run."""
    return f"{run.scene.name}, {run.label}"


def facts(run: Run) -> str:
    """Write the facts that the comment of a sound file holds."""
    s, factor = run.scene.sound, run.sound.factor
    source = f"vibration of {'plate and sphere' if s.ball else 'plate'}"
    source += " on the axis" if run.scene.plate.edges_mm is None else " with edges"
    place = f"distance {s.distance_m:g} m"
    if run.sound.source == "vibration" and run.scene.sound.listener_mm is not None:
        count = 1 if run.sound.right is None else 2
        places = (str(list(at)) for at in run.scene.sound.listener_mm[:count])
        place = f"listeners left and right at {' and '.join(places)} mm"
        place = place if count == 2 else f"listener at {run.scene.listener_place}"
    if factor is not None:
        source = f"q {s.q:g}, {factor:.6g} Pa per W/m2 of fluctuation"
    return f"{wav_title(run)}; {place}, {source}; {run.sound.ends}"


def _rule(run: Run, gain: float) -> str:
    """Name the rule that sets the gain [full scale per Pa] of a record for the ear."""
    if not run.sound.pressure.any():
        return "silence"
    return "the largest gain" if gain >= wav.MOST_GAIN else "equal loudness"


def open_player(path: Path) -> None:
    """Play a file by a player of the system, where a person sits at a terminal and one exists."""
    if not sys.stdout.isatty() or "CI" in os.environ:
        return
    has_display = sys.platform == "darwin" or {"DISPLAY", "WAYLAND_DISPLAY"} & {*os.environ}
    for command in PLAYERS if has_display else PLAYERS[:-1]:
        name, *options = command.split()
        if program := shutil.which(name):
            words = [program, *options, str(path)]
            threading.Thread(target=_run_silently, args=(words,), daemon=True).start()
            return


def _run_silently(words: Sequence[str]) -> None:
    """Run a program that neither reads nor writes on the terminal, and survives Ctrl-C there."""
    nowhere = subprocess.DEVNULL
    with suppress(OSError):
        subprocess.run(
            words,
            stdin=nowhere,
            stdout=nowhere,
            stderr=nowhere,
            start_new_session=True,
            check=False,
        )
