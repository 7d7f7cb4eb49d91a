"""Numbers of version 0.8: its flat names, and what its summary.json becomes.

Version 0.8 kept the numbers of a run as a mapping of flat names. `run.summary` still gives them for
one version, and folders of 0.8 are shown by what they become here. Nothing else knows these names.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from types import MappingProxyType
from typing import Any

from rolling.check import level_doubts
from rolling.numbers.ball_numbers import ListeningNumbers, RunNumbers
from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.file_facts import FileFacts, Provenance
from rolling.numbers.number_files import from_bytes
from rolling.numbers.quantity import RELEASED_POWER, VIBRATION, BandQuantity, joined
from rolling.numbers.run_file import StoredNumbers
from rolling.results.run_doubts import ERRORS, silent_vibration_doubts
from rolling.results.run_quantities import UNKNOWN, judged, with_quantities

# Flat names of 0.8 by the fields that hold the same numbers, subject by subject.
_SAME: Mapping[str, Mapping[str, str]] = {
    "record": {
        "source": "source",
        "load_n": "load_n",
        "steps": "steps",
        "duration_s": "duration_s",
        "loops": "loops",
        "single_event": "single_event",
        "highest_frequency_hz": "highest_frequency_hz",
        "laeq_db": "record_laeq_db",
        "scatter_db": "record_scatter_db",
        "q": "q",
        "factor_pa_per_w_m2": "factor_pa_per_w_m2",
    },
    "energy": {
        "release_power_mean_w": "release_power_mean_w",
        "release_power_rms_w": "release_power_rms_w",
        "release_power_audible_rms_w": "release_power_audible_rms_w",
        "release_power_resolved_rms_w": "release_power_resolved_rms_w",
        "balance_error": "energy_balance_error",
        "joint_error": "energy_joint_error",
    },
    "contact": {
        "hertz_area_m2": "hertz_area_m2",
        "area_mean_m2": "contact_area_mean_m2",
        "plastic_area_mean_m2": "plastic_area_mean_m2",
        "plastic_ratio": "plastic_ratio",
        "max_pressure_pa": "max_pressure_pa",
    },
    "effort": {
        "tolerance": "tolerance",
        "residual_max": "residual_max",
        "iterations_mean": "iterations_mean",
        "convolutions_mean": "convolutions_mean",
        "step_nodes": "step_nodes",
        "step_choice": "step_choice",
        "step_lowest_speed_m_s": "step_lowest_speed_m_s",
        "step_ms": "step_ms",
        "march_cpu_s": "march_cpu_s",
        "parts_cpu_s": "parts_cpu_s",
    },
    "errors": {
        "band_db": "laeq_band_error_db",
        "band_uncertainty_db": "laeq_band_error_uncertainty_db",
        "band_end_hz": "laeq_band_end_hz",
    },
}
_OF_SOUND = {  # levels of the record that is measured
    "laeq_db": "laeq_db",
    "lae_db": "lae_db",
    "laf_max_db": "laf_max_db",
    "las_max_db": "las_max_db",
    "level_db": "level_db",
    "lz_peak_db": "lz_peak_db",
    "steady_level_db": "steady_level_db",
}
_SPREADS = {
    "laeq_db": "laeq",
    "level_db": "level",
    "laf_max_db": "laf_max",
    "las_max_db": "las_max",
    "lz_peak_db": "lz_peak",
    "lae_db": "lae",
    "steady_level_db": "steady",
}
_BESIDE_VIBRATION = {  # levels of a run with dynamics
    "released_power_at_listener_db": "release_laeq_db",
    "released_power_z_at_listener_db": "release_level_db",
    "release_over_vibration_db": "release_over_vibration_db",
    "equivalent_q": "equivalent_q",
    "plate_power_level_db": "plate_power_level_db",
    "ball_power_level_db": "ball_power_level_db",
}
_MEANS = {
    "compact_source_level_db": "compact_source_level_db",
    "hemisphere_mean_level_db": "hemisphere_mean_level_db",
}
_ERRORS = {  # with an error estimate
    "grid_db": "laeq_grid_error_db",
    "grid_uncertainty_db": "laeq_grid_error_uncertainty_db",
    "solver_db": "laeq_solver_error_db",
    "subgrid_db": "laeq_subgrid_error_db",
    "subgrid_uncertainty_db": "laeq_subgrid_error_uncertainty_db",
    "plastic_ratio_grid": "plastic_ratio_grid_error",
    "plastic_ratio_grid_uncertainty": "plastic_ratio_grid_error_uncertainty",
    "grid_signal_db": "grid_signal_db",
    "grid_signal_uncertainty_db": "grid_signal_uncertainty_db",
    "solver_signal_db": "solver_signal_db",
}
_FACTS = {  # of an error estimate
    "stretches": "stretches",
    "stretch_steps": "steps",
    "order": "order",
    "order_measured": "order_measured",
    "worst_uncertainty_db": "worst_uncertainty_db",
}
_MOVING = {
    "moving_balance_error": "moving_release_balance_error",
    "moving_law_error_m": "force_law_error_m",
}
_MOTION = {
    "force_rms_n": "force_rms_n",
    "force_rms_ratio": "force_rms_ratio",
    "force_max_ratio": "force_max_ratio",
    "force_min_ratio": "force_min_ratio",
    "largest_force_n": "largest_force_n",
    "impacts": "impacts",
    "impacts_yield": "impacts_yield",
    "flight_share": "flight_share",
    "force_outside_share": "force_outside_share",
    "comb_spread_db": "comb_spread_db",
    "comb_mean_laeq_db": "comb_mean_laeq_db",
    "baffle_db": "baffle_db",
    "time_step_s": "motion_time_step_s",
    "step_error_db": "motion_step_error_db",
    "balance_error": "motion_balance_error",
    "settled": "motion_settled",
    "laps": "motion_laps",
    "transient_s": "motion_transient_s",
    "ball_mass_kg": "ball_mass_kg",
    "contact_stiffness_n_m": "contact_stiffness_n_m",
    "plate_mobility_s_kg": "plate_mobility_s_kg",
    "resonance_hz": "resonance_hz",
    "resonance_q": "resonance_q",
    "resonance_wavelength_m": "resonance_wavelength_m",
    "critical_hz": "critical_hz",
    "bending_limit_hz": "bending_limit_hz",
    "plate_deflection_m": "plate_deflection_m",
    "contact_radius_over_thickness": "contact_radius_over_thickness",
    "loss_factor": "loss_factor",
}
_FALL = {"drop_mm": "drop_mm", "restitution": "restitution"}
_PLATE_MODES = {"plate_modes": "plate_modes"}
_FORCE_LAW = {
    "force_law_loads": "force_law_loads",
    "force_law_min_n": "force_law_min_n",
    "force_law_max_n": "force_law_max_n",
    "force_law_error_n": "force_law_error_n",
    "force_law_error_db": "force_law_error_db",
    "force_law_top_error": "force_law_top_error",
    "force_law_failure": "force_law_fault",
}
_ESTIMATE = {
    "laeq_db": "vibration_estimate_laeq_db",
    "force_ratio": "vibration_estimate_force_ratio",
    "bodies": "vibration_estimate_bodies",
}
_EARS_STEADY = ("loudness_sone", "sharpness_acum", "loudness_n5_sone", "loudness_max_sone")
_EARS = (
    *_EARS_STEADY,
    "roughness_asper",
    "tone_to_noise_db",
    "tone_to_noise_hz",
    "tone_to_noise_prominent",
    "prominence_ratio_db",
    "prominence_ratio_hz",
    "prominence_ratio_prominent",
)
_TURNS = {
    "turns": "turns",
    "frequency_hz": "turn_hz",
    "modulation": "turn_modulation",
    "prominence": "turn_prominence",
    "band_hz": "turn_band_hz",
    "reason": "turn_reason",
}
_PARTS_OF_SURFACE = {"plate_ra_m": "plate_ra_m", "ball_ra_m": "ball_ra_m"}
_STATISTICS = {
    "ra_m": "ra",
    "rq_m": "rq",
    "skewness": "skewness",
    "kurtosis": "kurtosis",
    "rms_slope": "rms_slope",
    "highest_m": "highest",
    "lowest_m": "lowest",
}
_PASSES = {
    "laeq_db": "laeq_db",
    "level_db": "level_db",
    "vibration_laeq_db": "vibration_estimate_laeq_db",
    "release_power_mean_w": "release_power_mean_w",
    "plastic_work_j": "plastic_work_j",
    "depth_um": "depth_um",
}
_LONG_LEVELS = ("lae_db", "laf_max_db", "las_max_db", "lz_peak_db")
_LONG_MOTION = ("impacts", "flight_share", "force_outside_share", "limited_share")
# Doubts of 0.8 that are about the released power alone.
_OF_RELEASE = (*level_doubts.SOURCES, "resonance", "solver", "no_moving_release")
_OF_SOUND_ONLY = (*ERRORS, "band_errors", "no_error_estimate", "unknown_detail")


# ---- flat names


def former_names(numbers: RunNumbers) -> Mapping[str, Any]:
    """Return numbers by the flat names of version 0.8, read-only."""
    names: dict[str, Any] = {"name": numbers.name}
    for subject, pairs in _SAME.items():
        names |= _renamed(asdict(getattr(numbers, subject)), pairs)
    names |= _levels(numbers) | _bands(numbers) | _errors(numbers) | _surface(numbers)
    if numbers.ears is not None:
        names |= {name: getattr(numbers.ears, name) for name in _EARS}
    if numbers.turns is not None:
        names |= _renamed(asdict(numbers.turns), _TURNS)
    if numbers.motion is not None:
        names |= _motion(numbers)
    if numbers.energy.moving_balance_error is not None:
        names |= _renamed(asdict(numbers.energy), _MOVING)
    if numbers.estimate is not None:
        names |= _renamed(asdict(numbers.estimate), _ESTIMATE)
        names["contact_loss_db"] = numbers.contact_loss_db
        parts = numbers.vibration.parts
        spread = joined(parts, left_out=("instrument",)) if parts else None
        names["vibration_estimate_uncertainty_db"] = spread
    if numbers.listening is not None:
        names["listening"] = _listening(numbers.listening)
    if numbers.passes is not None:
        names["passes"] = [
            _renamed(asdict(pass_numbers), _PASSES) for pass_numbers in numbers.passes
        ]
    names["doubts"] = [
        {
            "key": doubt.key,
            "text": doubt.text,
            "advice": doubt.advice,
            "severity": doubt.severity.word,
            "decibels": doubt.decibels,
        }
        for doubt in numbers.doubts
    ]
    return MappingProxyType(names)


def _renamed(values: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Return values of fields by their former names."""
    return {former: values[name] for name, former in names.items()}


