"""Records for the ear: listen.wav, at least five seconds of laps or a long record; long.wav.

A long record is the solved track, then its random continuation, in motion. passes.wav has the
passes over a plate that remembers.
"""

from __future__ import annotations

import io
import math
import os
import sys
import webbrowser
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import soundfile

from acoustics import resampling, wav
from acoustics.arrays import Array
from acoustics.numbers import decibels_a, rounded
from rolling.marches.result import Result
from rolling.scene.height_files import read_regular
from rolling.scene.scene import Scene
from rolling.sound import long_listening
from rolling.sound.contact_sound import FADE_S, ContactSound, contact_sound
from rolling.sound.long_listening import Listening, with_speed
from rolling.terminal import defaults
from rolling.terminal.files import make_below, write_bytes

if TYPE_CHECKING:
    from rolling.results.run_result import Run

Speed = float | tuple[float, float]  # [m/s], constant or from start to end

PASS_S, PAUSE_S = 1.5, 0.25  # [s] of a pass for the ear, and of the silence after it
MAX_HEARD = 12  # passes in passes.wav; of more, it holds passes in a geometric sequence
MIN_S = 5.0  # [s] of listen.wav; a shorter record is a click
MAX_BYTES = 50_000_000  # of a listen.wav; 120 s of two channels take 35 million
MIN_POSITIONS = 64  # of a solved track; fewer have no spectrum
COARSE_HZ = 10e3  # highest frequency of the steps below which the sound is dull
OFTEN = 0.1  # of a record's duration, in which forces beyond the marched loads are named
LONG_WAVES_HZ = 500.0  # lowest frequency of the solved track above which its long waves are named
# Rules of the gain of listen.wav, and what each means for whoever hears it.
_CONSEQUENCES = {
    "silence": "the record is silent, and the gain is 1",
    "the largest gain": (
        "the gain is the largest there is, that of a record at 0 dB(A): this record is below and"
        " stays quieter than others"
    ),
    "equal loudness": (
        "the gain makes runs equally loud, so compare their levels by the numbers, not by ear"
    ),
}


class ListeningError(ValueError):
    """Reason why a run has no long listening."""


# ---- records in laps, and their files


def laps(sound: ContactSound) -> Array:
    """Return the record of all channels [Pa], or as many of its laps as last five seconds."""
    samples, record = round(MIN_S * sound.sample_rate), sound.channels
    if sound.once or len(record) >= samples:
        return record
    lap = sound.lap.samples(record)
    return np.tile(lap, (math.ceil(samples / len(lap)), *[1] * (lap.ndim - 1)))


def laps_in_words(sound: ContactSound) -> str:
    """Say how listen.wav follows from the record."""
    lap, rate = sound.lap, sound.sample_rate
    if sound.once or len(sound.pressure) >= MIN_S * rate:
        return f"the record, {sound.ends}"
    count = len(laps(sound)) // len(lap)
    duration = rounded(sound.duration, 3)
    if sound.loops:
        return f"{count} laps of the record of {duration} s, which closes on itself"
    change_db = round(20 * math.log10(lap.factor), 1) + 0.0  # without the sign of a zero
    return (
        f"{count} laps of the record, which does not close: {rounded(len(lap) / rate, 3)} s of its "
        f"{duration} s, cross-faded over {rounded(lap.overlap / rate * 1e3)} ms at points of equal "
        f"slope and scaled by {change_db:+.1f} dB to its LAeq"
    )


def heard(run: Run) -> tuple[Array, str]:
    """Return the record [Pa] for the ear, the long one if the scene asks for it, and say it."""
    if long := recorded(run):
        return long.channels, sentence(run, long)
    content = laps_in_words(run.sound)
    if run.scene.sound.listen_s is not None:
        content += f"; no long record: {run.no_long}"
    return laps(run.sound), content


def recorded(run: Run) -> Listening | None:
    """Return the long record of a run, from listen.wav where that holds it; None without one."""
    numbers, path = run.summary.get("listening", {}), run.folder / "listen.wav"
    scale = run.summary.get("listen", {}).get("pascal_per_full_scale")  # of stored runs only
    if scale and numbers.get("seconds"):
        with suppress(OSError, soundfile.LibsndfileError):
            samples, rate = soundfile.read(io.BytesIO(read_regular(path, MAX_BYTES)))
            channels = np.atleast_2d(samples.T) * scale
            whole = abs(channels.shape[1] - numbers["seconds"] * rate) < 1
            if whole and np.isfinite(channels).all():
                return Listening(channels[0], rate, numbers, *channels[1:2])
    return run.long


