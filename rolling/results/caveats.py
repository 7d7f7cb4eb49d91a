"""The caveats of a run's numbers, in the same words on terminal, page and in files."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.bands import OFF_DB
from acoustics.numbers import decibels_a, rounded
from rolling.check import findings, resolution
from rolling.dynamics.of_scene import BENT, NEAR_SPEEDS
from rolling.marches.result import MovingRelease
from rolling.results.run_errors import total_errors_db
from rolling.results.sentences import say
from rolling.results.verdict import ROLES, ranks
from rolling.scene.scene import Scene
from rolling.scene.surfaces import MadeSurface
from rolling.sound.contact_sound import ContactSound, solver_doubt
from rolling.sound.vibration_sound import Vibration

UNVALIDATED = "No level has been validated against a microphone."
SHORT_S = 0.3  # a shorter period of repetition is heard as a tone
HEADLINE, REPEATS = ROLES["headline"], ROLES["repeats"]
TURNS = "turns_unknown"
STANDING = HEADLINE + REPEATS + ROLES["elsewhere"]


@dataclass(frozen=True)
class Caveat:
    """A limit of the numbers of runs.

    key : str. Name for programs, which never changes with the wording.
    text : str. The caveat in plain sentences.
    labels : tuple of str. The runs that it concerns; empty: all runs.
    """

    key: str
    text: str
    labels: tuple[str, ...] = ()

    @property
    def line(self) -> str:
        """The text with the labels of its runs."""
        return self.text + (f" ({'; '.join(self.labels)})" if self.labels else "")


def caveats(
    scene: Scene,
    sound: ContactSound,
    errors: Mapping[str, Any],
    vibration: Vibration | None = None,
    moving: MovingRelease | None = None,
) -> list[dict[str, str]]:
    """List key and text of the caveats of a run, its warnings last.

    scene : Scene. A scene without a sweep.
    sound : ContactSound. The sound of the run.
    errors : mapping. Errors from grid and solver, as summary.json has them; may be empty.
    vibration : Vibration. Vibration of sphere and plate. Default: the run has none.
    moving : MovingRelease. The release under the moving load, or its fault. Default: none.
    """
    # The error of the grid was measured, for a release also that of its signal.
    knows_grid = errors.get("laeq_grid_error_db") is not None
    knows_signal = sound.source == "release" and errors.get("grid_signal_db") is not None
    texts = (
        _of_levels(scene, sound, errors, vibration)
        | _of_record(scene, sound)
        | _of_load(scene, moving)
        | ({"permanent": say("permanent", count=scene.passes)} if scene.is_permanent else {})
        | {
            finding.key: f"{finding.quantity}: {finding.warning}"
            for finding in findings.findings(scene)
            # A measured error of the grid, or a force, stands for its estimate before the run.
            if finding.warning
            and not (knows_grid and finding.key in ROLES["grid_rules"])
            and not (vibration and finding.key in ("force_ratio", "impacts_yield", "comb"))
        }
        | _of_errors(scene, errors, knows_signal)
        | _of_vibration(scene, vibration)
    )
    if vibration is not None and sound.source == "vibration" and vibration.is_mean_of_comb:
        texts["comb_mean"] = _comb_mean(vibration)
    if sound.source == "release":
        hidden = solver_doubt(scene, sound.audible_rms, sound.resolved_rms)
        texts |= {"solver": f"solver: {hidden}"} if hidden else {}
    return [{"key": key, "text": text} for key, text in texts.items()]


def gathered(runs: Sequence[tuple[str, Mapping[str, Any]]]) -> list[Caveat]:
    """Merge the caveats of runs by key, in the words of the first run.

    runs : sequence of pairs. Label and summary of each run.
    """
    by_key: dict[str, dict[str, str]] = {}
    for label, summary in runs:
        for caveat in summary["caveats"]:
            by_key.setdefault(caveat["key"], {})[label] = caveat["text"]
    merged = []
    for key, texts in by_key.items():
        first, text = next(iter(texts.items()))
        labels = () if len(texts) == len(runs) else tuple(texts)
        if len(set(texts.values())) > 1:
            others = f"; likewise {', '.join(labels[1:])}" if labels[1:] else ""
            text, labels = f"{text} (in the numbers of {first}{others})", ()
        merged.append(Caveat(key, text, labels))
    return merged


def warnings(runs: Sequence[tuple[str, Mapping[str, Any]]]) -> list[Caveat]:
    """Merge the warnings of runs, by their share in the verdicts and then by their decibels.

    runs : sequence of pairs. Label and summary of each run.
    """
    largest: dict[str, tuple[int, float]] = {}
    for _, summary in runs:
        for key, rank in ranks(summary).items():
            largest[key] = max(rank, largest.get(key, rank))
    merged = [caveat for caveat in gathered(runs) if caveat.key not in STANDING]
    return sorted(merged, key=lambda caveat: largest.get(caveat.key, (-1, 0.0)), reverse=True)


def _of_levels(
    scene: Scene, sound: ContactSound, errors: Mapping[str, Any], vibration: Vibration | None
) -> dict[str, str]:
    """Return the caveats of the levels; a silent run has none."""
    s, vibrates = scene.sound, sound.source == "vibration"
    if sound.steady_level is None and sound.levels.level_db is None:
        return {}
    gain = s.gain_pa_per_w_m2
    if vibrates:
        texts = _of_radiation(scene)
    elif s.q != 1:
        texts = {"assumed_q": say("assumed_q", q=s.q)}
    else:
        steady = ".steady" if gain is not None or sound.levels.level_db is None else ""
        texts = {"upper_bound": say(f"upper_bound{steady}")}
    if gain is not None and not vibrates:
        texts["fixed_gain"] = say("fixed_gain", gain=gain)
    texts["unvalidated"] = UNVALIDATED
    if sound.uncertainty.level_db is not None or sound.steady_uncertainty is not None:
        flies = vibrates and vibration and vibration.motion.flight_share
        noise = "once" if sound.once else "impacts" if flies else "noise"
        parts = "length, comb and time steps" if vibrates else "the length"
        covered = say(f"uncertainty.{noise}", parts=parts)
        if vibrates and vibration and vibration.is_mean_of_comb:
            near = f"{100 * NEAR_SPEEDS:g} %"
            covered = f"the spread of LAeq over speeds within {near}, and the time steps"
        texts["uncertainty"] = say("uncertainty", covered=covered)
        if errors.get("laeq_uncertainty_db") is not None:
            law = ", solver and force law" if vibrates else " and solver"
            texts["uncertainty"] += say("uncertainty.errors", law=law)
    return texts


def _of_radiation(scene: Scene) -> dict[str, str]:
    """Return the caveats of the pressure of a vibration: listener, baffle, supports."""
    sources = "plate and sphere" if scene.sound.ball else "plate"
    if scene.plate.edges_mm is None:
        body = "an infinite plate without modes, edges or supports"
        body = "a half-space" if scene.plate.thickness_mm is None else body
        on_axis = say("on_axis", sources=sources, distance=scene.sound.distance_m)
        return {"on_axis": on_axis, "infinite_plate": say("infinite_plate", body=body)}
    place = scene.listener_place + " above the contact" * (scene.sound.listener_mm is None)
    moves = len(scene.plate.contact_ends_mm) > 1
    path = "moves to and fro on a straight line" if moves else "stays at its point of the plate"
    at_listener = say("at_listener", sources=sources, place=place)
    return {"at_listener": at_listener, "plate_edges": say("plate_edges", path=path)}


def _of_record(scene: Scene, sound: ContactSound) -> dict[str, str]:
    """Return the caveats of a record that does not loop, or whose repetition is heard."""
    texts = {}
    if not sound.loops:
        variant = "not_loopable.closed" if sound.closed else "not_loopable"
        texts["not_loopable"] = say(variant, ends=sound.ends)
    if sound.levels.level_db is None or sound.once:
        return texts
    lap = scene.track.lap_steps * scene.track.step
    period = sound.duration * min(1.0, lap / float(scene.motion.distance(sound.duration)))
    if sound.duration < SHORT_S:
        period = min(period, len(sound.lap) / sound.sample_rate)
        key, length = "short_loop", sound.duration
    elif period < min(SHORT_S, 0.999 * sound.duration):
        key, length = "short_track", period
    else:
        return texts
    rate = rounded(1 / period) if 1 / period < 10 else f"{1 / period:.0f}"
    return texts | {key: say(key, length=length, rate=rate)}


def _of_load(scene: Scene, moving: MovingRelease | None) -> dict[str, str]:
    """Return the caveat of the load under which the release was computed."""
    if scene.dynamics is None:
        return {"quasi_static": say("quasi_static")}
    if moving is None:
        drop = "" if scene.rolling.drop_mm is None else ".drop"
        return {"constant_load_release": say(f"constant_load_release{drop}")}
    if moving.fault:
        return {"no_moving_release": say("no_moving_release", fault=moving.fault)}
    return {"moving_load_release": say("moving_load_release")}


def _of_errors(scene: Scene, errors: Mapping[str, Any], knows_signal: bool) -> dict[str, str]:
    """Return the warnings of the error estimate: its absence, its reach, and bands that are off."""
    estimate = errors.get("error_estimate")
    if estimate is None:
        return {}
    if "reason" in estimate:
        return {"no_error_estimate": say("no_error_estimate", **estimate)}
    texts = {}
    if knows_signal:
        spread = errors["grid_signal_uncertainty_db"]
        spread = math.nan if spread is None else spread
        source = f"measured within {spread:.0f} dB by the error estimate"
        if coarse := resolution.too_coarse(scene, errors["grid_signal_db"], source):
            texts[resolution.KEY] = f"error of the grid: {coarse}"
    if scene.height_paths:
        texts["unknown_detail"] = say("unknown_detail")
    worst = estimate["worst_uncertainty_db"]
    worst = math.inf if worst is None else worst
    if worst > OFF_DB:
        texts["error_estimate_reach"] = say("error_estimate_reach", worst=worst)
    spreads = errors["grid_error_uncertainty_db"]
    bands = ", ".join(
        f"{name} Hz ({error:+.1f})"
        for name, error in total_errors_db(errors).items()
        if error is not None and abs(error) > OFF_DB + (spreads[name] or 0.0)
    )
    if bands:
        is_made = isinstance(scene.surface, MadeSurface)
        finer = "a smaller surface.spacing_um" if is_made else "a finer measurement"
        texts["band_errors"] = say("band_errors", limit=OFF_DB, bands=bands, finer=finer)
    return texts


def _of_vibration(scene: Scene, vibration: Vibration | None) -> dict[str, str]:
    """Return the warnings of a vibration: extrapolated forces, flight, drift, a plate far bent."""
    texts: dict[str, str] = {}
    if vibration is None:
        return texts
    motion, thickness = vibration.motion, scene.plate.thickness_mm
    if motion.outside_share > 0:
        least, *_, most = vibration.law.load_n
        percent = 100 * motion.outside_share
        texts["force_outside"] = say("force_outside", least=least, most=most, percent=percent)
    if motion.flight_share > 0:
        percent, s = 100 * motion.flight_share, "" if motion.impacts == 1 else "s"
        texts["impacts"] = say("impacts", percent=percent, count=motion.impacts, s=s)
        if motion.flight_share == 1:
            texts["impacts"] += say("impacts.flight")
    repeats = not scene.is_smooth and scene.rolling.drop_mm is None
    if scene.track.closed and not motion.settled and repeats:
        texts["not_settled"] = say("not_settled")
        if motion.flight_share > 0:
            texts["not_settled"] += say("not_settled.impacts")
        elif len(scene.plate.contact_ends_mm) > 1:
            texts["not_settled"] += say("not_settled.path")
        elif scene.motion.is_constant(scene.duration):
            texts["not_settled"] += say("not_settled.constant")
    if thickness is not None and (bent := 1e3 * np.ptp(motion.plate_m) / thickness) > BENT:
        texts["plate_deflection"] = say("plate_deflection", bent=bent, limit=BENT)
    return texts


def _comb_mean(vibration: Vibration) -> str:
    """Explain that LAeq is the mean over the comb, and how loud the record itself is."""
    spread, record = vibration.spreads["comb"], decibels_a(vibration.levels.laeq_db)
    return (
        "comb: one undamped resonance decides the level of so short a track, so the LAeq that is "
        f"stated is the mean over speeds within {100 * NEAR_SPEEDS:g} % and ± is the spread over "
        f"them, {spread:.1f} dB; sound files, third octaves and the other levels belong to the "
        f"one speed of the record, whose LAeq is {record} (record_laeq_db)"
    )