def _levels(numbers: RunNumbers) -> dict[str, Any]:
    """Return levels by their former names."""
    of_record = asdict(numbers.of_record)
    names = _renamed(of_record, _OF_SOUND)
    spreads = of_record["spreads"] or dict.fromkeys(_SPREADS)
    names["uncertainty_db"] = _renamed(spreads, _SPREADS)
    levels = numbers.levels
    if levels.vibration is None:
        return names
    names |= _renamed(asdict(levels), _BESIDE_VIBRATION)
    has_edges = numbers.motion is not None and numbers.motion.plate_modes is not None
    mean = "hemisphere_mean_level_db" if has_edges else "compact_source_level_db"
    names |= _renamed(asdict(levels), {mean: mean})
    names["vibration_laeq_db"] = levels.vibration.laeq_db
    names["vibration_level_db"] = levels.vibration.level_db
    if levels.listeners is not None:
        names["listeners"] = [
            {
                "at_mm": list(listener.at_mm),
                "laeq_db": listener.laeq_db,
                "level_db": listener.level_db,
            }
            for listener in levels.listeners
        ]
    return names


def _bands(numbers: RunNumbers) -> dict[str, Any]:
    """Return third octaves by their former names."""
    bands = numbers.bands
    own = numbers.bands_of_record
    named = {
        "third_octave_db": own,
        "third_octave_a_db": numbers.bands_a_of_record,
        "plate_power_third_octave_db": bands.plate_power,
        "ball_power_third_octave_db": bands.ball_power,
        "force_third_octave_n": bands.force,
        "grid_error_db": bands.grid_error,
        "solver_error_db": bands.solver_error,
        "subgrid_error_db": bands.subgrid_error,
        "release_third_octave_db": bands.released_power_at_listener,
    }
    if numbers.motion is not None:
        named["vibration_third_octave_db"] = bands.vibration
    names = {name: band.by_name for name, band in named.items() if band is not None}
    if own is not None:
        names["third_octave_uncertainty_db"] = own.uncertainty_by_name
    for name, band in (("grid", bands.grid_error), ("subgrid", bands.subgrid_error)):
        if band is not None:
            names[f"{name}_error_uncertainty_db"] = band.uncertainty_by_name
    return names


