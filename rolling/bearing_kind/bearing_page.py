"""Parts of the page of bearings: bands, signal, spectra, lines, loads, and a bearing that turns."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.plot_style import envelope as thinned
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from acoustics.texts import printable
from rolling.bearing import lines
from rolling.bearing.contact_lines import line_curvature
from rolling.bearing.ring_record import NOTHING_UM_S, RADIAL, UM_S
from rolling.bearing.tracks import BodyTrack
from rolling.bearing_kind import bearing_sentences, bearing_work, stored_run
from rolling.figures.catalogue import figures_of, picture_of
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.page_parts import PageParts, Part
from rolling.numbers.bearing_numbers import (
    AngleNumbers,
    BearingNumbers,
    RingNumbers,
    VelocityLine,
)
from rolling.numbers.quantity import Quantity
from rolling.report.charts import Chart
from rolling.report.level_bars import Bars, Row, bars_over_decades
from rolling.report.page_of_parts import exhibit
from rolling.report.report_page import page_gains, quantity_chart
from rolling.terminal.streams import unbroken

if TYPE_CHECKING:
    from rolling.bearing_kind.bearing_run import BearingRun

RING_PLACES = 16384  # of a raceway's track, at most
BALL_PLACES = 4096  # of a ball's track, at most
_LEAST_LOAD_N = 1e-9  # of a ball
_STEPS = 2**15 - 1  # of 16 bits
# Ends of the sliders over the value of the run, and places on them from nothing to this value.
_LEAST = 0.1
_MOST = 3.0
_PLACES_OF_SLIDER = 100
CHARTS = (
    "acceleration_signal",
    "velocity_spectrogram",
    "spectrum",
    "envelope",
    "load_distribution",
    "ball_forces",
)


def bearing_parts(runs: Sequence[BearingRun]) -> PageParts:
    """Return the parts of the page of bearings.

    Parameters
    ----------
    runs : sequence of BearingRun, at least one, in the order of the page.
    """
    gain = page_gains(runs)[stored_run.RING]
    curve = quantity_chart(runs, figures_of(runs)["quantities"])
    bars = _compared_bands(runs) if len(runs) > 1 else []
    first = {
        "together": "Radial velocity of the ring, rms, below its bending",
        "curve": curve,
        "compared": [] if curve else bars,
    }
    return PageParts(
        first=[Part("bearing_first.html", first)],
        charts=[
            Part("bearing_charts.html", {"compared": bars if curve else []}),
            Part("bearing_instrument.html"),
        ],
        doubted=[Part("bearing_doubted.html"), bearing_work.work_of(runs)],
        styles=("bearing.css",),
        script="bearing/begin.js",
        engine="bearing/worker.js",
        shared={"views": [_view(run, number, len(runs) == 1) for number, run in enumerate(runs)]},
        data={"runs": [{**data_of(run), "gain": gain} for run in runs]},
    )


def _view(run: BearingRun, number: int, is_alone: bool) -> dict[str, Any]:
    """Return the words, tables and charts of a run, whose number on the page is given.

    Its velocities are said by bars or a curve. How it runs is said by title and drawing where it is
    alone, and otherwise by a sentence.
    """
    numbers = run.numbers
    duration_s = numbers.motion.duration_s
    first, _, *others = numbers.sentences  # the second has the axial velocities
    faults = [*bearing_sentences.fault_sentences(run.scene, numbers)]
    lead = faults[0] if faults else bearing_sentences.leading_lines(numbers)
    return {
        "label": printable(run.label or run.scene.name),
        "what": "" if is_alone else _condition(run),
        "lead": _on_page(lead),
        "sentences": [_on_page(sentence) for sentence in (first, *others) if sentence != lead],
        "bars": bars_over_decades("Radial velocity of the ring, rms [µm/s]", _bars(numbers)),
        "rows": [(name, *map(" ".join, cells)) for name, cells in _band_rows(numbers)],
        "line_heads": _line_heads(numbers),
        "lines": [line_cells(line, duration_s) for line in numbers.lines],
        "envelope_lines": [
            (
                line.name,
                bearing_sentences.hertz(line.frequency_hz),
                _height_cell(line.height, line.resolved_by_s, duration_s),
            )
            for line in numbers.envelope_lines
        ],
        "charts": _charts(run, number),
        "facts": _facts(run),
    }


def _condition(run: BearingRun) -> str:
    """Say how a bearing runs."""
    words = bearing_sentences.condition(run.scene)
    return f"{words[0].upper()}{words[1:]}."


def _charts(run: BearingRun, number: int) -> dict[str, Chart]:
    """Return the charts of a run by their names."""
    figures = figures_of([run])
    charts = {}
    for name in CHARTS:
        with left_out_if_it_fails(f"{name} of {run.label}"):
            # A chart has an axis along, where a file may have one around.
            kind = replace(figures[name], is_polar=False)
            chart = exhibit(picture_of(name, kind, run)) | {"run": number}
            chart["note"] = _without_condition(chart["note"], run)
            charts[name] = chart
    return charts


def _without_condition(note: str, run: BearingRun) -> str:
    """Return the note of a chart without how the bearing runs, which the page says once."""
    rest = note.removeprefix(_condition(run).removesuffix("."))
    rest = rest.removeprefix("; ")
    return f"{rest[:1].upper()}{rest[1:]}"


# ---- velocities in the three bands


def _bars(numbers: BearingNumbers) -> list[Row]:
    """Return the radial velocity of each band below the bending as a row of bars."""
    words = bearing_sentences.band_words(numbers.ring)
    radial = numbers.below_bending.radial.by_band
    return [_bar(f"{name}", radial[band]) for band, name in words.items()]


def _compared_bands(runs: Sequence[BearingRun]) -> list[Bars]:
    """Return bars of the radial velocity of all runs, those of each band together."""
    compared = []
    for band, name in bearing_sentences.BAND_WORDS.items():
        rows = []
        for run in runs:
            label = printable(run.label or run.scene.name)
            if band in bearing_sentences.band_words(run.numbers.ring):
                rows.append(_bar(label, run.numbers.below_bending.radial.by_band[band]))
            else:  # all of the band lies above the bending
                rows.append(_no_bar(label))
        compared.append(bars_over_decades(f"{name} [µm/s]", rows))
    return compared


def _bar(name: str, velocity: Quantity) -> Row:
    """Return a velocity with its ± as a row of bars."""
    words, spread = _cell(velocity)
    value = velocity.value
    if value is not None and value < NOTHING_UM_S:
        value = None  # a ring at rest has no bar
    low = high = None
    if value is not None and spread.startswith("±") and velocity.uncertainty is not None:
        factor = 10 ** (velocity.uncertainty / 20)
        low, high = value / factor, value * factor
    return Row(name=name, value=value, low=low, high=high, words=words, spread=spread)


def _no_bar(name: str) -> Row:
    """Return the row of a velocity that is not known."""
    words = bearing_sentences.NO_VELOCITY
    return Row(name=name, value=None, low=None, high=None, words=words)


def _band_rows(numbers: BearingNumbers) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return a row for each band with its velocities and their ±, radial and axial.

    Bands end where the ring bends. What they have with a rigid ring above follows.
    """
    holds_hz = numbers.ring.holds_hz
    above = bearing_sentences.above(numbers.ring)
    below = numbers.below_bending.by_direction.values()
    rigid = numbers.velocities.by_direction.values()
    rows = []
    for band, words in bearing_sentences.band_words(numbers.ring).items():
        rows.append((words, [_cell(velocities.by_band[band]) for velocities in below]))
    for band, (_, high) in VELOCITY_BANDS_HZ.items():
        if holds_hz >= high:
            continue
        cells = [_cell(velocities.by_band[band]) for velocities in rigid]
        rows.append((f"{bearing_sentences.BAND_WORDS[band]}, {above}", cells))
    return rows


