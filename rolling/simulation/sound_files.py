"""The sound files of a run, each beside a JSON file that explains its numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from acoustics import extension, wav
from rolling._typing import Array
from rolling.folders import files as run_folder
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound

EXTENDED = (
    "stationary Gaussian noise with the band levels of the record; it has none of the record's"
    " single events and never repeats"
)


def write(
    folder: Path,
    scene: Scene,
    label: str,
    sound: ContactSound,
    caveats: Sequence[Mapping[str, str]],
) -> None:
    """Write signal.wav (1.0 = 1 Pa) and listen.wav (for the ear), each with a JSON file.

    Parameters
    ----------
    folder : Path. An existing run folder.
    scene : Scene. The scene of the run.
    label : str. The label that distinguishes the run from the other runs.
    sound : ContactSound. The sound of the run.
    caveats : sequence of mappings. Key and text of each caveat, as in summary.json.

    Raises
    ------
    OSError : a file cannot be written. An earlier file of this name is kept.
    """
    facts, title = _facts(scene, label, sound), f"{scene.name}, {label}"
    gain = wav.listening_gain(sound.pressure)
    rule, consequence = _rule_of_gain(sound, gain)
    files = {
        "signal": _signal(scene, label, sound),
        "listen": wav.listening(
            sound.pressure,
            gain,
            f"{gain:.6g} full scale per Pa, {rule}; {facts}",
            title,
            loops=sound.loops,
        ),
    }
    sidecars = {
        "signal": _sidecar(
            scene,
            label,
            sound,
            1.0,
            "32-bit float",
            "Samples are sound pressure in Pa at the distance given; "
            "players may clip samples beyond 1, listen.wav is for the ear.",
        ),
        "listen": _sidecar(
            scene,
            label,
            sound,
            gain,
            "24-bit PCM",
            "Samples times pascal_per_full_scale are sound pressure in Pa at the distance given; "
            f"{consequence}.",
        ),
    }
    for name, content in files.items():
        run_folder.write_bytes(folder / f"{name}.wav", content)
        run_folder.write_json(folder / f"{name}.json", sidecars[name] | {"caveats": [*caveats]})


def write_signal(folder: Path, scene: Scene, label: str, sound: ContactSound) -> None:
    """Write signal.wav alone, without its JSON file.

    Raises
    ------
    OSError : the file cannot be written; an earlier one is still there.
    """
    run_folder.write_bytes(folder / "signal.wav", _signal(scene, label, sound))


def write_extended(
    folder: Path, scene: Scene, label: str, sound: ContactSound, extended: Array
) -> None:
    """Write extended.wav for the ear, with its JSON file.

    Parameters
    ----------
    folder, scene, label, sound : as in `write`.
    extended : array, Pa. The extended record.

    Raises
    ------
    OSError : a file cannot be written. An earlier file of this name is kept.
    """
    gain = wav.listening_gain(extended)
    rule, consequence = _rule_of_gain(sound, gain)
    comment = f"extended: {EXTENDED}; {gain:.6g} full scale per Pa, {rule}"
    title = f"{scene.name}, {label}, extended"
    facts = {
        "meaning": "Samples times pascal_per_full_scale are sound pressure in Pa at the distance"
        f" given; {consequence}.",
        "extended": EXTENDED,
        "duration_s": len(extended) / sound.sample_rate,
        "loops": True,
        "kurtosis": extension.kurtosis(extended),
        "record_kurtosis": extension.kurtosis(sound.pressure),
        "record_duration_s": sound.duration,
    }
    run_folder.write_bytes(
        folder / "extended.wav", wav.listening(extended, gain, comment, title, loops=True)
    )
    sidecar = _sidecar(scene, label, sound, gain, "24-bit PCM", "")
    del sidecar["lz_peak_db"]  # the record's own
    run_folder.write_json(folder / "extended.json", sidecar | facts)


def _signal(scene: Scene, label: str, sound: ContactSound) -> bytes:
    """Return signal.wav."""
    facts = _facts(scene, label, sound)
    return wav.calibrated(
        sound.pressure, f"1.0 = 1 Pa; {facts}", f"{scene.name}, {label}", sound.loops
    )


def _facts(scene: Scene, label: str, sound: ContactSound) -> str:
    """Write the facts that the comment of a sound file holds."""
    s = scene.sound
    source = f"vibration of {'plate and sphere' if s.ball else 'plate'} on the axis"
    if sound.factor is not None:
        source = f"q {s.q:g}, {sound.factor:.6g} Pa per W/m2 of fluctuation"
    return f"{scene.name}, {label}; distance {s.distance_m:g} m, {source}; {sound.ends}"


def _rule_of_gain(sound: ContactSound, gain: float) -> tuple[str, str]:
    """Name the rule that sets the gain of listen.wav, and its consequence for the ear."""
    if not sound.pressure.any():
        return "silence", "the record is silent, and the gain is 1"
    if gain >= wav.MOST_GAIN:
        return (
            "the largest gain",
            "the gain is the largest there is, that of a record at 0 dB(A): "
            "this one is below and stays quieter than others",
        )
    return (
        "equal loudness",
        "the gain makes runs equally loud, so compare their levels by the numbers, not by ear",
    )


def _sidecar(
    scene: Scene, label: str, sound: ContactSound, gain: float, form: str, meaning: str
) -> dict[str, Any]:
    """Return the JSON content beside a sound file."""
    return {
        "meaning": meaning,
        "scene": scene.name,
        "run": label,
        "sample_rate_hz": sound.sample_rate,
        "format": f"WAV, mono, {form}",
        "pascal_per_full_scale": 1.0 / gain,
        "gain_full_scale_per_pa": gain,
        "gain_db_re_1_per_pa": 20.0 * math.log10(gain),
        **_source(scene, sound),
        "duration_s": len(sound.pressure) / sound.sample_rate,
        "loops": sound.loops,
        "laeq_db": sound.levels.laeq_db,
        "lz_peak_db": sound.levels.lz_peak_db,
    }


def _source(scene: Scene, sound: ContactSound) -> dict[str, Any]:
    """Return the numbers between the source and the sound pressure."""
    s = scene.sound
    if sound.source == "vibration":
        return {"source": "vibration", "ball": s.ball, "distance_m": s.distance_m}
    return {"factor_pa_per_w_m2": sound.factor, "distance_m": s.distance_m, "q": s.q}
