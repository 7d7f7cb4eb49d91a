"""Numbers of a bearing of version 0.8: its flat names, and what its summary.json becomes.

`BearingRun.summary` still gives these names for one version, and folders of 0.8 are shown by what
they become here. Nothing else knows these names.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from types import MappingProxyType
from typing import Any

from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.band_uncertainty import LOSS_FACTOR, RECORD
from rolling.bearing.ring_record import AXIAL, DIRECTIONS, RADIAL
from rolling.bearing_kind.velocities import BELOW_BENDING, DECIBELS, spread_doubt
from rolling.numbers.bearing_numbers import (
    AXIAL_NAMES,
    HOUSING,
    RMS_VELOCITY,
    UM_PER_S,
    BearingNumbers,
    RingVelocities,
)
from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.number_files import from_bytes
from rolling.numbers.quantity import BandQuantity, Quantity, RecordOfNumber, joined
from rolling.numbers.run_file import StoredBearing
from rolling.results.former_numbers import former_summary

FORMAT = 1  # of a summary.json of flat names
KIND = "bearing"
_OF_CONTACTS = (
    *("superposition", "narrow_turn", "contact_nodes", "steep_waves", "window"),
    *("unmarched_contacts", "rough_stiffness", "yielding_peaks"),
)
"""Keys of the doubts about rough contacts."""
_OF_AXIAL = ("contact_angle",)
_OF_HOUSING = ("housing_linear",)
_UNKNOWN = "version 0.8 did not store it"
_PARTS = ("um_s", "height", "resolved_by_s")  # of a line in a direction


# ---- flat names


def former_names(numbers: BearingNumbers, label: str) -> Mapping[str, Any]:
    """Return numbers by the flat names of version 0.8, read-only."""
    rigid = numbers.velocities
    below = numbers.below_bending
    bending_hz = numbers.ring.bending_hz
    angles = numbers.angles
    parts = numbers.effort.parts_cpu_s
    names = {
        "format": FORMAT,
        "kind": KIND,
        "name": numbers.name,
        "title": numbers.title,
        "label": label,
        "bands_um_s": _values(rigid),
        "bands_uncertainty_db": _spreads(rigid),
        "bands_uncertainty_parts_db": _parts_by_name(rigid),
        "bands_verdict": _verdicts(rigid),
        "bands_below_bending_um_s": _values(below),
        "bands_below_bending_uncertainty_db": _spreads(below),
        "iso_departures": list(numbers.departures),
        "housing": _former_housing(numbers),
        "moving_ring": numbers.ring.moving,
        "duration_s": numbers.motion.duration_s,
        "lines": _former_lines(numbers),
        "envelope_lines": [asdict(line) for line in numbers.envelope_lines],
        "without_faults": _former_without_faults(numbers),
        "kinematics": asdict(numbers.speeds),
        "loads": asdict(numbers.loads) | {"mean_at_angles_n": list(numbers.loads.mean_at_angles_n)},
        "contact_angle_deg": angles.free_deg,
        "contact_angles_under_loads_deg": [
            angles.least_under_loads_deg,
            angles.largest_under_loads_deg,
        ],
        "ring_mass_kg": numbers.ring.mass_kg,
        "resonances_hz": list(numbers.ring.resonances_hz),
        "ring_bending_hz": bending_hz,
        "ring_bending_note": f"above {bending_hz:.0f} Hz the rigid ring does not hold",
        "contacts": [asdict(contact) for contact in numbers.contacts],
        "march_cpu_s": numbers.effort.march_cpu_s,
        "parts_cpu_s": {} if parts is None else dict(parts),
        "contact_doubts": _former_doubts(
            [doubt for doubt in numbers.doubts if doubt.key in _OF_CONTACTS]
        ),
        "energy_error": numbers.motion.energy_error,
        "lost_contact_share": numbers.motion.lost_contact_share,
        "doubts": _former_doubts(numbers.doubts),
        "sentences": list(numbers.sentences),
    }
    return MappingProxyType(names)


def _values(velocities: RingVelocities) -> dict[str, dict[str, float | None]]:
    """Return velocities [um/s] by direction and band."""
    return {name: bands.um_s for name, bands in velocities.by_direction.items()}


def _spreads(velocities: RingVelocities) -> dict[str, dict[str, float | None]]:
    """Return the ± of velocities [dB] by direction and band."""
    return {
        name: {band: velocity.uncertainty for band, velocity in bands.by_band.items()}
        for name, bands in velocities.by_direction.items()
    }


def _verdicts(velocities: RingVelocities) -> dict[str, dict[str, str | None]]:
    """Return the verdicts on velocities by direction and band."""
    return {
        name: {band: velocity.verdict for band, velocity in bands.by_band.items()}
        for name, bands in velocities.by_direction.items()
    }


def _parts_by_name(velocities: RingVelocities) -> dict[str, dict[str, dict[str, float]]]:
    """Return the parts of the ± [dB] by their names, direction and band."""
    parts: dict[str, dict[str, dict[str, float]]] = {}
    for direction, bands in velocities.by_direction.items():
        for band, velocity in bands.by_band.items():
            for name, decibels in velocity.parts.items():
                of_part = parts.setdefault(
                    name, {each_direction: {} for each_direction in DIRECTIONS}
                )
                of_part[direction][band] = decibels
    return parts


def _former_housing(numbers: BearingNumbers) -> dict[str, Any] | None:
    """Return the numbers of the housing plate, None without one."""
    housing = numbers.housing
    if housing is None:
        return None
    return {
        "laeq_db": housing.laeq.value,
        "third_octave_db": housing.third_octaves.by_name,
        "distance_m": housing.distance_m,
        "force_n": housing.force_n,
        "velocity_um_s": housing.velocity_um_s,
    }


def _former_lines(numbers: BearingNumbers) -> list[dict[str, Any]]:
    """Return the lines of the spectrum, a flat mapping each."""
    rows = []
    for line in numbers.lines:
        row: dict[str, Any] = {
            "name": line.name,
            "meaning": line.meaning,
            "frequency_hz": line.frequency_hz,
        }
        for direction, own in line.by_direction.items():
            row |= {f"{direction}_{name}": value for name, value in asdict(own).items()}
        rows.append(row)
    return rows


def _former_without_faults(numbers: BearingNumbers) -> dict[str, Any] | None:
    """Return the numbers without faults, None for a bearing that has none."""
    healthy = numbers.without_faults
    if healthy is None:
        return None
    bands = {RADIAL: healthy.radial.by_band, AXIAL: healthy.axial.by_band}
    return {"bands_um_s": bands, "envelope_heights": healthy.heights}


def _former_doubts(doubts: Sequence[Doubt]) -> list[dict[str, Any]]:
    """Return doubts, a mapping each."""
    return [
        {
            "key": doubt.key,
            "text": doubt.text,
            "severity": doubt.severity.word,
            "decibels": doubt.decibels,
            "advice": doubt.advice,
        }
        for doubt in doubts
    ]


# ---- folders of 0.8


def former_bearing(content: bytes) -> StoredBearing:
    """Return what the summary.json of a bearing of version 0.8 becomes.

    Raises
    ------
    ValueError : the content is no such summary, or a number is missing or of another kind.
    """
    summary = former_summary(content)
    if summary.get("format") != FORMAT or summary.get("kind") != KIND:
        raise ValueError("the file beside it, numbers.json, is missing")
    try:
        nested = {
            "numbers": _nested(summary),
            "files": {"listen": _nested_listen(summary["listen"])},
            "provenance": summary["provenance"],
        }
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise ValueError(f"{error} is missing or of another kind") from error
    return from_bytes(StoredBearing, json.dumps(nested).encode())


def _nested_listen(listen: Mapping[str, Any]) -> dict[str, Any]:
    """Return the facts about listen.wav."""
    return {
        "duration_s": listen["seconds"],
        "unit": "m/s2",
        "own_full_scale": listen["own_full_scale_m_s2"],
        "full_scale": listen["full_scale_m_s2"],
    }


def _nested(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return a summary of 0.8 by subject."""
    doubts = [_nested_doubt(doubt) for doubt in summary["doubts"]]
    angle = summary.get("contact_angle_under_load_deg")
    angles = summary.get("contact_angles_under_loads_deg") or [angle, angle]
    return {
        "name": summary["name"],
        "title": summary["title"],
        "sentences": summary["sentences"],
        "below_bending": _nested_velocities(summary, doubts, is_below=True),
        "velocities": _nested_velocities(summary, doubts, is_below=False),
        "lines": [_nested_line(line) for line in summary["lines"]],
        "envelope_lines": summary["envelope_lines"],
        "without_faults": _nested_without_faults(summary),
        "ring": {
            "moving": summary["moving_ring"],
            "mass_kg": summary["ring_mass_kg"],
            "resonances_hz": summary["resonances_hz"],
            "bending_hz": summary["ring_bending_hz"],
        },
        "motion": {
            name: summary[name] for name in ("duration_s", "energy_error", "lost_contact_share")
        },
        "speeds": summary["kinematics"],
        "loads": summary["loads"],
        "angles": {
            "free_deg": summary["contact_angle_deg"],
            "least_under_loads_deg": angles[0],
            "largest_under_loads_deg": angles[-1],
        },
        "housing": _nested_housing(summary, doubts),
        "contacts": summary["contacts"],
        "effort": {
            "march_cpu_s": summary.get("march_cpu_s"),
            "parts_cpu_s": summary.get("parts_cpu_s"),
        },
        "departures": summary["iso_departures"],
        "doubts": doubts,
    }