def _cell(velocity: Quantity) -> tuple[str, str]:
    """Return the value of a velocity and its ±, or the verdict of one that is not to be quoted."""
    text = bearing_sentences.velocity(velocity.value)
    return text, bearing_sentences.spread_of_velocity(velocity)


def _on_page(sentence: str) -> str:
    """Return a sentence with the sign of micrometres, and numbers beside their units."""
    return unbroken(sentence.replace(" um/s", " µm/s"))


def _line_heads(numbers: BearingNumbers) -> list[str]:
    """Return the heads of the table of lines; the axial velocities may have a verdict."""
    axial = "Axial [µm/s]"
    if numbers.axial_doubt is not None:
        axial += f", {numbers.axial_doubt.severity.word}"
    return [
        "Line",
        "What happens",
        "Frequency [Hz]",
        "Radial [µm/s]",
        "radial, over surroundings",
        axial,
        "axial, over surroundings",
    ]


def line_cells(line: VelocityLine, duration_s: float) -> list[str]:
    """Return the cells of a line: name, meaning, frequency, velocities and heights."""
    cells = [line.name, line.meaning, bearing_sentences.hertz(line.frequency_hz)]
    for own in line.by_direction.values():
        cells.append("" if own.um_s is None else bearing_sentences.velocity(own.um_s))
        cells.append(_height_cell(own.height, own.resolved_by_s, duration_s))
    return cells


