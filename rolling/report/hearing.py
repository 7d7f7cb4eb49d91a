"""Sentences on the sound of runs and its reasons, computed from their records."""

import math
import tomllib
from collections.abc import Sequence

import numpy as np

from rolling.dynamics.smooth_contact import semi_axes
from rolling.report.text import asset, sentence
from rolling.results.run_result import Run
from rolling.results.sentences import say
from rolling.sound.wavelengths import mean_speed, weighted_lines

MOST = 0.8  # share of the A-weighted power that counts as most of it
ALIKE = 0.05  # relative difference of pitch that is not named
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


# ---- comparison and reason


def headline(runs: Sequence[Run]) -> str:
    """State in one sentence how the loudest run differs from the quietest, or how one sounds.

    Only runs of one source are compared, because a release is an upper bound.
    """
    sounding = _by_level(runs)
    if not sounding:
        return sentence(runs)
    loud, (bright_hz, low_hz, high_hz) = sounding[-1]
    source = loud.sound.source
    quiet, (dull_hz, _, _) = next(pair for pair in sounding if pair[0].sound.source == source)
    if loud is quiet:
        label = f"{loud.label}: " if len(runs) > 1 else ""
        if source == "vibration":
            return label + _shaken(loud)[:2][-1]  # its fall, or its flights, or its ringing
        return label + say("headline", percent=100 * MOST, low=low_hz / 1e3, high=high_hz / 1e3)
    by = loud.summary["laeq_db"] - quiet.summary["laeq_db"]
    parts = [run.summary["uncertainty_db"]["laeq"] or 0.0 for run in (loud, quiet)]
    level = f"{by:.{0 if by >= 10 else 1}f} dB louder than {quiet.label}"
    if by < DIFFERS * math.hypot(*parts):
        level = f"as loud as {quiet.label} within the uncertainty"
    pitch = "of the same colour"
    if abs(bright_hz / dull_hz - 1.0) > ALIKE:
        pitch = "brighter" if bright_hz > dull_hz else "darker"
    return _capitalized(say("headline.compared", label=loud.label, level=level, pitch=pitch))


def reason(runs: Sequence[Run]) -> str:
    """Explain the frequencies of the loudest run; empty if all are silent."""
    if not (sounding := _by_level(runs)):
        return ""
    run, (_, low_hz, high_hz) = sounding[-1]
    numbers = {"percent": 100 * MOST, "low": low_hz / 1e3, "high": high_hz / 1e3}
    return _capitalized(say("heard", label=run.label, reason=_reason(run), **numbers))


def _by_level(runs: Sequence[Run]) -> list[tuple[Run, tuple[float, float, float]]]:
    """Return the runs that sound with their colours, the quietest first."""
    sounding = [(run, heard) for run in runs if (heard := colour(run))]
    return sorted(sounding, key=lambda pair: float(pair[0].summary["laeq_db"]))


def _capitalized(text: str) -> str:
    return text[0].upper() + text[1:]


def _reason(run: Run) -> str:
    """Give the rates at which the sphere passes its own contact width and the asperities."""
    scene = run.scene
    speed = mean_speed(scene, run.sound)
    width = 2 * semi_axes(scene)[0]
    width_words = say("heard.width", rate=_rate(width, speed))
    if run.sound.source == "vibration":
        return " ".join([f"{width_words}.", *_shaken(run)])
    if not scene.laws:
        return f"{width_words}."
    length = 1e-6 * max(scene.laws, key=lambda law: law.rq_m).lengths_um[0]  # of the rougher
    frequency, _, power = weighted_lines(run.sound)
    within = (frequency >= speed / width) & (frequency <= speed / length)
    share = float(power[within].sum() / power.sum())
    reason = say(f"heard.{'fits' if share >= MAINLY else 'elsewhere'}", percent=100 * share)
    return width_words + say("heard.length", rate=_rate(length, speed), reason=reason)


def _shaken(run: Run) -> list[str]:
    """State the frequency at which the ball rings on its contact, its fall, and its flights."""
    summary = run.summary
    khz, wave_um = summary["resonance_hz"] / 1e3, summary["resonance_wavelength_m"] * 1e6
    sentences = [say("heard.rings", khz=khz, wave_um=wave_um)]
    if "drop_mm" in summary:
        left = summary["restitution"]
        rebound = "" if left is None else say("heard.rebound", percent=100 * left)
        sentences.append(say("heard.falls", drop_mm=summary["drop_mm"], rebound=rebound))
    if (share := summary["flight_share"]) > 0:
        count, s = summary["impacts"], "" if summary["impacts"] == 1 else "s"
        sentences.append(say("heard.flies", percent=100 * share, count=count, s=s))
    return sentences


def _rate(length: float, speed: float) -> str:
    """Write a length [m] with the time to pass it and the rate."""
    ms, khz = length / speed * 1e3, speed / length / 1e3
    return say("heard.rate", length_um=length * 1e6, ms=ms, khz=khz)


def explanations(runs: Sequence[Run]) -> list[tuple[str, str]]:
    """Explain the words of the table of levels at which a stranger stumbles."""
    levels = [(run.summary["laeq_db"], run.summary["level_db"]) for run in runs]
    raised = any(a is not None and z is not None and a > z for a, z in levels)
    return [
        (words["word"], words["meaning"])
        for key, words in tomllib.loads(asset("words.toml")).items()
        if (raised and key == "a_above_z") or any(run.summary.get(key) is not None for run in runs)
    ]