def _errors(numbers: RunNumbers) -> dict[str, Any]:
    """Return the errors of LAeq by their former names; none without an error estimate."""
    errors = numbers.errors
    if not errors.is_asked:
        return {}
    values = asdict(errors)
    facts: dict[str, Any] = {"reason": errors.reason}
    if errors.reason is None:
        facts = _renamed(values, _FACTS)
    quantity = numbers.quantity_of_record
    return {
        **_renamed(values, _ERRORS),
        "error_estimate": facts,
        "laeq_uncertainty_db": None if errors.reason is not None else quantity.uncertainty,
        "laeq_uncertainty_parts_db": dict(quantity.parts),
    }


def _surface(numbers: RunNumbers) -> dict[str, Any]:
    """Return the numbers of the surface by their former names."""
    surface = numbers.surface
    values = asdict(surface)
    names: dict[str, Any] = {
        "surface": _renamed(values, _STATISTICS),
        "levelling": values["levelling"],
        "wavelength_octaves": list(values["wavelength_octaves"]),
    }
    if surface.plate_ra_m is not None:
        names |= _renamed(values, _PARTS_OF_SURFACE)
    if surface.preparation is not None:
        names["preparation"] = list(values["preparation"])
    for name, former in (("made", "surface_made"), ("ball_made", "ball_surface_made")):
        if values[name] is not None:
            names[former] = values[name]
    if surface.instrument is not None:
        seen = values["instrument"]
        for source in (VIBRATION, RELEASED_POWER):
            left = getattr(surface.instrument, source)
            del seen[source]
            seen[f"{source}_error_db"] = None if left is None else left.error_db
            seen[f"{source}_spread_db"] = None if left is None else left.spread_db
            bands = None if left is None or left.bands is None else left.bands.by_name
            seen[f"{source}_third_octave_spread_db"] = bands
        names["instrument"] = seen
    if numbers.channels is not None:
        names["channels"] = [_channel(asdict(channel)) for channel in numbers.channels]
    return names


