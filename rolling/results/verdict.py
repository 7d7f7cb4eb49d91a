"""Verdict on the level of a run: trust, indicative or do not quote, with the largest reason.

A contribution is a known error or a broken limit. Up to 1 dB it leaves the level trustworthy, above
3 dB the level must not be quoted. A limit without decibels has the word that it allows at best.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.numbers import rounded, si
from rolling.check import error_cost, forecast, resolution
from rolling.check.finding import Finding
from rolling.check.findings import Findings
from rolling.dynamics.comb import COMB_MOST_DB
from rolling.dynamics.of_scene import NEAR_SPEEDS
from rolling.results.sentences import say
from rolling.scene.messages import table
from rolling.scene.scene import Scene

WORDS = TRUST, INDICATIVE, DO_NOT_QUOTE = "trust", "indicative", "do not quote"
LIMITS_DB = 1.0, 3.0  # up to the first a level is trusted, up to the second it is indicative
MAX_OUTSIDE = 0.1  # share of the time with an extrapolated force, from which on no level is quoted
# Level of a half-space's pressure on the axis over the true level [dB] by frequency times distance
# [Hz m]; below, the first error is the least.
_NEAR_HALF_SPACE = (100.0, 13.5), (1e3, 5.2), (5e3, 1.4), (1e4, 0.5)
ROLES: dict[str, list[str]] = table("rolling.results", "roles")  # keys of caveats and findings

_ROUNDING = 1e-6  # share of a variance


class Contribution(NamedTuple):
    """A contribution to the uncertainty of a level: name, word, decibels (None: unknown), text."""

    name: str
    word: str
    decibels: float | None
    text: str

    @property
    def rank(self) -> tuple[int, float]:
        """Order of contributions: the worse word first, then the decibels."""
        return WORDS.index(self.word), self.decibels or 0.0


def verdict(summary: Mapping[str, Any], scene: Scene) -> dict[str, Any] | None:
    """Judge the LAeq of a run by its summary and caveats; None for a silent run.

    The dictionary has `word`, `reason` and `decibels` of the largest contribution, and all
    `contributions`.
    """
    if summary.get("laeq_db") is None:
        return None
    ordered = contributions(summary, scene)
    largest = ordered[0]
    return {
        "word": largest.word,
        "reason": largest.text,
        "decibels": largest.decibels,
        "contributions": [part._asdict() for part in ordered],
    }


def expected(scene: Scene, findings: Sequence[Finding]) -> tuple[str, str]:
    """Return the best word that a run of a scene can expect before it is run, and the reason."""
    warned = [finding for finding in findings if finding.warning]
    caveats = [{"key": x.key, "text": f"{x.quantity}: {x.warning}"} for x in warned]
    summary: dict[str, Any] = {"source": scene.sound.source, "caveats": caveats}
    if scene.numerics.error_estimate and not error_cost.too_short(scene):
        summary |= {"laeq_grid_error_db": 0.0, "laeq_subgrid_error_db": 0.0}
    parts = contributions(summary, scene)
    return (parts[0].word, parts[0].text) if parts else (TRUST, say("verdict.none"))


def refusal(findings: Sequence[Finding]) -> Finding | None:
    """Return the first finding for which a run would be refused or have no solution."""
    refused = (x for x in findings if x.warning and x.key in ROLES["refused"])
    return next(refused, None)


def conclusion(scene: Scene, findings: Findings) -> str:
    """State in one sentence whether a scene runs, how long, and with which verdict at best."""
    if finding := refusal(findings):
        return f"It does not run: {finding.quantity} ({finding.value})."
    if findings.excess:
        return f"It does not run: {findings.excess[0]}."
    scenes = (run.scene for run in scene.runs())
    if all(part.is_smooth and part.rolling.drop_mm is None for part in scenes):
        return f"It runs, in {forecast.takes(findings.seconds)}; a smooth surface is silent."
    runs = zip(scene.runs(), findings.runs.values(), strict=True)
    words = [expected(run.scene, of_run) for run, of_run in runs]
    word, reason = max(words, key=lambda pair: WORDS.index(pair[0]))
    best = "" if word == DO_NOT_QUOTE else "at best "
    place = "" if len(words) == 1 else " of the worst run"
    time = forecast.takes(findings.seconds)
    return f"It runs, in {time}; the expected verdict{place} is {best}{word}: {reason}."


def contributions(summary: Mapping[str, Any], scene: Scene) -> list[Contribution]:
    """List the contributions to the uncertainty of LAeq, the worst first."""
    rules = _source, _record, _motion, _limits, _grid
    parts = (part for rule in rules for part in rule(summary, scene))
    return sorted(parts, key=lambda part: part.rank, reverse=True)


def ranks(summary: Mapping[str, Any]) -> dict[str, tuple[int, float]]:
    """Return the rank of each contribution of a stored verdict by its name."""
    stored = (summary.get("verdict") or {}).get("contributions", [])
    return {part["name"]: Contribution(**part).rank for part in stored}


def _sized(
    name: str, decibels: float, variant: str = "", least: str = TRUST, **numbers: object
) -> Contribution:
    """Return a contribution whose word follows from its decibels, and is no better than `least`."""
    size = abs(decibels)
    word = max(_word(size), least, key=WORDS.index)
    text = say(f"verdict.{name}{variant}", decibels=size, **numbers)
    return Contribution(name, word, size, text)


def _word(decibels: float) -> str:
    """Return the word that an error of a level [dB] allows."""
    return WORDS[sum(abs(decibels) > limit for limit in LIMITS_DB)]


def _unsized(name: str, variant: str = "", word: str = INDICATIVE, **facts: object) -> Contribution:
    """Return a contribution of unknown decibels."""
    return Contribution(name, word, None, say(f"verdict.{name}{variant}", **facts))


# ---- contributions


def _source(summary: Mapping[str, Any], scene: Scene) -> Iterator[Contribution]:
    """Yield the bound that a level of the release is."""
    if summary.get("source") == "vibration":
        return
    if scene.sound.gain_pa_per_w_m2 is not None:
        yield _unsized("fixed_gain")
    elif scene.sound.q != 1:
        yield _unsized("assumed_q", q=scene.sound.q)
    else:
        yield _unsized("upper_bound")._replace(decibels=above_vibration_db(summary))


def above_vibration_db(summary: Mapping[str, Any]) -> float | None:
    """Return the level of a release over that of the vibration, or over its estimate [dB]."""
    if (difference := summary.get("release_over_vibration_db")) is not None:
        return float(difference)
    estimate, laeq = summary.get("vibration_estimate_laeq_db"), summary.get("laeq_db")
    return None if estimate is None or laeq is None else float(laeq - estimate)


def _record(summary: Mapping[str, Any], scene: Scene) -> list[Contribution]:
    """Return the parts of ±: length of the record, its comb of lines, and time steps."""
    keys = ["comb_spread_db", "motion_step_error_db"]
    if summary.get("source") != "vibration":
        keys = []  # the release has no such parts
    parts = [_sized(key, summary[key]) for key in keys if summary.get(key) is not None]
    comb = summary.get("comb_spread_db") if keys else None
    if comb is not None and comb > COMB_MOST_DB:
        parts[0] = parts[0]._replace(text=_comb_text(comb))
    spread = summary.get("uncertainty_db", {}).get("laeq")
    if spread is not None:
        # Length and comb overlap, so the length counts as what it leaves beyond the comb.
        others = sum(part.decibels**2 for part in parts if part.decibels)
        rest = spread**2 - others
        if rest > _ROUNDING * spread**2:
            parts.append(_sized("uncertainty", math.sqrt(rest)))
        together = _sized("laeq_uncertainty", spread)
        if all(together.rank[0] > part.rank[0] for part in parts):
            parts.append(together)
    return parts


def _comb_text(spread: float) -> str:
    """Say that a sharp resonance decides the level of a short track."""
    return (
        "the track is so short that one undamped resonance decides the level: at speeds within "
        f"{100 * NEAR_SPEEDS:g} % LAeq lies {rounded(spread)} dB (rms) from the mean that is stated"
    )


def _grid(summary: Mapping[str, Any], scene: Scene) -> Iterator[Contribution]:
    """Yield the errors of grid, missing detail, solver and force law, known or unknown."""
    keys = ["laeq_solver_error_db"]
    if summary.get("source") == "vibration":
        keys.append("force_law_error_db")
    yield from (_sized(key, summary[key]) for key in keys if summary.get(key) is not None)
    if (grid := _whole_error(summary, "laeq_grid_error")) is None:
        yield _unknown_grid(summary, scene)
        return
    yield _sized(resolution.KEY, grid)
    detail = _whole_error(summary, "laeq_subgrid_error")
    yield _unsized("subgrid", ".unknown") if detail is None else _sized("subgrid", detail)


def band_error_db(summary: Mapping[str, Any]) -> float | None:
    """Return what the steps cut off of LAeq, joined with its uncertainty [dB]; None: unknown."""
    return _whole_error(summary, "laeq_band_error")


def band_text(summary: Mapping[str, Any], highest_hz: float) -> str:
    """State what the end of the simulated band [Hz] does to LAeq."""
    error, spread = summary["laeq_band_error_db"], summary["laeq_band_error_uncertainty_db"]
    size = f"{rounded(abs(error))} ± {rounded(spread)} dB"
    end = si(highest_hz, "Hz")
    if error > 0:
        return f"the steps do not resolve sound above {end}, which makes LAeq about {size} too high"
    return f"the steps cut off sound above {end}, and LAeq is about {size} too low"


def _whole_error(summary: Mapping[str, Any], name: str) -> float | None:
    """Return an error joined with its uncertainty [dB], None where it is unknown."""
    error, spread = summary.get(f"{name}_db"), summary.get(f"{name}_uncertainty_db")
    return None if error is None else math.hypot(error, spread or 0.0)


def _unknown_grid(summary: Mapping[str, Any], scene: Scene) -> Contribution:
    """Return the error of a grid that was not measured, by the rule of the check where it holds."""
    error = None
    if summary.get("source") != "vibration":
        error = resolution.grid_signal_db(scene)
    if error is not None and error > resolution.WANTED_DB:
        decibels = 20 * math.log10(1 + 10 ** (error / 20))
        return _sized(resolution.KEY, decibels, ".rule", INDICATIVE)
    reason = (summary.get("error_estimate") or {}).get("reason")
    why = f"because {reason}" if reason else "without numerics.error_estimate"
    return _unsized(resolution.KEY, ".unknown", why=why)


def _motion(summary: Mapping[str, Any], scene: Scene) -> Iterator[Contribution]:
    """Yield the limits of a motion: extrapolated forces, impacts and flight."""
    if summary.get("impacts_yield"):
        yield _unsized("impacts_yield", word=DO_NOT_QUOTE)
    if (outside := summary.get("force_outside_share") or 0.0) > 0:
        # The share that ends a level counts as the decibels that end it.
        decibels = LIMITS_DB[1] * outside / MAX_OUTSIDE
        yield _sized("force_outside", decibels, percent=100 * outside)
    if (flight := summary.get("flight_share") or 0.0) > 0:
        # A fall is one event, and its parts differ in any case.
        scatter = 0.0 if "drop_mm" in summary else summary.get("record_scatter_db") or 0.0
        yield _sized("impacts", scatter, least=INDICATIVE, percent=100 * flight)


def _limits(summary: Mapping[str, Any], scene: Scene) -> Iterator[Contribution]:
    """Yield the broken limits of theory, sampling and height files, without their advice.

    A rule of thumb for the grid counts only where the error of the grid was not measured.
    """
    is_measured = summary.get("laeq_grid_error_db") is not None
    for caveat in summary.get("caveats", ()):
        if is_measured and caveat["key"] in ROLES["grid_rules"]:
            continue
        key, text = caveat["key"], ": ".join(caveat["text"].split(": ")[:2])
        if key == "step_length":
            error = resolution.LEVEL_ERROR_DB * scene.track.step / resolution.contact_radius(scene)
            yield _sized(key, error, text=text)
        elif key == "nyquist" and (band := band_error_db(summary)) is not None:
            cut = band_text(summary, summary["laeq_band_end_hz"])
            yield Contribution(key, _word(band), band, cut)
        elif key == "half_space_sound" and (bands := summary.get("third_octave_a_db")):
            if summary.get("source") == "vibration":
                yield _sized(key, _half_space_error_db(bands, scene.sound.distance_m))
        elif key in ROLES["broken"] + ROLES["doubtful"]:
            word = DO_NOT_QUOTE if key in ROLES["broken"] else INDICATIVE
            yield Contribution(key, word, None, text)


def _half_space_error_db(bands: Mapping[str, float | None], distance: float) -> float:
    """Return how far the A-weighted bands [dB] of a half-space are too loud at a distance [m]."""
    places, errors = np.array(_NEAR_HALF_SPACE).T
    levels = np.array([-np.inf if bands[name] is None else bands[name] for name in BAND_NAMES])
    power = 10 ** (levels / 10)
    true = power * 10 ** (-np.interp(np.log(MID_HZ * distance), np.log(places), errors) / 10)
    return 10 * math.log10(power.sum() / true.sum()) if true.sum() else 0.0