def _height_cell(height: float | None, resolving_s: float | None, duration_s: float) -> str:
    """Write the height of a line over its surroundings, or that it is not resolved."""
    if resolving_s is not None:
        return unbroken(bearing_sentences.unresolved(duration_s, resolving_s))
    return rounded(height or 0.0)


def _facts(run: BearingRun) -> list[tuple[str, str]]:
    """Return the numbers of a bearing that its page lists."""
    numbers = run.numbers
    bearing = run.scene.bearing
    angles = numbers.angles
    loads = numbers.loads
    turn = "turn" if bearing.angle == "moving" else "would turn"
    resonances = [f"{hz:.0f} Hz" for hz in numbers.ring.resonances_hz if hz > 0]
    return [
        ("Balls", f"{bearing.balls} of {bearing.ball_diameter_mm:g} mm"),
        ("Pitch diameter", f"{bearing.pitch_diameter_mm:g} mm"),
        (
            "Contact angle",
            f"{angles.free_deg:.1f} degrees; the loads {turn} it to {_range_of_angles(angles)}",
        ),
        (
            "Rolling speed of a contact",
            f"{rounded(numbers.speeds.rolling_speed_m_s, 3)} m/s",
        ),
        (
            "Moving ring",
            f"the {numbers.ring.moving} one, {rounded(1e3 * numbers.ring.mass_kg, 3)} g",
        ),
        ("Resonances of the rigid ring", ", ".join(resonances)),
        (
            "First bending mode",
            _bending(numbers.ring),
        ),
        (
            "Load of a ball",
            f"{rounded(loads.least_n, 3)} to {rounded(loads.largest_n, 3)} N, mean"
            f" {rounded(loads.mean_n, 3)} N",
        ),
        ("Energy that the balance lacks", f"{rounded(100 * numbers.motion.energy_error)} %"),
    ]


def _range_of_angles(angles: AngleNumbers) -> str:
    """Write the least and the largest angle under the loads, or one where they are alike."""
    degrees = (angles.least_under_loads_deg, angles.largest_under_loads_deg)
    return " to ".join(dict.fromkeys(f"{degree:.1f}" for degree in degrees))


# ---- data of the instrument


def data_of(run: BearingRun) -> dict[str, Any]:
    """Return what the scripts of the page know of a run, in SI but where names say otherwise."""
    bearing = run.scene.bearing
    narrow = run.record.spectra[RADIAL]
    shown = (narrow.frequency_hz >= 20) & (narrow.frequency_hz <= 20000)
    log_hz, um_s = thinned(np.log(narrow.frequency_hz[shown]), UM_S * narrow.rms[shown])
    return {
        "label": printable(run.label or run.scene.name),
        "bearing": _model_of(run),
        "drawn": _drawn(run),
        "settings": {
            "rpm": bearing.speed_rpm,
            "axial": bearing.axial_load_n,
            "radial": bearing.radial_load_n,
        },
        "ranges": _ranges(run),
        "bandsHz": [list(edges) for edges in run.bands_below_bending_hz.values()],
        "bands": _bands_m_s(run.numbers),
        "gain": stored_run.ring_sound(run).own_gain,
        "spectrum": {"hz": _digits(np.exp(log_hz), 6), "um_s": _digits(um_s, 4)},
        "lines": [_mark(line) for line in run.lines],
        "bendingHz": run.scene.ring_holds_hz,
    }


def _bands_m_s(numbers: BearingNumbers) -> list[float | None]:
    """Return the radial velocities below the bending [m/s]; None where one is not known."""
    values = numbers.below_bending.radial.um_s.values()
    return [None if um_s is None else um_s / UM_S for um_s in values]


def _mark(line: lines.BearingLine) -> dict[str, Any]:
    """Return a line as the charts mark it."""
    return {"name": line.name, "hz": line.frequency_hz, "minor": line.minor}