def _channel(values: dict[str, Any]) -> dict[str, Any]:
    """Return the numbers of a channel by their former names."""
    for name, former in (("third_octaves", "third_octave_db"), ("octaves", "octave_db")):
        bands = values.pop(name)
        values[former] = None if bands is None else BandQuantity(**bands).by_name
    return values


def _listening(long: ListeningNumbers) -> dict[str, Any]:
    """Return the numbers of a long record by their former names, or the reason against it."""
    if long.refused is not None:
        return {"refused": long.refused}
    names = asdict(long)
    absent = {"refused"}
    if not long.ends:
        absent.update(_LONG_LEVELS)
    absent.update(name for name in _LONG_MOTION if names[name] is None)
    return {name: value for name, value in names.items() if name not in absent}


def _motion(numbers: RunNumbers) -> dict[str, Any]:
    """Return the numbers of a motion by their former names."""
    motion = numbers.motion
    if motion is None:
        return {}
    values = asdict(motion)
    names = _renamed(values, _MOTION) | {"contact_loss_db": numbers.contact_loss_db}
    if motion.drop_mm is not None:
        names |= _renamed(values, _FALL)
    if motion.plate_modes is not None:
        names |= _renamed(values, _PLATE_MODES)
    if motion.force_law_loads is not None:
        names |= _renamed(values, _FORCE_LAW)
    return names


# ---- folders of 0.8


