"""Sentences on the sound of runs and its reasons, computed from their records."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence

import numpy as np

from acoustics.numbers import rounded
from rolling.figures.vibration import hertz_radius
from rolling.report.assumed import surface_words
from rolling.report.text import asset
from rolling.results.run_result import Run
from rolling.sound.wavelengths import mean_speed, weighted_lines

MOST = 0.8  # share of the A-weighted power that counts as most of it
ALIKE = 0.05  # relative difference of pitch that is not named
MOST_KINDS = 3  # of a part of the situation that are all named
MAINLY = 0.5  # share of the sound that is called most
DIFFERS = 2.0  # standard uncertainties of a difference of levels that is named


def colour(run: Run) -> tuple[float, float, float] | None:
    """Return the mean of the A-weighted log frequency and the ends of its inner 80 % [Hz].

    The result is None for a silent run.
    """
    if run.sound.levels.laeq_db is None:
        return None
    frequency, _, power = weighted_lines(run.sound)
    share = np.cumsum(power) / power.sum()
    outside = (1.0 - MOST) / 2.0
    low, high = (float(frequency[np.searchsorted(share, at)]) for at in (outside, 1.0 - outside))
    return math.exp(float(np.average(np.log(frequency), weights=power))), low, high


# ---- situation


def situation(runs: Sequence[Run]) -> str:
    """Describe bodies, motion and listener; a part that differs between runs has all its kinds."""
    body, diameter, speed, load, thickness, plate, surface, distance = (
        _kinds(list(dict.fromkeys(part))) for part in zip(*map(_parts, runs), strict=True)
    )
    return (
        f"{body[0].upper()}{body[1:]} sphere of {diameter} diameter rolls at {speed} under {load}"
        f" over {thickness} of {plate}: {surface}. It is heard from {distance}."
    )


def _parts(run: Run) -> tuple[str, ...]:
    """Return sphere, diameter, speed, load, thickness, plate, surface and distance in words."""
    scene, plate = run.scene, run.scene.plate
    yields = f" that yields at {plate.cap_gpa:g} GPa" if math.isfinite(plate.cap_gpa) else ""
    speed = "changing speed"
    if run.sound.constant_speed:
        speed = f"{rounded(scene.motion.fastest(run.sound.duration), 3)} m/s"
    return (
        "an elastic" if scene.sphere.youngs_modulus_gpa else "a rigid",
        f"{2 * scene.sphere.radius_mm:g} mm",
        speed,
        f"{rounded(scene.load, 6)} N",
        f"a {plate.thickness_mm:g} mm thick plate" if plate.thickness_mm else "a plate",
        f"{plate.youngs_modulus_gpa:g} GPa{yields}",
        surface_words(scene),
        f"{scene.sound.distance_m:g} m",
    )


def _kinds(words: Sequence[str]) -> str:
    """Join the kinds of a part; of many kinds the first and the last stand for all."""
    if len(words) > MOST_KINDS:
        return f"{words[0]} to {words[-1]} ({len(words)} kinds)"
    head = ", ".join(words[:-1])
    return f"{head} or {words[-1]}" if head else words[-1]


# ---- comparison and reason


def sentences(runs: Sequence[Run]) -> list[str]:
    """Compare the loudest run with the quietest, and explain the frequencies of its sound."""
    sounding = [(run, heard) for run in runs if (heard := colour(run))]
    if not sounding:
        return []
    by_level = sorted(sounding, key=lambda pair: float(pair[0].summary["laeq_db"]))
    (quiet, (dull_hz, _, _)), (loud, (bright_hz, low_hz, high_hz)) = by_level[0], by_level[-1]
    place = (
        f"{loud.label}: {percent(MOST)} of the A-weighted power lies between"
        f" {kilohertz(low_hz)} and {kilohertz(high_hz)}. {_reason(loud)}"
    )
    return [place] if loud is quiet else [_comparison(loud, bright_hz, quiet, dull_hz), place]


def _comparison(loud: Run, bright_hz: float, quiet: Run, dull_hz: float) -> str:
    """Compare two runs in level and in the mean of their A-weighted log frequency [Hz]."""
    by = loud.summary["laeq_db"] - quiet.summary["laeq_db"]
    parts = [run.summary["uncertainty_db"]["laeq"] or 0.0 for run in (loud, quiet)]
    level = f"{by:.{0 if by >= 10 else 1}f} dB louder than {quiet.label}"
    if by < DIFFERS * math.hypot(*parts):
        level = f"as loud as {quiet.label} within the uncertainty"
    pitch = "of the same colour"
    if abs(bright_hz / dull_hz - 1.0) > ALIKE:
        pitch = "brighter" if bright_hz > dull_hz else "darker"
    return (
        f"{loud.label}: {level} and {pitch} (mean of the A-weighted log frequency"
        f" {kilohertz(bright_hz)} against {kilohertz(dull_hz)})."
    )


def _reason(run: Run) -> str:
    """Give the rates at which the sphere passes its own contact width and the asperities."""
    scene = run.scene
    speed = mean_speed(scene, run.sound)
    width = 2 * hertz_radius(run)
    text = f"The sphere rolls over its own contact width, {_rate(width, speed)}"
    if run.sound.source == "vibration":
        return f"{text}. {_shaken(run)}"
    if not scene.laws:
        return f"{text}."
    length = 1e-6 * max(scene.laws, key=lambda law: law.rq_m).lengths_um[0]  # of the rougher
    frequency, _, power = weighted_lines(run.sound)
    within = (frequency >= speed / width) & (frequency <= speed / length)
    share = float(power[within].sum() / power.sum())
    lies = f"{percent(share)} of the A-weighted power lies between the two rates"
    reason = f"Only {lies}, where waves of the surface fit into the contact."
    if share >= MAINLY:
        reason = f"Waves of the surface between these two lengths fit into the contact: {lies}."
    return f"{text}, and over a correlation length of the surface, {_rate(length, speed)}. {reason}"


def _shaken(run: Run) -> str:
    """State the frequency at which the ball rings on its contact, its fall, and its flights."""
    summary = run.summary
    text = (
        f"The ball rings on its contact at {kilohertz(summary['resonance_hz'])}, where waves of the"
        f" surface of {rounded(summary['resonance_wavelength_m'] * 1e6)} µm shake it."
    )
    if "drop_mm" in summary:
        text += f" It falls from {rounded(summary['drop_mm'])} mm above the surface"
        if (left := summary["restitution"]) is not None:
            text += f", and its first impact leaves {percent(left)} of its speed"
        text += "."
    if summary["flight_share"] > 0:
        text += f" It flies for {percent(summary['flight_share'])} of the time, and hits the plate"
        text += f" {summary['impacts']} time{'' if summary['impacts'] == 1 else 's'}."
    return text


def _rate(length: float, speed: float) -> str:
    """Write a length [m] with the time to pass it and the rate."""
    return (
        f"{rounded(length * 1e6, 3)} µm, once in {rounded(length / speed * 1e3)} ms"
        f" ({kilohertz(speed / length)})"
    )


def kilohertz(hertz: float) -> str:
    """Write a frequency with two digits."""
    return f"{rounded(hertz / 1e3)} kHz"


def percent(share: float) -> str:
    """Write a share in percent."""
    return f"{100 * share:.0f} %"


def explanations(runs: Sequence[Run]) -> list[tuple[str, str]]:
    """Explain the words of the table of levels at which a stranger stumbles."""
    levels = [(run.summary["laeq_db"], run.summary["level_db"]) for run in runs]
    raised = any(a is not None and z is not None and a > z for a, z in levels)
    return [
        (words["word"], words["meaning"])
        for key, words in tomllib.loads(asset("words.toml")).items()
        if (raised and key == "a_above_z") or any(run.summary.get(key) is not None for run in runs)
    ]