def _nested_doubt(stored: Mapping[str, Any]) -> dict[str, Any]:
    """Return a doubt of 0.8."""
    severities = {severity.word: severity for severity in Severity}
    key = stored["key"]
    about: tuple[str, ...] = ()
    if key in _OF_AXIAL:
        about = AXIAL_NAMES
    elif key in _OF_HOUSING:
        about = (HOUSING,)
    return {
        "key": key,
        "text": stored["text"],
        "severity": int(severities[stored["severity"]]),
        "decibels": stored["decibels"],
        "advice": stored["advice"],
        "about": about,
    }


def _nested_velocities(
    summary: Mapping[str, Any], doubts: Sequence[Mapping[str, Any]], is_below: bool
) -> dict[str, Any]:
    """Return the velocities of 0.8 in the whole bands, or in their parts below the bending."""
    end = BELOW_BENDING if is_below else ""
    velocities: dict[str, Any] = {}
    for direction in DIRECTIONS:
        velocities[direction] = {}
        for band in VELOCITY_BANDS_HZ:
            name = f"{direction}_{band}{end}"
            value = summary["bands_um_s"][direction][band]
            parts = _parts_of(summary, direction, band)
            if is_below:
                value = _below_um_s(summary, direction, band)
                parts = _parts_below(summary, direction, band, parts)
            own = [spread_doubt(joined(parts))] if parts else []
            touching = [doubt for doubt in doubts if name in doubt["about"]]
            velocities[direction][band] = _velocity(summary, name, value, parts) | {
                "doubts": [*map(asdict, own), *touching],
            }
    return velocities