def former_numbers(content: bytes) -> StoredNumbers:
    """Return what the summary.json of a run of version 0.8 becomes.

    Raises
    ------
    ValueError : the content is no such summary, or a number is missing or of another kind.
    """
    summary = former_summary(content)
    if "format" in summary:
        raise ValueError("the file beside it, numbers.json, is missing")
    try:
        nested = _nested(summary)
        doubts = _doubts(summary, str(summary["source"]))
        files = {name: summary.get(name) for name in ("signal", "listen", "channel_wavs")}
        facts = from_bytes(FileFacts, _json(files))
        provenance = from_bytes(Provenance, _json(summary["provenance"]))
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{error} is missing or of another kind") from error
    numbers = from_bytes(RunNumbers, _json(nested))
    parts = summary.get("laeq_uncertainty_parts_db") or {
        "record": summary["uncertainty_db"].get("laeq")
    }
    of_estimate = {"chain": summary.get("vibration_estimate_uncertainty_db")}
    numbers = with_quantities(
        numbers,
        of_sound=_numbers_of(parts),
        of_vibration={},
        of_estimate=_numbers_of(of_estimate),
    )
    numbers = judged(numbers, [*doubts, *silent_vibration_doubts(numbers)])
    return StoredNumbers(numbers=numbers, files=facts, provenance=provenance)


def former_summary(content: bytes) -> dict[str, Any]:
    """Return the values of a summary.json of version 0.8 by their names.

    Raises
    ------
    ValueError : the content is no JSON of an object, or has a number that is not finite.
    """
    summary = json.loads(content, parse_constant=_refuse_constant)
    if not isinstance(summary, dict):
        raise ValueError("no object of names and values")
    return summary


def _refuse_constant(constant: str) -> None:
    """Refuse NaN and infinity, which JSON does not have."""
    raise ValueError(f"{constant} is no number")


def _json(value: Any) -> bytes:
    """Write a value as JSON."""
    return json.dumps(value).encode()


def _numbers_of(values: Mapping[str, Any]) -> dict[str, float | None]:
    """Return a mapping of numbers; raise ValueError for another value."""
    for name, value in values.items():
        if value is not None and type(value) not in (int, float):
            raise ValueError(f"{name}: no number")
    return {str(name): value for name, value in values.items()}


