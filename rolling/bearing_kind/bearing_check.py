"""Check of the scene of a bearing before it is run: geometry, speeds, loads, cost and doubts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded, si
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from acoustics.traps import ignoring_underflow
from rolling.bearing import iso_15242
from rolling.bearing.kinematics import lines_of
from rolling.bearing.limits import LONGEST_RUN_IN_S, bounce_hz
from rolling.bearing.linear_ring import LinearRing, free_tilt_db, linear_ring
from rolling.bearing.ring_bending import ORDERS
from rolling.bearing.static_load import angles_under_loads
from rolling.bearing.waves import hertz_pressure, semi_axes
from rolling.bearing_kind import needs, standard_conditions
from rolling.bearing_kind.assumed_worth import assumed_doubt
from rolling.bearing_kind.band_edges import edge_doubts
from rolling.bearing_kind.bearing_forecast import different_marches, forecast_of, marches_seconds
from rolling.bearing_kind.contact_plan import (
    ContactPlan,
    contact_of,
    contact_plan,
    kinds_of_contact,
)
from rolling.bearing_kind.faults import reach_across
from rolling.check import cost, forecast, refusals
from rolling.check.finding import Finding
from rolling.check.findings import Findings
from rolling.numbers.bearing_numbers import AXIAL_NAMES
from rolling.numbers.doubt import TRUSTED_DB, Doubt, Severity, sized
from rolling.scene import bearing_rules
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.bearing_sources import assumed_keys, sources, static_load_rating_n
from rolling.scene.raceways import BearingBall, BearingSurface, Raceway
from rolling.scene.surfaces import BallHeightFile, GradedBall
from rolling.scene.sweep import run_name

HIGHEST_HZ = VELOCITY_BANDS_HZ["high"][1]
_TURNED_DEG = 0.5  # turn of the contact angle by the loads, beyond which axial bands do not hold
AXIAL_DOUBT = "contact_angle"  # key of the doubt that concerns axial velocities alone
# The smallest ball bearing that a maker announced is 1.5 x 0.5 mm with six balls (MinebeaMitsumi,
# 2015). Others of that size have like proportions.
_SMALL_MM = 2.5  # outside diameter below which only miniature bearings are made
_SMALLEST_MM = 1.4
_MINIATURE_BALLS = 7
_MINIATURE_BORE = 0.36  # of the outside diameter
# Four pits of a 6205 in oil of 32 mm2/s, with the shares of waves that a film presses flat.
_FAULT_IN_FILM_DB = 0.5
_SPREAD_SHARE = 0.05  # of the load of a ball that a ring moves when it bends, from which it is said
_DECAYED = 3  # decay times after which a start is forgotten
_CENTRIFUGAL_SHARE = 0.1  # of the mean load of a ball, from which on it is said


@ignoring_underflow
def check_bearing(scene: BearingScene) -> Findings:
    """Judge all runs of the scene of a bearing before anything is computed.

    Parameters
    ----------
    scene : BearingScene
        Scene, with or without a sweep.

    Returns
    -------
    Findings
        Quantities and values of each run, and doubts about them; printed, they are a table.

    Raises
    ------
    SceneError
        A contact cannot be made with these values, or a height file cannot be used.

    Examples
    --------
    >>> import rolling
    >>> findings = rolling.read_scene("bearing-6204").check()
    >>> {row.key: row.value for row in findings}["BPFO"]
    '92.3 Hz'
    """
    rows: dict[str, list[Finding]] = {}
    doubts: dict[str, list[Doubt]] = {}
    runs: list[tuple[BearingScene, ContactPlan]] = []
    for values, run in scene.runs():
        name = run_name(values) or run.name
        plan = contact_plan(run)
        lacking = needs.excess(run, plan, workers=0, folder=refusals.OUTPUTS)
        rows_and_doubts = [*scene_rules(run), *_cost(plan), *lacking]
        rows[name] = [row for row in rows_and_doubts if isinstance(row, Finding)]
        doubts[name] = [doubt for doubt in rows_and_doubts if isinstance(doubt, Doubt)]
        runs.append((run, plan))
    of_runs = forecast_of(runs)
    whole = f"{forecast.takes(of_runs.core_seconds)}, with start, files and page"
    if of_runs.compilations:
        whole += f", and with compilation of the {' and the '.join(of_runs.compilations)}"
    of_all = (("time of the whole run", whole),)
    return Findings(rows, doubts, of_all, seconds=of_runs.core_seconds)


def scene_rules(scene: BearingScene) -> Iterator[Finding | Doubt]:
    """Yield rows and doubts of one run from its scene, in the order of the table."""
    yield from _geometry(scene)
    yield from _speeds(scene)
    yield from _loads(scene)
    yield from _ring(scene)
    yield from _balls(scene)
    yield from _films(scene)
    yield from _standard(scene)
    yield from _surfaces(scene)
    yield from _assumed(scene)
    yield from _record(scene)


# ---- geometry and speeds


def _geometry(scene: BearingScene) -> Iterator[Finding | Doubt]:
    bearing = scene.bearing
    name = f"{bearing.named}, " if bearing.named is not None else ""
    yield Finding(
        "bearing",
        "bearing",
        f"{name}{bearing.balls} balls of {bearing.ball_diameter_mm:g} mm on a circle of"
        f" {bearing.pitch_diameter_mm:g} mm",
    )
    yield from _size(scene)
    sizes = " x ".join(
        rounded(1e3 * size, 4) for size in (scene.bore, scene.outside_diameter, scene.width)
    )
    yield Finding("boundary", "boundary dimensions", f"{sizes} mm")
    yield Finding(
        "grooves",
        "radii of the grooves",
        f"{bearing.conformity_inner:g} and {bearing.conformity_outer:g} ball diameters, inner and"
        " outer",
    )
    clearance = f"{rounded(1e6 * scene.radial_clearance, 3)} um"
    yield Finding("radial_clearance", "radial clearance", clearance)
    if not scene.axial_load:
        yield Finding("contact_angle", "contact angle", "0 under a purely radial load")
        return
    free = rounded(math.degrees(scene.contact_angle), 3)
    kept = ", kept in motion" if scene.bearing.angle == "fixed" else ""
    yield Finding(
        "contact_angle",
        "contact angle",
        f"{free} degrees without load{kept}; {_turned(scene)} under the loads",
    )
    doubt = contact_angle_doubt(scene)
    if doubt is not None:
        yield doubt


def contact_angle_doubt(scene: BearingScene) -> Doubt | None:
    """Return the doubt about axial velocities at an angle that the loads would turn, if they do.

    How wrong these are depends on the frequency, because the angle moves the axial resonance. The
    turned angle in place of the free one would leave errors as well.
    """
    if not scene.axial_load or scene.bearing.angle == "moving":
        return None
    free = math.degrees(scene.contact_angle)
    if max(abs(angle - free) for angle in _angles_under_loads(scene)) <= _TURNED_DEG:
        return None
    return Doubt(
        AXIAL_DOUBT,
        f"the loads would turn the contact angle from {rounded(free, 3)} degrees to"
        f" {_turned(scene)}, and the motion keeps it, so axial velocities are wrong by decibels"
        " that are not known",
        Severity.DO_NOT_QUOTE,
        advice="quote the radial velocities alone, or give bearing.angle moving",
        about=AXIAL_NAMES,
    )


def _angles_under_loads(scene: BearingScene) -> tuple[float, float]:
    """Return the least and the largest contact angle [degrees] of balls that bear load."""
    least, most = angles_under_loads(scene.geometry, scene.loaded_ring)
    return math.degrees(least), math.degrees(most)


def _turned(scene: BearingScene) -> str:
    """Write the contact angles under the loads."""
    first, last = (rounded(angle, 3) for angle in _angles_under_loads(scene))
    return f"{first} degrees" if first == last else f"between {first} and {last} degrees"


def _size(scene: BearingScene) -> Iterator[Doubt]:
    """Doubt a bearing that is smaller than those that are made, as of sizes in inches.

    Miniature bearings have few balls and a bore of a third of their outside diameter. Inches make
    such diameters of usual bearings, which have more balls or a larger bore.
    """
    outside_mm = 1e3 * scene.outside_diameter
    if outside_mm >= _SMALL_MM:
        return
    is_made = (
        outside_mm >= _SMALLEST_MM
        and scene.bearing.balls <= _MINIATURE_BALLS
        and scene.bore <= _MINIATURE_BORE * scene.outside_diameter
    )
    if is_made:
        return
    in_inches = 25.4 * outside_mm
    yield Doubt(
        "size",
        f"no such bearing is made: {scene.bearing.balls} balls in an outside diameter of"
        f" {rounded(outside_mm, 3)} mm, where its ring would bend at"
        f" {si(scene.ring_bending_hz, 'Hz')}; sizes in inches?",
        Severity.DO_NOT_QUOTE,
        advice=f"give millimetres; as inches the outside diameter is {rounded(in_inches, 3)} mm",
    )


def _speeds(scene: BearingScene) -> Iterator[Finding]:
    speeds = scene.kinematics
    yield Finding(
        "speed",
        "speed",
        f"{rounded(scene.bearing.speed_rpm, 4)} rpm of the {speeds.turning} ring; the"
        f" {speeds.moving} ring vibrates",
    )
    for name, frequency in lines_of(speeds).items():
        yield Finding(name, name, si(frequency, "Hz"))
    yield Finding("rolling_speed", "rolling speed", f"{rounded(speeds.rolling_speed_m_s, 3)} m/s")


# ---- loads and contacts


def ball_loads(scene: BearingScene) -> tuple[float, float]:
    """Return the least and the largest load [N] of a ball over the places of the cage."""
    loads = np.array([balance.ball_load_n for balance in scene.model.balances()])
    return float(loads.min()), float(loads.max())


def _loads(scene: BearingScene) -> Iterator[Finding | Doubt]:
    least, most = ball_loads(scene)
    yield Finding("ball_loads", "loads of the balls", _range(least, most, "N"))
    yield from _spread_load(scene, most)
    for ring in ("inner", "outer"):
        contact = getattr(scene.geometry, ring)
        pressure = hertz_pressure(contact, most)
        axes = semi_axes(contact, most)
        yield Finding(f"{ring}_pressure", f"Hertz pressure, {ring} ring", si(pressure, "Pa"))
        yield Finding(
            f"{ring}_semi_axes",
            f"semi-axes of the contact, {ring} ring",
            f"{si(axes.along, 'm')} along, {si(axes.across, 'm')} across the track",
        )
    share = bearing_rules.largest_pressure(scene.bearing, scene.geometry)
    share /= 1e9 * bearing_rules.STATIC_GPA
    text = f"{share:.0%} of {bearing_rules.STATIC_GPA} GPa"
    if scene.model.bending or scene.model.tilts:
        text += " with a ring that stays round and straight"
    rating = static_load_rating_n(scene)
    if rating is not None:
        text += f"; catalogues give a static load rating of {si(rating, 'N')}"
    yield Finding("static_capacity", "largest pressure", text)


def _spread_load(scene: BearingScene, most_n: float) -> Iterator[Doubt]:
    """Say how a ring that bends or tilts bears a load otherwise than one in a stiff seat.

    most_n is the largest load [N] of a ball of the scene.
    """
    stiff = replace(scene.model, bending=(), tilt_inertia_kg_m2=None)
    seated_n = max(float(balance.ball_load_n.max()) for balance in stiff.balances())
    if abs(most_n - seated_n) <= _SPREAD_SHARE * seated_n:
        return
    ways = []
    keys = []
    if scene.model.bending:
        ways.append("bends")
        keys.append("bearing.ring: rigid")
    if scene.model.tilts:
        ways.append("tilts")
        keys.append("bearing.tilt: held")
    yield Doubt(
        "free_ring",
        f"the ring {' and '.join(ways)} under the loads, as without a seat: the most loaded ball"
        f" bears {rounded(most_n, 3)} N, and {rounded(seated_n, 3)} N where a stiff seat holds the"
        " ring",
        Severity.NOTE,
        advice=f"{' and '.join(keys)} is such a seat",
    )


def _range(least: float, most: float, unit: str) -> str:
    """Write a range of numbers, or one number."""
    first = rounded(least, 3)
    last = rounded(most, 3)
    if first == last:
        return f"{last} {unit} each"
    return f"{first} to {last} {unit}"


# ---- ring


def _ring(scene: BearingScene) -> Iterator[Finding | Doubt]:
    mass = f"{rounded(scene.ring_mass, 3)} kg"
    if scene.bearing.ring_mass_kg is None:
        mass += ", from its dimensions"
    yield Finding("ring_mass", f"mass of the {scene.moving_ring} ring", mass)
    ring = linear_ring(scene.model)
    text = f"{si(ring.radial_hz, 'Hz')} radial"
    if ring.axial_hz > 0:
        text += f", {si(ring.axial_hz, 'Hz')} axial"
    yield Finding("ring_resonances", "resonances of the ring", text)
    yield from _lasting(ring)
    yield from _bending(scene, ring.resonances_hz)
    if scene.bearing.tilt == "free":
        return
    section = scene.ring_section
    tilt_db = free_tilt_db(scene.geometry, scene.model.rolling_angle, section.radius, section.width)
    if tilt_db > TRUSTED_DB:
        yield sized(
            "tilt",
            f"the ring cannot tilt here; one without guidance would move {tilt_db:.1f} dB less"
            " along its radius, well above its rocking mode",
            tilt_db,
            advice="bearing.tilt: free lets it tilt, at a moving angle",
        )


def _lasting(ring: LinearRing) -> Iterator[Doubt]:
    """Doubt resonances in the bands that ring longer than a motion runs in."""
    resonances_hz = ring.resonances_hz
    in_bands = (resonances_hz >= VELOCITY_BANDS_HZ["low"][0]) & (resonances_hz <= HIGHEST_HZ)
    lasting = in_bands & (ring.decays_s > LONGEST_RUN_IN_S / _DECAYED)
    if not np.any(lasting):
        return
    slowest = np.flatnonzero(lasting)[np.argmax(ring.decays_s[lasting])]
    decay_s = float(ring.decays_s[slowest])
    rings = "does not decay" if math.isinf(decay_s) else f"decays within {rounded(decay_s, 2)} s"
    yield Doubt(
        "lasting_resonance",
        f"the resonance at {si(resonances_hz[slowest], 'Hz')} {rings}, and a motion runs in for"
        f" {LONGEST_RUN_IN_S:g} s at most: the velocities depend on the length of the record",
        Severity.DO_NOT_QUOTE,
        advice="give a larger bearing.contact_loss_factor, 0.02 as steel in dry contact, or oil",
    )


def _bending(scene: BearingScene, resonances_hz: Array) -> Iterator[Finding | Doubt]:
    """Yield the bending modes of the ring, those that are left out, and the doubt about them."""
    bending = scene.ring_bending
    modes = ", ".join(si(bending.in_plane_hz(order), "Hz") for order in ORDERS)
    yield Finding("ring_bending", "bending modes of the ring in its plane", f"{modes}, free")
    if scene.model.bending:
        resonances = ", ".join(dict.fromkeys(si(hz, "Hz") for hz in resonances_hz))
        yield Finding("elastic_resonances", "resonances of the elastic ring", resonances)
        own_kg = bending.mass_kg
        fixed_kg = scene.ring_mass - own_kg
        if fixed_kg > own_kg:
            yield Doubt(
                "fixed_mass",
                f"{rounded(fixed_kg, 2)} kg are fixed to a ring of {rounded(own_kg, 2)} kg, which"
                " bends here as if it were free of them",
                Severity.INDICATIVE,
                advice="bearing.ring: rigid holds it from bending",
            )
    first = si(bending.out_of_plane_hz(ORDERS[0]), "Hz")
    text = f"{first}, bending and twist out of the plane, free"
    yield Finding("ring_left_out", "lowest mode of the ring that is left out", text)
    holds_hz = scene.ring_holds_hz
    if holds_hz >= HIGHEST_HZ:
        return
    text = f"the ring bends from {si(holds_hz, 'Hz')} on, and is rigid here"
    advice = "velocities above are those of a rigid ring"
    if scene.plate is None:
        advice += "; bearing.ring: elastic bends it in its plane"
    if scene.model.bending:
        text = f"modes of the ring from {si(holds_hz, 'Hz')} on are left out"
        advice = "velocities above lack them"
    yield Doubt("ring_bending", text, Severity.INDICATIVE, advice=advice)


def _films(scene: BearingScene) -> Iterator[Finding | Doubt]:
    """Yield the films of oil and what they do, and doubts about films that surfaces interrupt."""
    if not scene.films:
        return
    oil = scene.films["inner"].oil
    assert scene.bearing.oil is not None
    viscosity = f"{rounded(1e3 * oil.viscosity_pa_s, 3)} mPa s"
    at = f"at {scene.bearing.oil.temperature_c:g} degrees C"
    yield Finding("viscosity", "viscosity of the oil", f"{viscosity} {at}")
    for ring, film in scene.films.items():
        text = si(film.thickness_m, "m")
        if math.isfinite(film.ratio):
            text += f", lambda {rounded(film.ratio, 2)}"
        yield Finding(f"{ring}_film", f"film of oil, {ring} ring", text)
    mixed = {ring: film for ring, film in scene.films.items() if 0 < film.weight < 1}
    if mixed:
        ratios = ", ".join(f"{rounded(film.ratio, 2)} {ring}" for ring, film in mixed.items())
        yield Doubt(
            "mixed_film",
            f"lambda is {ratios}: surfaces touch in part, and the dry march and the film are mixed"
            " by their weights",
            Severity.INDICATIVE,
            advice="the part film of the ± says what the weights leave open",
        )
    if scene.has_faults:
        yield sized(
            "faults_in_film",
            "single faults act as in a dry contact, and a film would lower what pits add to the"
            f" high band by up to {_FAULT_IN_FILM_DB:g} dB",
            _FAULT_IN_FILM_DB,
        )


def _balls(scene: BearingScene) -> Iterator[Finding | Doubt]:
    """Yield the resonance of a ball between its raceways, and doubts about mass that it lacks."""
    frequency = bounce_hz(scene.model, scene.model.balances())
    yield Finding("ball_resonance", "resonance of a ball", si(frequency, "Hz"))
    yield from _centrifugal(scene)
    if scene.bearing.ball_inertia:
        return
    left = 1 - (HIGHEST_HZ / frequency) ** 2
    error_db = -20 * math.log10(left) if left > 0 else math.inf
    if error_db > 1:
        yield sized(
            "ball_resonance",
            f"balls without mass hold well below their resonance at {si(frequency, 'Hz')}",
            min(error_db, 20.0),
            advice="bearing.ball_inertia: true moves them with their mass",
        )


def _centrifugal(scene: BearingScene) -> Iterator[Finding | Doubt]:
    """Yield the centrifugal force of a ball, and a doubt where it is a part of its load."""
    model = scene.model
    force = model.centrifugal_n
    yield Finding("centrifugal_force", "centrifugal force of a ball", si(force, "N"))
    mean = float(np.mean([balance.ball_load_n.mean() for balance in model.balances()]))
    if force < _CENTRIFUGAL_SHARE * mean:
        return
    text = f"the centrifugal force of a ball is {force / mean:.0%} of its mean load"
    advice = ""
    if scene.bearing.ball_inertia:
        own = "fixed" if scene.bearing.angle == "fixed" else "one"
        text += f", and turns the contact angles of both rings apart, which are {own} here"
    else:
        text += ", and is left out"
        advice = "bearing.ball_inertia: true includes its part along the contact line"
    yield Doubt("centrifugal_force", text, Severity.INDICATIVE, advice=advice)


# ---- standard, surfaces, cost, what is assumed


def _standard(scene: BearingScene) -> Iterator[Finding | Doubt]:
    texts = standard_conditions.departures(scene)
    allowed = iso_15242.axial_load_range_n(1e3 * scene.outside_diameter)
    value = "speed and load as the standard asks"
    if allowed is not None:
        value += f", {allowed[0]:g} to {allowed[1]:g} N"
    if texts:
        value = f"not met: {'; '.join(texts)}"
        yield Doubt("iso_15242", f"the bands are not ISO 15242: {'; '.join(texts)}", Severity.NOTE)
    yield Finding("iso_15242", "ISO 15242", value)
    yield from edge_doubts(scene)


def _surfaces(scene: BearingScene) -> Iterator[Finding | Doubt]:
    surfaces = scene.bearing.surfaces
    for name, surface in (
        ("balls", surfaces.balls),
        ("inner raceway", surfaces.inner),
        ("outer raceway", surfaces.outer),
    ):
        yield Finding(f"surface_{name.partition(' ')[0]}", f"surface, {name}", _words(surface))
    yield from _faults_beside(scene)
    if scene.is_smooth:
        reason = "a perfectly smooth bearing is silent"
        if scene.radial_load:
            reason = "a perfectly smooth bearing moves by the passing of its balls alone"
        yield Doubt("smooth", reason, Severity.NOTE)


def _faults_beside(scene: BearingScene) -> Iterator[Doubt]:
    """Say which faults lie beside the contacts, so that no ball meets them."""
    _, most = ball_loads(scene)
    for body in ("balls", "inner", "outer"):
        surface = getattr(scene.bearing.surfaces, body)
        contacts = [contact_of(scene.geometry, name) for name in kinds_of_contact(body)]
        half = max(semi_axes(contact, most).across for contact in contacts)
        for number, fault in enumerate(getattr(surface, "faults", None) or ()):
            if fault.at_mm is None:  # at random places within the track
                continue
            nearest = 1e-3 * abs(fault.at_mm[1]) - reach_across(fault)
            if nearest <= half:
                continue
            yield Doubt(
                "fault_beside",
                f"bearing.surfaces.{body}.faults[{number}]: the {fault.kind} lies beside the track,"
                f" {rounded(1e3 * nearest)} mm and more from its middle; the contact reaches"
                f" {rounded(1e3 * half)} mm under the largest load of a ball, so nothing meets it",
                Severity.NOTE,
                advice=f"give an at_mm whose second number is below {rounded(1e3 * half)}",
            )


def _words(surface: BearingSurface | None) -> str:
    """Describe the surface of balls or of a raceway."""
    if surface is None:
        return "smooth"
    parts = []
    if isinstance(surface, GradedBall):
        parts.append(f"{surface.grade} of ISO 3290-1, Ra {surface.law.roughness_ra_um:g} um")
        if isinstance(surface, BearingBall) and surface.wave_exponent is not None:
            parts.append(f"waves beyond order 15 falling by n^-{surface.wave_exponent:g}")
    elif isinstance(surface, BallHeightFile):
        parts.append(f"heights from {surface.path}")
    elif isinstance(surface, Raceway):
        parts.append(surface.words.replace("µ", "u"))
    elif surface.law is not None:
        parts.append(surface.law.words.replace("µ", "u"))
    if surface.waviness:
        parts.append(f"waves of the orders {', '.join(map(str, surface.waviness))}")
    if surface.faults:
        number = len(surface.faults)
        parts.append(f"{number} single fault{'s' if number > 1 else ''}")
    return "; ".join(parts) or "smooth"


def _record(scene: BearingScene) -> Iterator[Finding]:
    """Yield the length of the record, which is that to listen to where it is longer."""
    text = f"{rounded(scene.moved, 3)} s"
    if scene.listened > scene.duration:
        text += ", to listen to; a shorter one needs a shorter sound.listen_s"
    yield Finding("record", "record of the motion", text)


def _cost(plan: ContactPlan) -> Iterator[Finding]:
    marches = different_marches([plan]).values()
    seconds = marches_seconds(marches)
    text = "none, nothing is rough"
    if plan.rough:
        text = "none, films of oil part the rough surfaces"
    if marches:
        text = f"{len(marches)}, {cost.computing(seconds)}"
    yield Finding("marches", "marches of contacts", text, seconds)


def _assumed(scene: BearingScene) -> Iterator[Finding | Doubt]:
    keys = assumed_keys(scene)
    if keys:
        yield Finding("assumed", "assumed", ", ".join(keys))
    doubt = assumed_doubt(scene)
    if doubt is not None:
        yield doubt
    for key, source in sources(scene).items():
        yield Finding(f"source_{key}", key, f"{getattr(scene.bearing, key):g}: {source}")