def _bending(ring: RingNumbers) -> str:
    """Say where the ring bends, and up to which frequency it is as a real one."""
    if ring.left_out_hz is None:
        return f"above {ring.bending_hz:.0f} Hz the rigid ring does not hold"
    return f"{ring.bending_hz:.0f} Hz; modes from {ring.left_out_hz:.0f} Hz on are left out"


def _model_of(run: BearingRun) -> dict[str, Any]:
    """Return the small model of a bearing: springs, mass, speeds, and tracks at some loads."""
    model = run.model
    speeds = model.kinematics
    return {
        "balls": model.geometry.balls,
        "stiffness": model.geometry.series_stiffness,
        "alpha": model.geometry.contact_angle,
        "curvature": line_curvature(model.geometry, model.gap_m, model.angle),
        "sign": 1 if speeds.moving == "inner" else -1,
        "gap": model.gap_m,
        "mass": model.ring_mass_kg,
        "lossFactor": model.contact_loss_factor,
        "filmTime": model.film_time_s,
        "rpm": run.scene.bearing.speed_rpm,
        "hz": {
            "cage": speeds.cage_hz,
            "inner": speeds.inner_hz,
            "outer": speeds.outer_hz,
            "spin": speeds.ball_spin_hz,
        },
        "loads": _loads_of_tracks(run).tolist(),
        "tracks": {
            "inner": _packed_track(run, run.tracks.inner, RING_PLACES),
            "outer": _packed_track(run, run.tracks.outer, RING_PLACES),
            "ballsOnInner": [
                _packed_track(run, track, BALL_PLACES) for track in run.tracks.balls_on_inner
            ],
            "ballsOnOuter": [
                _packed_track(run, track, BALL_PLACES) for track in run.tracks.balls_on_outer
            ],
        },
    }


def _loads_of_tracks(run: BearingRun) -> Array:
    """Return the loads [N] at which the page knows the tracks: least, mean in the run, largest."""
    tracks = run.tracks
    every = (tracks.inner, tracks.outer, *tracks.balls_on_inner, *tracks.balls_on_outer)
    known = [load for track in every if len(track.loads_n) > 1 for load in track.loads_n]
    mean = max(float(run.record.ball_load_n.mean()), _LEAST_LOAD_N)
    return np.unique([min([*known, mean]), mean, max([*known, mean])])


def _packed_track(run: BearingRun, track: BodyTrack, most: int) -> list[dict[str, Any]]:
    """Return a track at the loads of the page, each in steps of 16 bits."""
    points = min(track.points, most)
    return [_packed(row) for row in track.resampled(points).at_loads(_loads_of_tracks(run))]


def _packed(heights: Array) -> dict[str, Any]:
    """Return heights [m] as whole numbers of a unit in base 64, 16 bits each, little end first."""
    largest = float(np.abs(heights).max())
    unit = largest / _STEPS if largest > 0 else 1.0
    steps = np.rint(heights / unit).astype("<i2")
    return {"unit": unit, "text": base64.b64encode(steps.tobytes()).decode()}


def _drawn(run: BearingRun) -> dict[str, Any]:
    """Return the radii [m] of the picture."""
    scene = run.scene
    geometry = run.geometry
    return {
        "turning": scene.bearing.turning,
        "pitch": geometry.pitch_radius_m,
        "ball": geometry.ball_radius_m,
        "innerRaceway": geometry.inner.radius_m,
        "outerRaceway": geometry.outer.radius_m,
        "outer": scene.outside_diameter / 2,
        "bore": scene.bore / 2,
        "faultBall": scene.bearing.surfaces.fault_ball if "balls" in run.faulty else -1,
    }


def _ranges(run: BearingRun) -> dict[str, list[float]]:
    """Return least, largest and step of the sliders: speed [1/min] and loads [N].

    Each slider has the value of the run among its places.
    """
    bearing = run.scene.bearing
    axial = bearing.axial_load_n
    radial = bearing.radial_load_n
    least_radial = 0.0 if axial > 0 else _LEAST
    return {
        "rpm": _range(bearing.speed_rpm, _LEAST),
        "axial": _range(axial, _LEAST),
        "radial": _range(radial or axial, least_radial),
    }


def _range(value: float, least: float) -> list[float]:
    """Return least, largest and step of a slider around a value; `least` is a share of it."""
    return [least * value, _MOST * value, value / _PLACES_OF_SLIDER]


def _digits(values: Array, digits: int) -> list[float]:
    """Return numbers with so many digits, which keep a page small."""
    return [float(f"{value:.{digits}g}") for value in values.tolist()]