def _taken(summary: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Return the values of fields by their former names, as far as they are there."""
    return {name: summary[former] for name, former in names.items() if former in summary}


def _nested(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return a summary of 0.8 by subject."""
    has_motion = "vibration_laeq_db" in summary
    is_vibration = summary["source"] == "vibration"
    nested: dict[str, Any] = {
        "name": summary["name"],
        "sentence": (summary.get("answer") or {}).get("sentence", ""),
        "vibration": asdict(UNKNOWN),
        "released_power": asdict(UNKNOWN),
        "contact_loss_db": summary.get("contact_loss_db") or 0.0,
        "bands": _nested_bands(summary, is_vibration),
        "surface": _nested_surface(summary),
    }
    for subject, names in _SAME.items():
        nested[subject] = _taken(summary, names)
    own = _taken(summary, _OF_SOUND)
    own["spreads"] = _taken(summary["uncertainty_db"], _SPREADS)
    levels = _taken(summary, _BESIDE_VIBRATION | _MEANS)
    levels["vibration" if is_vibration else "released_power"] = own
    if has_motion and not is_vibration:
        levels["vibration"] = {
            "laeq_db": summary["vibration_laeq_db"],
            "level_db": summary["vibration_level_db"],
        }
    levels["listeners"] = summary.get("listeners")
    nested["levels"] = levels
    if "error_estimate" in summary:
        facts = summary["error_estimate"]
        nested["errors"] |= _taken(summary, _ERRORS) | _taken(facts, _FACTS)
        nested["errors"] |= {"is_asked": True, "reason": facts.get("reason")}
    nested["energy"] |= _taken(summary, _MOVING)
    if has_motion:
        nested["motion"] = _taken(summary, _MOTION | _FALL | _PLATE_MODES | _FORCE_LAW)
    if "vibration_estimate_laeq_db" in summary:
        nested["estimate"] = _taken(summary, _ESTIMATE)
    if "loudness_sone" in summary:
        nested["ears"] = _taken(summary, {name: name for name in _EARS})
    if "turns" in summary:
        nested["turns"] = _taken(summary, _TURNS)
    if "passes" in summary:
        nested["passes"] = [_taken(stored_pass, _PASSES) for stored_pass in summary["passes"]]
    if "channels" in summary:
        nested["channels"] = [_nested_channel(channel) for channel in summary["channels"]]
    nested["listening"] = summary.get("listening")
    return nested


def _band(
    values: Mapping[str, Any], unit: str, uncertainty: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Return values by the names of bands as the fields of a quantity."""
    return asdict(BandQuantity.of(values, unit, uncertainty))


def _nested_bands(summary: Mapping[str, Any], is_vibration: bool) -> dict[str, Any]:
    """Return the third octaves of a summary of 0.8."""
    spreads = summary.get("third_octave_uncertainty_db")
    own = "vibration" if is_vibration else "released_power"
    bands = {
        own: _band(summary["third_octave_db"], "dB", spreads),
        f"{own}_a": _band(summary["third_octave_a_db"], "dB(A)", spreads),
    }
    if not is_vibration and "vibration_third_octave_db" in summary:
        bands["vibration"] = _band(summary["vibration_third_octave_db"], "dB")
    for name, former, unit in (
        ("plate_power", "plate_power_third_octave_db", "dB re 1 pW"),
        ("ball_power", "ball_power_third_octave_db", "dB re 1 pW"),
        ("force", "force_third_octave_n", "N"),
        ("released_power_at_listener", "release_third_octave_db", "dB"),
        ("grid_error", "grid_error_db", "dB"),
        ("solver_error", "solver_error_db", "dB"),
        ("subgrid_error", "subgrid_error_db", "dB"),
    ):
        if former in summary:
            uncertainty = summary.get(former.replace("error_db", "error_uncertainty_db"))
            has_own = former.endswith("error_db") and former != "solver_error_db"
            bands[name] = _band(summary[former], unit, uncertainty if has_own else None)
    return bands


def _nested_surface(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of the surface of a summary of 0.8."""
    surface = _taken(summary["surface"], _STATISTICS) | _taken(summary, _PARTS_OF_SURFACE)
    surface |= {
        "levelling": summary.get("levelling"),
        "preparation": summary.get("preparation"),
        "made": summary.get("surface_made"),
        "ball_made": summary.get("ball_surface_made"),
        "wavelength_octaves": summary.get("wavelength_octaves") or [],
    }
    if "instrument" in summary:
        seen = dict(summary["instrument"])
        for source in (VIBRATION, RELEASED_POWER):
            error = seen.pop(f"{source}_error_db")
            spread = seen.pop(f"{source}_spread_db")
            bands = seen.pop(f"{source}_third_octave_spread_db")
            seen[source] = None
            if spread is not None:
                seen[source] = {
                    "error_db": error,
                    "spread_db": spread,
                    "bands": None if bands is None else _band(bands, "dB"),
                }
        surface["instrument"] = seen
    return surface


def _nested_channel(channel: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of a channel of a summary of 0.8."""
    values = dict(channel)
    for name, former in (("third_octaves", "third_octave_db"), ("octaves", "octave_db")):
        bands = values.pop(former, None)
        values[name] = None if bands is None else _band(bands, "dB")
    return values


def _doubts(summary: Mapping[str, Any], source: str) -> Iterable[Doubt]:
    """Return the doubts of a summary of 0.8."""
    severities = {severity.word: severity for severity in Severity}
    plays = VIBRATION if source == "vibration" else RELEASED_POWER
    doubts = []
    listed = summary["doubts"]
    if not isinstance(listed, list):
        raise TypeError("doubts")
    for stored in listed:
        key = stored["key"]
        about: tuple[str, ...] = ()
        if key in _OF_RELEASE:
            about = (RELEASED_POWER,)
        elif key in _OF_SOUND_ONLY:
            about = (plays,)
        doubt = {
            "key": key,
            "text": stored["text"],
            "severity": int(severities[stored["severity"]]),
            "decibels": stored["decibels"],
            "advice": stored["advice"],
            "about": about,
        }
        doubts.append(from_bytes(Doubt, _json(doubt)))
    return doubts