def listen_wav(run: Run) -> tuple[bytes, dict[str, Any]]:
    """Write listen.wav of a run; return its bytes, and the content and meaning of its samples."""
    record, content = heard(run)
    is_long = run.scene.sound.listen_s is not None and not run.no_long
    repeats = run.sound.loops or len(record) > len(run.sound.pressure)
    written, gain, rule = _written(run, record, content, repeats and not is_long)
    return written, {
        "content": content,
        "duration_s": len(record) / run.sound.sample_rate,
        "meaning": (
            "Samples times pascal_per_full_scale are sound pressure in Pa at the listener; "
            f"{_CONSEQUENCES[rule]}."
        ),
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
    path = run.folder / "long.wav"
    make_below(run.home, run.folder)
    write_bytes(path, _written(run, long.channels, sentence(run, long), False)[0])
    return path


def _written(run: Run, record: Array, content: str, repeats: bool) -> tuple[bytes, float, str]:
    """Return a record [Pa] as a WAV with its gain [full scale per Pa], and the rule of the gain."""
    gain = wav.listening_gain(record)
    rule = "the largest gain" if gain >= wav.MAX_GAIN else "equal loudness"
    if not run.sound.pressure.any():
        rule = "silence"
    comment = f"{gain:.6g} full scale per Pa, {rule}; {content}; {facts(run)}"
    return wav.listening(record, gain, comment, wav_title(run), loops=repeats), gain, rule


def passes_wav(run: Run, bits: Literal[16, 24] = 24) -> tuple[bytes, str]:
    """Return a WAV of the passes of a run in sequence, and a description of its content."""
    count, rate = len(run.pass_sounds), wav.SAMPLE_RATE_HZ
    chosen = np.unique(np.geomspace(1, count, MAX_HEARD).round().astype(int))
    chosen = np.arange(1, count + 1) if count <= MAX_HEARD else chosen
    pause, parts, words = np.zeros(round(PAUSE_S * rate)), list[Array](), list[str]()
    for number in chosen:
        sound = run.pass_sounds[number - 1]
        lap = np.resize(sound.lap.samples(sound.pressure), round(PASS_S * rate))
        parts += [resampling.fade(lap, round(FADE_S * rate)), pause]
        words.append(f"{number} ({decibels_a(sound.levels.laeq_db)})")
    record = np.concatenate(parts)
    gain = wav.listening_gain(record)
    content = f"{PASS_S:g} s of each pass at one gain, with its LAeq: {', '.join(words)}"
    comment = f"{gain:.6g} full scale per Pa; {content}"
    return wav.listening(record, gain, comment, wav_title(run), bits), content


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


def open_player(path: Path) -> None:
    """Play a file by the player of the desktop, where a person sits at a terminal of one."""
    desktop = sys.platform in ("darwin", "win32") or {"DISPLAY", "WAYLAND_DISPLAY"} & {*os.environ}
    if desktop and sys.stdout.isatty() and "CI" not in os.environ:
        webbrowser.open(path.resolve().as_uri())


# ---- long records


def released(scene: Scene, result: Result) -> tuple[Array, bool]:
    """Return the energy [J] released in each step of a run, and whether the steps are closed."""
    closed = result.steps % result.solved_steps == 0 and scene.track.closed
    moving = result.moving if scene.moves_release else None
    energy = result.whole("release_energy")
    if moving is not None and not moving.fault:
        closed = closed and moving.repeats
        energy = moving.steps["release_energy"][np.arange(result.steps) % result.solved_steps]
    return energy, closed


def reason_against(run: Run) -> str:
    """Return the reason why a run has no long record; empty if it has one."""
    steps, sound = run.result.solved_steps, run.sound
    if steps < MIN_POSITIONS:
        return f"its solved track has {steps} steps, and a continuation needs {MIN_POSITIONS}"
    if sound.source == "vibration" or not sound.pressure.any():
        return "" if sound.pressure.any() else "its record is silent"
    if not sound.constant_speed:
        steady = with_speed(run.scene, run.scene.motion.fastest(sound.duration), sound.duration)
        energy, closed = released(run.scene, run.result)
        sound = contact_sound(steady, energy, run.result.step, closed, steps, sound.has_seam)
    reason = sound.unlike_noise
    return reason and f"{reason}: a random continuation would not sound like it"


def listen(run: Run, seconds: float, speed: Speed | None = None, seed: int = 0) -> Listening:
    """Make a long record of a run; raise ListeningError where there is none."""
    if type(seed) is not int or seed < 0:
        raise ListeningError(f"seed: got {seed!r}, allowed: a whole number >= 0")
    _refuse(seconds, speed)
    if run.no_long:
        raise ListeningError(run.no_long)
    scene = run.scene if speed is None else with_speed(run.scene, speed, seconds)
    positions = float(scene.motion.distance(seconds)) / run.result.step
    if positions > (most := defaults.MAX_LISTENED_POSITIONS):
        raise ListeningError(
            f"speed: the sphere passes {positions:.2g} positions, allowed is up to {most:.2g}, "
            "which take ten minutes"
        )
    if run.vibration is not None and run.sound.source == "vibration":
        record = long_listening.listen_to_vibration(scene, run.vibration.law, seconds, seed)
    else:
        lap, step = run.result.solved_steps, run.result.step
        energy = released(run.scene, run.result)[0][:lap]
        closed = run.scene.track.lap_steps <= lap and not run.sound.has_seam
        record = long_listening.listen_to_release(scene, energy, step, closed, seconds, seed)
    record.numbers["seed"] = seed
    record.numbers["limits"] = limits(record.numbers)
    return record


def _refuse(seconds: float, speed: Speed | None) -> None:
    """Refuse a length and a speed that are not possible."""
    least, most = defaults.MIN_LISTENED_SECONDS, defaults.MAX_LISTENED_SECONDS
    if not least <= seconds <= most:
        raise ListeningError(
            f"seconds: got {seconds:g}, allowed is {least:g} to {most:g}, for which memory suffices"
        )
    speeds = np.asarray(1.0 if speed is None else speed, dtype=float)
    most_speed = speeds.max(initial=0.0)
    if speeds.shape not in ((), (2,)) or not (speeds.min(initial=0.0) >= 0 < most_speed < math.inf):
        got = ":".join(f"{value:g}" for value in speeds.ravel())
        raise ListeningError(f"speed: got {got}, allowed: at least 0 m/s, and not only 0")


def sentence(run: Run, long: Listening) -> str:
    """Describe length, level, kurtosis, impacts and the solved share of a long record."""
    numbers, own = long.numbers, decibels_a(run.sound.levels.laeq_db)
    if run.summary.get("single_event"):
        own = f"has LAE {decibels_a(run.summary['lae_db'])} re 1 s"
    kurtosis = "-" if numbers["kurtosis"] is None else f"{numbers['kurtosis']:.2f}"
    track = "all solved"
    if numbers["solved_mm"] < numbers["rolled_mm"]:
        track = (
            f"of which the first {rounded(numbers['solved_mm'], 3)} mm "
            f"({rounded(100 * numbers['solved_share'])} % of the time) are solved and the others "
            f"follow their statistics at random (seed {numbers['seed']})"
        )
    text = (
        f"{rounded(numbers['seconds'], 4)} s over {rounded(numbers['rolled_mm'], 3)} mm, {track}: "
        f"LAeq {decibels_a(numbers['laeq_db'])} (the run {own}), kurtosis {kurtosis}"
    )
    if "impacts" in numbers:
        text += f", {rounded(numbers['impacts'] / numbers['seconds'], 3)} impacts per second"
    if numbers["stretches"]:
        text += f", {numbers['stretches']} rare stretches inserted as solved"
    return text


def limits(numbers: dict[str, Any]) -> list[str]:
    """List the limits of a long record."""
    lowest_hz, highest_hz = numbers["lowest_frequency_hz"], numbers["highest_frequency_hz"]
    turn_mm = numbers["turn_mm"]
    outside = numbers.get("force_outside_share", 0.0)
    found = []
    if highest_hz < COARSE_HZ:
        found.append(
            f"the steps of the track resolve sound up to {rounded(highest_hz)} Hz at this speed; "
            "the rest is missing"
        )
    if turn_mm is not None and numbers["solved_mm"] < turn_mm:
        found.append(
            f"the solved track is shorter than a turn of the ball ({rounded(turn_mm, 3)} mm): it "
            "is put in as solved once per turn, and the rest of the turn is random"
        )
    if outside > OFTEN:
        found.append(
            f"the force lies beyond the marched loads for {100 * outside:.0f} % of the time"
        )
    if lowest_hz > LONG_WAVES_HZ:
        found.append(
            f"waves longer than the solved track sound below {rounded(lowest_hz)} Hz, where the "
            "density is that of the longest solved wave"
        )
    return found
