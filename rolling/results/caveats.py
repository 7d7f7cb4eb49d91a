"""The caveats of a run's numbers, in the same words on terminal, page and in files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.bands import OFF_DB
from acoustics.numbers import rounded
from rolling.check import findings, resolution
from rolling.dynamics.of_scene import BENT
from rolling.marches.result import MovingRelease
from rolling.results.run_errors import total_errors_db
from rolling.results.verdict import ranks
from rolling.scene.scene import Scene
from rolling.sound import solver_error
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration

MEASURED_DB = 26, 70  # release with q = 1 over the vibration, on 71 runs of docs/dynamics.md
SHORT_S = 0.3  # a shorter period of repetition is heard as a tone
# Caveats that stand beside every level, beside every player, and elsewhere; others are warnings.
_VIBRATIONS = ("on_axis", "infinite_plate", "at_listener", "plate_edges")
_BOUNDS = ("upper_bound", "assumed_q", "fixed_gain", *_VIBRATIONS)
HEADLINE = (*_BOUNDS, "unvalidated", "uncertainty")
REPEATS = ("short_loop", "short_track")
_LOADS = ("quasi_static", "constant_load_release", "moving_load_release")
STANDING = (*HEADLINE, *REPEATS, *_LOADS, "not_loopable", "error_estimate_reach")


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
    # The error of the grid in the release was measured.
    knows_grid = sound.source == "release" and errors.get("grid_signal_db") is not None
    texts = (
        _of_levels(scene, sound, errors, vibration)
        | _of_record(scene, sound)
        | _of_load(scene, moving)
        | {
            finding.key: f"{finding.quantity}: {finding.warning}"
            for finding in findings.findings(scene)
            # A measured error of the grid, or a force, stands for its estimate before the run.
            if finding.warning
            and not (knows_grid and finding.key == resolution.KEY)
            and not (vibration and finding.key in ("force_ratio", "impacts_yield"))
        }
        | _of_errors(scene, errors, knows_grid)
        | _of_vibration(scene, vibration)
    )
    if sound.source == "release":
        hidden = solver_error.doubt(scene, sound.audible_rms, sound.resolved_rms)
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
    s, texts = scene.sound, dict[str, str]()
    if sound.steady_level is None and sound.levels.level_db is None:
        return texts
    fixed = s.gain_pa_per_w_m2 is not None
    if sound.source == "vibration" and scene.plate.edges_mm is not None:
        texts |= _of_edges(scene)
    elif sound.source == "vibration":
        sources = "plate and sphere" if s.ball else "plate"
        texts["on_axis"] = (
            f"Levels are the pressure of {sources} on the axis through the contact, at one listener"
            f" at {s.distance_m:g} m without a room."
        )
        body = "an infinite plate without modes, edges or supports"
        texts["infinite_plate"] = (
            f"The sphere rolls on {'a half-space' if scene.plate.thickness_mm is None else body},"
            " pressed by a constant force without mass; friction, rocking and rotation are left"
            " out."
        )
    elif s.q == 1:
        bound = "an upper bound: all released energy counts as radiated"
        above = f"{' to '.join(map(str, MEASURED_DB))} dB above the vibration (71 runs)"
        texts["upper_bound"] = (
            f"Levels are levels of the released power (q = 1), {bound}, {above}, and more at low"
            " speed."
        )
        if fixed or sound.levels.level_db is None:
            texts["upper_bound"] = f"The steady level is {bound} (q = 1)."
    else:
        texts["assumed_q"] = (
            f"Levels are levels of the released power, {s.q:g} of which is assumed to be radiated"
            f" (q = {s.q:g})."
        )
    if fixed and sound.source == "release":
        texts["fixed_gain"] = (
            f"The scene's gain of {s.gain_pa_per_w_m2:g} Pa per W/m² decides every level but the"
            " steady one."
        )
    texts["unvalidated"] = "No level has been validated against a microphone."
    if sound.uncertainty.level_db is not None or sound.steady_uncertainty is not None:
        noise, vibrates = "taken as stationary Gaussian noise", sound.source == "vibration"
        if vibrates and vibration and vibration.motion.flight_share:
            noise = "from its scatter between thirds, because impacts are not Gaussian noise"
        parts = "length, comb and time steps" if vibrates else "the length"
        covered = f"{parts} of the record, {noise}"
        if sound.once:
            covered = "the time steps; the record is one fall, and its level that of its length"
        texts["uncertainty"] = f"± covers {covered}; it holds no error of model, grid or solver."
        if errors.get("laeq_uncertainty_db") is not None:
            law = ", solver and force law" if sound.source == "vibration" else " and solver"
            texts["uncertainty"] += (
                f" Errors of grid{law} are estimated beside the levels, which are not corrected for"
                " them."
            )
    return texts


def _of_edges(scene: Scene) -> dict[str, str]:
    """Return the caveats of the levels of a plate with edges: listener, baffle, supports."""
    sources = "plate and sphere" if scene.sound.ball else "plate"
    path = "stays at its point of the plate"
    if len(scene.plate.contact_ends_mm) > 1:
        path = "moves to and fro on a straight line"
    return {
        "at_listener": f"Levels are the pressure of {sources} at {scene.listener_place}"
        f"{' above the contact' if scene.sound.listener_mm is None else ''}, without a room.",
        "plate_edges": "The plate is simply supported at its edges in an infinite rigid baffle,"
        " which makes a plate smaller than the wavelength too loud; the contact"
        f" {path}. A constant force without mass presses the sphere; friction, rocking and rotation"
        " are left out.",
    }


def _of_record(scene: Scene, sound: ContactSound) -> dict[str, str]:
    """Return the caveats of a record that does not loop, or whose repetition is heard."""
    texts = {}
    if not sound.loops:
        texts["not_loopable"] = (
            "The ends of the record do not fit together: a loop of it is cross-faded."
            if sound.closed
            else f"The record does not close on itself: it is {sound.ends}, and a loop of it"
            " is cross-faded."
        )
    if sound.levels.level_db is None or sound.once:
        return texts
    lap = scene.track.lap_steps * scene.track.step
    period = sound.duration * min(1.0, lap / float(scene.motion.distance(sound.duration)))
    if sound.duration < SHORT_S:
        period = min(period, len(sound.lap) / sound.sample_rate)
    rate = rounded(1 / period) if 1 / period < 10 else f"{1 / period:.0f}"
    heard = f"{rate} times a second: the pitch that is heard is the repetition, not the contact."
    if sound.duration < SHORT_S:
        texts["short_loop"] = (
            f"When it loops, the record of {rounded(sound.duration, 3)} s repeats {heard}"
        )
    elif period < min(SHORT_S, 0.999 * sound.duration):
        texts["short_track"] = (
            f"The track repeats in the record every {rounded(period, 3)} s, {heard}"
        )
    return texts


def _of_load(scene: Scene, moving: MovingRelease | None) -> dict[str, str]:
    """Return the caveat of the load under which the release was computed."""
    if scene.dynamics is None:
        return {
            "quasi_static": "The load is held constant: the sphere neither bounces nor rings on its"
            " contact."
        }
    if moving is None:
        under = "; dynamics.release: true computes it under the moving load."
        if scene.rolling.drop_mm is not None:
            under = ", as if the sphere rolled from the start."
        return {"constant_load_release": f"The release is computed under the constant load{under}"}
    if moving.fault:
        return {
            "no_moving_release": "release: of the constant load, because there is none under the"
            f" moving load: {moving.fault}"
        }
    return {
        "moving_load_release": "The release is computed under the moving load; the series along the"
        " track are of the constant load."
    }


def _of_errors(scene: Scene, errors: Mapping[str, Any], knows_grid: bool) -> dict[str, str]:
    """Return the warnings of the error estimate: its absence, its reach, and bands that are off."""
    estimate = errors.get("error_estimate")
    if estimate is None:
        return {}
    if "reason" in estimate:
        return {"no_error_estimate": f"error estimate: none, because {estimate['reason']}"}
    texts = {}
    if knows_grid:
        spread = errors["grid_signal_uncertainty_db"]
        spread = math.nan if spread is None else spread
        source = f"measured within {spread:.0f} dB by the error estimate"
        if coarse := resolution.too_coarse(scene, errors["grid_signal_db"], source):
            texts[resolution.KEY] = f"error of the grid: {coarse}"
    if scene.height_paths:
        texts["unknown_detail"] = (
            "error estimate: nothing is known of heights below the spacing of the file, so the"
            " error of their absence is in no number"
        )
    worst = estimate["worst_uncertainty_db"]
    if worst is None or worst > OFF_DB:
        texts["error_estimate_reach"] = (
            "error estimate: its standard errors for third octaves reach"
            f" {math.inf if worst is None else worst:.1f} dB between 1 and 16 kHz"
        )
    spreads = errors["grid_error_uncertainty_db"]
    bands = ", ".join(
        f"{name} Hz ({error:+.1f})"
        for name, error in total_errors_db(errors).items()
        if error is not None and abs(error) > OFF_DB + (spreads[name] or 0.0)
    )
    if bands:
        texts["band_errors"] = (
            f"grid and solver: third octaves off by more than {OFF_DB:g} dB: {bands};"
            " a smaller surface.spacing_um brings them down"
        )
    return texts


def _of_vibration(scene: Scene, vibration: Vibration | None) -> dict[str, str]:
    """Return the warnings of a vibration: extrapolated forces, flight, drift, a plate far bent."""
    texts: dict[str, str] = {}
    if vibration is None:
        return texts
    motion, loads = vibration.motion, vibration.law.load_n
    if motion.outside_share > 0:
        texts["force_outside"] = (
            f"force law: the contact force leaves the marched loads of {rounded(loads[0], 3)} to"
            f" {rounded(loads[-1], 3)} N for {rounded(100 * motion.outside_share)} % of the time,"
            " and is extrapolated there"
        )
    if motion.flight_share > 0:
        impacts = f"{motion.impacts} impact{'' if motion.impacts == 1 else 's'}"
        lost = f"{rounded(100 * motion.flight_share)} % of the time"
        text = f"contact: lost for {lost}, with {impacts}"
        if motion.flight_share == 1:
            text += ": the record is shorter than a flight; choose a longer one"
        texts["impacts"] = text
    repeats = not scene.is_smooth and scene.rolling.drop_mm is None
    if scene.track.closed and not motion.settled and repeats:
        text = "motion: it does not repeat from lap to lap, so its record does not loop"
        if motion.flight_share > 0:
            text += "; impacts need not repeat"
        elif len(scene.plate.contact_ends_mm) > 1:
            text += "; the contact moves on the plate"
        elif scene.motion.is_constant(scene.duration):
            text += "; it has not run in, so another record may have another level"
        texts["not_settled"] = text
    thickness = scene.plate.thickness_mm
    if thickness is not None and (bent := 1e3 * np.ptp(motion.plate_m) / thickness) > BENT:
        texts["plate_deflection"] = (
            f"plate: it sinks and rises by {rounded(bent)} of its thickness; thin-plate theory"
            f" wants a deflection that is small against it, at most about {BENT:g}"
        )
    return texts