def _below_um_s(summary: Mapping[str, Any], direction: str, band: str) -> Any:
    """Return the velocity of a band below the bending, None where the bending cuts it unseen."""
    stored = summary.get("bands_below_bending_um_s")
    if stored is not None:
        return stored[direction][band]
    _, high_hz = VELOCITY_BANDS_HZ[band]
    return summary["bands_um_s"][direction][band] if summary["ring_bending_hz"] >= high_hz else None


def _parts_of(summary: Mapping[str, Any], direction: str, band: str) -> dict[str, float]:
    """Return the parts of the ± of a band; 0.8.0 stored that of the record alone."""
    parts = summary.get("bands_uncertainty_parts_db")
    if parts is None:
        parts = {RECORD: summary["bands_uncertainty_db"]}
    return {str(name): _number(part[direction][band]) for name, part in parts.items()}


def _parts_below(
    summary: Mapping[str, Any], direction: str, band: str, parts: dict[str, float]
) -> dict[str, float]:
    """Return the parts of the ± of a band below the bending, as far as they follow.

    The part of a loss factor is what the stored ± leaves beside the other parts.
    """
    stored = summary.get("bands_below_bending_uncertainty_db")
    if stored is None or LOSS_FACTOR not in parts:
        return parts
    total = _number(stored[direction][band])
    others = joined(parts, left_out=(LOSS_FACTOR,))
    return parts | {LOSS_FACTOR: max(total**2 - others**2, 0.0) ** 0.5}


def _number(value: Any) -> float:
    """Return a number; raise ValueError for another value."""
    if type(value) not in (int, float):
        raise ValueError(f"{value!r} is no number")
    return float(value)


def _velocity(
    summary: Mapping[str, Any], name: str, value: Any, parts: dict[str, float]
) -> dict[str, Any]:
    """Return a velocity of 0.8 as the fields of a quantity."""
    duration_s = _number(summary["duration_s"])
    quantity = Quantity(
        name=name,
        value=None,
        unit=UM_PER_S,
        measure=RMS_VELOCITY,
        uncertainty=joined(parts) if value is not None else None,
        uncertainty_unit=DECIBELS,
        parts=parts if value is not None else {},
        record=RecordOfNumber(heard_s=duration_s, solved_s=duration_s, repeats=False),
        where=f"{summary['moving_ring']} ring",
        reason=_UNKNOWN if value is None else "",
    )
    return asdict(quantity) | {"value": value}


def _nested_line(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a line of the spectrum of 0.8."""
    line = {name: row[name] for name in ("name", "meaning", "frequency_hz")}
    for direction in DIRECTIONS:
        line[direction] = {name: row.get(f"{direction}_{name}") for name in _PARTS}
    return line


def _nested_without_faults(summary: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the numbers without faults of 0.8."""
    healthy = summary["without_faults"]
    if healthy is None:
        return None
    heights = healthy["envelope_heights"].items()
    return {
        **{direction: healthy["bands_um_s"][direction] for direction in DIRECTIONS},
        "envelope": [{"name": name, "height": height} for name, height in heights],
    }


def _nested_housing(
    summary: Mapping[str, Any], doubts: Sequence[Mapping[str, Any]]
) -> dict[str, Any] | None:
    """Return the housing plate of 0.8."""
    housing = summary["housing"]
    if housing is None:
        return None
    level_db = housing["laeq_db"]
    laeq = Quantity(
        name=HOUSING,
        value=None,
        unit="dB(A)",
        measure="LAeq",
        where=f"at {_number(housing['distance_m']):g} m from the plate",
        reason="the plate does not move" if level_db is None else "",
    )
    touching = [doubt for doubt in doubts if not doubt["about"] or HOUSING in doubt["about"]]
    return {
        "laeq": asdict(laeq) | {"value": level_db, "doubts": touching},
        "third_octaves": asdict(BandQuantity.of(housing["third_octave_db"], "dB")),
        "distance_m": housing["distance_m"],
        "force_n": housing["force_n"],
        "velocity_um_s": housing["velocity_um_s"],
    }
