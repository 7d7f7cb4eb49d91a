"""Runs of a bearing as a user meets them: numbers, folders, commands and sounds."""

from __future__ import annotations

import json
import math
import re
import shutil
from dataclasses import replace
from operator import attrgetter
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import soundfile
from bearing_runs import PLATE, SWEPT, WAVY, loads_bearing, moved_as, solved, written
from matplotlib.figure import Figure
from stored_arrays import stored_arrays

import rolling
from acoustics import wav
from acoustics.arrays import Array
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling import cli
from rolling.bearing import lines
from rolling.bearing.band_uncertainty import BandUncertainty
from rolling.bearing.ring_motion import move_ring
from rolling.bearing.ring_record import DIRECTIONS, record_of
from rolling.bearing.tracks import BodyTrack, smooth_tracks
from rolling.bearing_kind import bearing_figures, bearing_page, bearing_tables
from rolling.bearing_kind.bearing_lines import band_table
from rolling.bearing_kind.bearing_run import BearingRun, numbered
from rolling.bearing_kind.bearing_run_numbers import MarchFindings
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.bearing_kind.joined_tracks import bearing_tracks
from rolling.bearing_kind.line_numbers import envelope_lines
from rolling.commands.run import refuse_other_contacts
from rolling.kinds.registry import kind_of
from rolling.numbers.bearing_numbers import BandVelocities, VelocityLine
from rolling.numbers.run_file import StoredBearing
from rolling.numbers.summary_schema import summary_schema
from rolling.report.report_page import page as page_of
from rolling.results.stored_numbers import read_stored, write_stored
from rolling.run import folder as folders

FILES = {
    *("result.h5", "numbers.json", "summary.json", "spectrum.csv", "lines.csv"),
    *("acceleration.wav", "listen.wav"),
}
RATE = 48_000


@pytest.fixture(scope="module")
def run() -> BearingRun:
    """A bearing with nine waves on the inner raceway and eight on the outer."""
    return rolling.simulate(loads_bearing(WAVY), progress=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run with its page, which no test changes."""
    place = tmp_path_factory.mktemp("bearing")
    assert cli.main(["run", str(written(place)), "--out", str(place / "out"), "-q"]) == 0
    return place / "out"


def stored(folder: Path) -> StoredBearing:
    return read_stored(folder)


def line_of(run: BearingRun, name: str) -> VelocityLine:
    return {line.name: line for line in run.numbers.lines}[name]


def test_summary_of_a_bearing_meets_its_schema(folder: Path) -> None:
    """The oracle is a validator of JSON Schema that knows nothing of this program."""
    jsonschema = pytest.importorskip("jsonschema", reason="the extra `docs` is not installed")
    validator = jsonschema.Draft202012Validator(summary_schema(StoredBearing))
    content = json.loads((folder / "summary.json").read_text())
    assert list(validator.iter_errors(content)) == []
    assert not validator.is_valid(content | {"unknown": 1.0})


# ---- numbers


def test_a_run_of_a_bearing_states_processor_times(folder: Path) -> None:
    """Waves are not marched."""
    effort = stored(folder).numbers.effort
    parts = effort.parts_cpu_s
    assert parts["sound"] > 0 and parts["page"] > 0
    assert effort.march_cpu_s == parts["march"] == 0
    assert pd.read_csv(folder / "runs.csv")["effort_march_cpu_s"].tolist() == [0]
    assert rolling.open_run(folder).numbers.effort == effort


@pytest.mark.law("Bearing run: nine waves of the inner raceway have their velocity and their line.")
def test_waves_have_their_velocity_in_their_band(run: BearingRun) -> None:
    """A / cos(alpha) at q BPFI + turn; the linear theory is 0.1 % off so far below resonance."""
    turn, bpfi = 30.0, run.kinematics.ball_pass_inner_hz
    wanted = 0.1 / math.cos(math.radians(12)) * 2 * math.pi * (bpfi + turn) / math.sqrt(2)
    assert run.numbers.velocities.radial.low.value == pytest.approx(wanted, rel=0.01)
    line = line_of(run, "inner 9")
    assert line.frequency_hz == pytest.approx(bpfi + turn)
    assert line.radial.um_s == pytest.approx(wanted, rel=0.01)
    assert line.axial.um_s < 1e-3 * wanted


@pytest.mark.law("Bearing run: eight waves of the outer raceway move the ring along its axis.")
def test_waves_of_the_outer_raceway_are_axial(run: BearingRun) -> None:
    bpfo = run.kinematics.ball_pass_outer_hz
    wanted = 0.05 / math.sin(math.radians(12)) * 2 * math.pi * bpfo / math.sqrt(2)
    assert run.numbers.velocities.axial.low.value == pytest.approx(wanted, rel=0.01)
    assert any("inner 9" in text and "outer 8" in text for text in run.numbers.sentences)


@pytest.mark.law("Bearing run: no axial band is to be quoted whose angle the loads would turn.")
def test_axial_bands_under_a_turned_angle_are_not_to_be_quoted(
    run: BearingRun, folder: Path
) -> None:
    """70 N turn 12 degrees to 13.9; the verdict stands wherever axial velocities do."""
    word = "do not quote"
    numbers = run.numbers
    for velocities in (numbers.velocities, numbers.below_bending):
        assert {one.verdict for one in velocities.axial.by_band.values()} == {word}
        assert word not in {one.verdict for one in velocities.radial.by_band.values()}
    (doubt,) = [doubt for doubt in numbers.doubts if doubt.key == "contact_angle"]
    assert doubt == numbers.axial_doubt
    assert doubt.severity.word == word and doubt.decibels is None
    assert " dB" not in doubt.text and "contact_angle_deg" not in doubt.advice
    (sentence,) = [text for text in numbers.sentences if text.startswith("Axially")]
    assert word in sentence
    assert run._repr_html_().count(f", {word}</td>") == 3
    table = pd.read_csv(folder / "runs.csv")
    assert set(table.filter(regex="axial_.*_verdict").iloc[0]) == {word}
    assert table.filter(regex="radial_.*_verdict").shape[1] == 6
    page = (folder / "report.html").read_text()
    axial = re.findall(r'<td data-head="Axial \[µm/s\]">([^<]*)</td>', page)
    radial = re.findall(r'<td data-head="Radial \[µm/s\]">([^<]*)</td>', page)
    assert len(axial) >= 3 and all(cell.endswith(f" {word}") for cell in axial)
    assert not any(word in cell for cell in radial)
    assert f'<th scope="col">Axial [µm/s], {word}</th>' in page
    spectrum = run.plot("spectrum")
    assert f"axial ({word})" in [line.get_label() for line in spectrum.lines]
    plt.close(spectrum.figure)


def test_an_angle_that_hardly_turns_has_no_verdict() -> None:
    scene = loads_bearing(WAVY, ["bearing.axial_load_n=5", "bearing.contact_angle_deg=25"])
    assert "contact_angle" not in {doubt.key for doubt in scene.check().doubts["wavy"]}


def test_the_turned_angle_counts_both_loads() -> None:
    """A radial load of 250 N turns the angles of a 6204 by less than 70 N along the axis alone."""
    texts = {}
    for radial in (0, 250):
        findings = loads_bearing(WAVY, [f"bearing.radial_load_n={radial}"]).check()
        (texts[radial],) = [
            doubt.text for doubt in findings.doubts["wavy"] if doubt.key == "contact_angle"
        ]
    assert "from 12 degrees to 13.9 degrees" in texts[0]
    assert "from 12 degrees to between 12.4 and 12.7 degrees" in texts[250]


@pytest.mark.law("Bearing lines: orders of waviness have the frequencies of the theory.")
def test_orders_have_the_frequencies_of_the_theory(run: BearingRun) -> None:
    speeds = run.kinematics
    waves = {"inner": [1, 7, 8, 10, 17], "outer": [7, 16], "balls": [3, 4]}
    found = {line.name: line for line in lines.wave_lines(run.model, waves)}
    assert set(found) == {
        *("inner 1", "inner 7", "inner 8", "inner 17", "outer 7", "outer 16"),
        *("ball 4", "ball 4 - cage", "ball 4 + cage"),
    }
    assert found["inner 1"].frequency_hz == pytest.approx(30)  # an eccentric ring
    assert found["inner 7"].frequency_hz == pytest.approx(speeds.ball_pass_inner_hz - 30)
    assert found["inner 17"].frequency_hz == pytest.approx(2 * speeds.ball_pass_inner_hz + 30)
    assert found["outer 7"].frequency_hz == pytest.approx(speeds.ball_pass_outer_hz)
    assert found["ball 4"].frequency_hz == pytest.approx(4 * speeds.ball_spin_hz)


NAMES = """\
name: wave-names
bearing:
  balls: 9
  ball_diameter_mm: 7.94
  pitch_diameter_mm: 39.04
  contact_angle_deg: 10
  conformity_inner: 0.515
  conformity_outer: 0.525
  speed_rpm: 1797
  axial_load_n: 100
  angle: fixed
  ring: rigid
  surfaces:
    outer: {kind: smooth, waviness: {9: 0.05, 10: 0.0001}}
sound: {duration_s: 0.5, listen_s: 0.5}
"""


@pytest.mark.law("Bearing lines: an order is credited in the direction in which it moves the ring.")
def test_orders_are_named_by_their_direction() -> None:
    """Orders 9 and 10 of the outer raceway share a line: nine balls make 9 axial, 10 radial."""
    run = rolling.simulate(loads_bearing(NAMES), progress=False)
    (said,) = [text for text in run.numbers.sentences if text.startswith("The largest lines")]
    assert "axial outer 9 (107.8 Hz, 140 um/s)" in said
    assert "radial outer 10 (107.8 Hz, 0.049 um/s)" in said
    rows = bearing_tables.line_table(run).set_index("name")
    assert rows.loc["outer 9", "radial_um_s"] == 0 == rows.loc["outer 10", "axial_um_s"]
    whole = run.numbers.velocities.axial.low.value
    assert rows.loc["outer 9", "axial_um_s"] == pytest.approx(whole, rel=1e-3)


@pytest.mark.law("Bearing lines: a line beside a stronger one is read, or told as not resolved.")
def test_a_line_that_the_record_does_not_resolve_has_no_level() -> None:
    """An outer ring that turns has nine waves at 366.7 Hz; nothing moves it at 359.5 Hz."""
    outer = "{outer: {kind: smooth, waviness: {9: 0.05}}}"
    words = ["bearing.turning=outer", f"bearing.surfaces={outer}", "sound.duration_s=0.7"]
    words.append("bearing.speed_rpm=5400")
    longer = rolling.simulate(loads_bearing(WAVY, words), progress=False)
    silent = line_of(longer, "2 x ball spin")
    assert silent.radial.um_s == 0 == silent.radial.height
    record = replace(longer.record, velocity_m_s=longer.record.velocity_m_s[: RATE // 5])
    run = moved_as(longer, record)
    silent = line_of(run, "2 x ball spin")
    assert silent.radial.um_s is None and silent.radial.height is None
    assert line_of(run, "outer 9").radial.um_s == pytest.approx(83.25, rel=0.01)
    said = " ".join(run.numbers.sentences)
    assert "Not resolved by 0.2 s" in said and "2 x ball spin (0.7 s would)" in said
    table = bearing_tables.line_table(run)
    of_velocity = table[table["of"] == "velocity"].set_index("name")
    note = "not resolved by 0.2 s, 0.7 s would"
    assert of_velocity.loc["2 x ball spin", "note"] == f"radial: {note}"
    cells = bearing_page.line_cells(silent, record.duration_s)
    assert cells[3] == "" and cells[4].replace("\N{NO-BREAK SPACE}", " ") == note


FORMER = """\
name: former
bearing:
  named: "6204"
  speed_rpm: 1800
  axial_load_n: 70
  radial_load_n: 100
  contact_angle_deg: 12
  radial_clearance_um: null
  angle: fixed
  ring: rigid
  surfaces:
    balls: {kind: graded, grade: G10, seed: 1}
    inner: {kind: raceway, finish: superfinished, seed: 2}
    outer: {kind: smooth, waviness: {8: 0.05}}
numerics: {window_mm: 2}
"""


@pytest.mark.law("Bearing motion: a dry rigid ring at a fixed angle moves as in version 0.10.")
def test_a_dry_rigid_ring_at_a_fixed_angle_moves_as_it_did() -> None:
    """Velocities of some moments, which the program had before rings bent and angles turned."""
    scene = loads_bearing(FORMER)
    velocity = move_ring(scene.model, bearing_tracks(contact_plan(scene)), 0.05).velocity_m_s
    wanted = [
        [-0.0015079250827790523, 0.002433742459194509, -0.00037981812000227816],
        [0.001131749791235721, 0.0011332413413210414, 0.0005769319887705822],
        [0.0001340589377191806, 4.030810377815655e-06, 0.001245388983700253],
    ]
    assert velocity[[800, 1500, 2200]] == pytest.approx(np.array(wanted), abs=1e-9)
    rms = [0.000940321092835759, 0.0008579137649071484, 0.001099156626293807]
    assert np.sqrt(np.mean(velocity**2, axis=0)) == pytest.approx(rms, rel=1e-6)


PIT = "{kind: smooth, faults: [{kind: pit, at_mm: [2, 0], size_um: 300, depth_um: 5}]}"


@pytest.mark.law("Bearing lines: the harmonics of a pit are a pit's, and only its line is claimed.")
def test_harmonics_of_a_pit_are_a_pits() -> None:
    words = [f"bearing.surfaces={{outer: {PIT}}}", "bearing.radial_load_n=100"]
    scene = loads_bearing(WAVY, words)
    tracks = smooth_tracks(scene.geometry)
    tracks = replace(tracks, outer=pitted(tracks.outer))
    motion = move_ring(scene.model, tracks, 0.5, RATE)
    record = record_of(motion, scene.kinematics)
    numbers = numbered(solved(scene, record, tracks)).numbers
    meanings = {line.name: line.meaning for line in numbers.lines}
    assert not [text for text in meanings.values() if "waves" in text]
    harmonics = [text for text in meanings.values() if "fault of the outer raceway" in text]
    assert len(harmonics) > 3
    claimed = [line.name for line in numbers.envelope_lines if (line.height or 0) >= 5]
    assert set(claimed) == {"BPFO", "2 (BPFO)"}


def pitted(track: BodyTrack, places: int = 8192) -> BodyTrack:
    """Return a track with a pit, 1 um deep and a hundredth of a radian wide."""
    angle = 2 * np.pi * np.arange(places) / places
    pit = 1e-6 * np.exp(-np.square((angle - np.pi) / 0.01))
    return BodyTrack(np.ones(1), track.resampled(places).approach_m[:1] + pit - pit.mean())


@pytest.mark.law("Bearing faults: a pit has its line and its side bands in the envelope.")
@pytest.mark.parametrize(
    ("body", "radial_n"),
    [("inner", 0), ("inner", 100), ("outer", 0), ("balls", 0), ("balls", 100)],
)
def test_faults_show_in_the_envelope(body: str, radial_n: float) -> None:
    """Ten times the median of the surroundings.

    One direction sees a fault that turns twice a turn, and a load zone sees it once a turn. Side
    bands once a turn of the cage stand closer, so that their record is longer.
    """
    seconds = 0.7 if radial_n else 0.4
    smooth = ["bearing.surfaces={}", f"bearing.radial_load_n={radial_n}"]
    scene = loads_bearing(WAVY, smooth)
    tracks = smooth_tracks(scene.geometry)
    if body == "balls":
        on_inner = (pitted(tracks.balls_on_inner[0]), *tracks.balls_on_inner[1:])
        on_outer = (pitted(tracks.balls_on_outer[0]), *tracks.balls_on_outer[1:])
        tracks = replace(tracks, balls_on_inner=on_inner, balls_on_outer=on_outer)
    else:
        tracks = replace(tracks, **{body: pitted(getattr(tracks, body))})
    record = record_of(move_ring(scene.model, tracks, seconds, RATE), scene.kinematics)
    faulty = envelope_lines(solved(scene, record, tracks))
    heights = {line.name: line.height for line in faulty}
    times = "" if radial_n else "2 "
    sides = {"inner": ("BPFI", "turn"), "balls": ("2 x ball spin", "cage")}
    names = [lines.FAULT_LINES[body]]
    if body in sides:
        line, turn = sides[body]
        names += [f"{line} - {times}{turn}", f"{line} + {times}{turn}"]
    for name in names:
        assert heights[name] > 10, name


@pytest.mark.law("Bearing faults: what a fault adds is told against the same bearing without it.")
def test_a_bearing_with_a_fault_is_also_moved_without_it(tmp_path: Path) -> None:
    """A step enters by its form, so it needs no march."""
    step = {"kind": "step", "at_mm": [10, 0], "depth_um": 1, "size_um": 300}
    waves = {"kind": "smooth", "waviness": {9: 0.1}}
    short = ["sound.duration_s=0.2", "sound.listen_s=0.2"]
    healthy = rolling.simulate(
        loads_bearing(WAVY, [*short, f"bearing.surfaces.inner={json.dumps(waves)}"]), progress=False
    )
    faulty = rolling.simulate(
        loads_bearing(
            WAVY, [*short, f"bearing.surfaces.inner={json.dumps(waves | {'faults': [step]})}"]
        ),
        progress=False,
    )
    assert healthy.numbers.without_faults is None
    without = faulty.numbers.without_faults
    assert without is not None
    own = healthy.numbers.velocities
    for values, velocities in ((without.radial, own.radial), (without.axial, own.axial)):
        assert values.by_band == pytest.approx(velocities.um_s, rel=1e-6, abs=1e-6)
    assert faulty.numbers.velocities.radial.high.value > 2 * without.radial.high
    (said,) = [text for text in faulty.numbers.sentences if "fault of" in text]
    assert "shows in the envelope of 300 to 5,150 Hz at BPFI" in said
    assert "times its surroundings; without the fault" in said
    opened = rolling.open_run(rolling.save_run(faulty, tmp_path / "run", report=False))
    assert opened.numbers.without_faults == without


@pytest.mark.parametrize(
    ("overrides", "named"),
    [
        (["bearing.axial_load_n=80"], "bearing.axial_load_n"),
        (["bearing.ring_mass_kg=0.05", "bearing.speed_rpm=900"], "bearing.speed_rpm"),
        (["bearing.ring_mass_kg=0.05", "sound.duration_s=0.5"], None),
    ],
)
def test_resound_names_the_key_with_which_rough_contacts_are_others(
    overrides: list[str], named: str | None
) -> None:
    """Contacts that are planned for a rough bearing are known without a march.

    A film that parts the surfaces leaves nothing to march, so the bearing is dry.
    """
    before = rolling.read_scene("bearing-6204", ["bearing.oil="])
    scene = kind_of(before).resound(before, overrides)
    if named is None:
        refuse_other_contacts(before, scene, overrides)
        return
    with pytest.raises(rolling.SceneError, match="needs a new run") as caught:
        refuse_other_contacts(before, scene, overrides)
    (mistake,) = caught.value.mistakes
    assert mistake.startswith(f"--set: {named}: ")


@pytest.mark.law("Bearing run: an elastic ring in oil is stored and opened as it moved.")
def test_an_elastic_ring_in_oil_is_kept(tmp_path: Path) -> None:
    """Bending and turns stand in the record, the sensor sees its place, and the film is told."""
    changes = {
        "bearing.angle": "moving",
        "bearing.ring": "elastic",
        "bearing.tilt": "free",
        "bearing.sensor_deg": 90,
        "bearing.oil": {"viscosity_40_mm2_s": 32, "roughness_rq_um": 0.05},
    }
    scene = loads_bearing(WAVY, ["sound.duration_s=0.1", "sound.listen_s=0.1"]).with_(changes)
    made = rolling.simulate(scene, progress=False)
    assert made.record.velocity_m_s.shape[1] == 9
    made.save(tmp_path / "kept")
    opened = rolling.open_run(tmp_path / "kept")
    np.testing.assert_array_equal(opened.record.radial_columns, [0, 1, 3, 4, 5, 6])
    seen = made.record.seen_velocity_m_s
    rounding = 1e-6 * np.abs(seen).max()
    np.testing.assert_allclose(opened.record.seen_velocity_m_s, seen, atol=rounding)
    assert "".join(opened.to_xarray()["axis"].astype(str).values) == "xyzabcduv"
    numbers = opened.numbers
    assert numbers == replace(made.numbers, effort=numbers.effort)  # the page took its time
    assert len(numbers.ring.resonances_hz) == 9
    assert numbers.ring.left_out_hz == pytest.approx(11557, rel=1e-3)
    assert "(1,800 to 10,000 Hz)" in numbers.sentences[0] and " dB (" in numbers.sentences[0]
    assert any("at the sensor, 90 degrees from the load" in text for text in numbers.sentences)
    ratios = [film.ratio for film in numbers.films]
    assert min(ratios) > 3 and "It parts the surfaces." in numbers.sentences[-1]
    parts = numbers.velocities.radial.high.parts
    assert "film_damping" in parts and "loss_factor" not in parts
    assert page_of([opened])


@pytest.mark.law("Bearing run: the velocity below the bending of the ring leads.")
def test_the_velocity_below_the_bending_leads(run: BearingRun) -> None:
    """A 6204 bends from 5.7 kHz on; tones at 3 and 8 kHz lie on either side of it."""
    t = np.arange(RATE) / RATE
    tones = 3 * np.sin(2 * np.pi * 3000 * t) + 20 * np.sin(2 * np.pi * 8000 * t)
    velocity = 1e-5 * np.repeat(tones[:, None], 3, axis=1)
    rigid = moved_as(run, replace(run.record, velocity_m_s=velocity))
    below = 30 / math.sqrt(2)
    assert rigid.numbers.below_bending.radial.high.value == pytest.approx(below, rel=1e-3)
    assert rigid.numbers.velocities.radial.high.value == pytest.approx(143, rel=0.01)
    first, _, bends, *_ = rigid.numbers.sentences
    assert "21 um/s ± 0.1 dB (1,800 to 5,698 Hz, where it begins to bend)" in first
    assert "143" not in first
    assert "bends from 5.7 kHz on" in bends and "140 um/s radially" in bends
    shown = kind_of(rigid.scene).quantities(rigid.numbers)
    assert not [name for name in shown if "Hz" in name]  # bands of several runs may end elsewhere
    high = shown["Radial below the bending, high band"]
    assert high.meaning == "Velocity of the ring from 1,800 to 5,698 Hz, where it begins to bend"
    drawn = [text.get_text() for text in rigid.plot("spectrum").texts]
    assert "21 µm/s" in drawn
    plt.close("all")
    stiff = rigid.scene.with_({"bearing.outside_diameter_mm": 80})
    stiff_run = moved_as(rigid, rigid.record, stiff)
    assert "bend" not in " ".join(stiff_run.numbers.sentences)
    assert "(1,800 to 10,000 Hz)" in stiff_run.numbers.sentences[0]
    thin = rigid.scene.with_({"bearing.outside_diameter_mm": 41.6, "bearing.density_kg_m3": 19000})
    thin_run = moved_as(rigid, rigid.record, thin)
    first, second, bends, *_ = thin_run.numbers.sentences
    assert thin.ring_bending_hz < 1800
    assert "(1,800" not in first and "where it begins to bend), rms" in first
    assert second.count("um/s") == 2  # bands below the bending
    assert "140 um/s radially" in bends
    doubts = {doubt.key: doubt for doubt in thin_run.numbers.doubts}
    assert doubts["ring_bending"].text.endswith("all of the high band lies above")
    assert page_of([thin_run])
    # Of two runs each velocity stands among the bars of its band, also where a band has none.
    two = page_of([replace(rigid, label="thick"), replace(thin_run, label="thin")]).decode()
    bars = re.findall(r'<figure class="bars">.*?</figure>', two, flags=re.DOTALL)
    high_band = next(figure for figure in bars if "1,800 to 10,000 Hz" in figure)
    values = re.findall(r'<dt>(\w+)</dt>\s*<dd class="value"><b>([^<]*)</b>', high_band)
    assert values == [("thick", "21"), ("thin", "-")]


def test_velocities_below_the_bending_are_tabulated(folder: Path, tmp_path: Path) -> None:
    """A velocity that is not known, and one above the bending, have a dash."""
    other = tmp_path / "other"
    shutil.copytree(folder, other)
    whole = stored(other)
    rigid = with_values(whole.numbers.velocities.radial, low=81.0, medium=7.0, high=400.0)
    below = with_values(whole.numbers.below_bending.radial, low=81.0, medium=7.0, high=61.0)
    assert shown_bands(other, whole, rigid, below) == ["81", "7", "61", "400"]
    unknown = with_values(below, high=None)
    assert shown_bands(other, whole, rigid, unknown) == ["81", "7", "-", "400"]
    thin = replace(whole.numbers, ring=replace(whole.numbers.ring, bending_hz=1800.0))
    bent = replace(whole, numbers=thin)
    assert shown_bands(other, bent, rigid, below) == ["81", "7", "-", "400"]


def with_values(bands: BandVelocities, **um_s: float | None) -> BandVelocities:
    """Return velocities with other values [um/s]."""
    changed = {name: replace(bands.by_band[name], value=value) for name, value in um_s.items()}
    return replace(bands, **changed)


def shown_bands(
    folder: Path,
    whole: StoredBearing,
    rigid: BandVelocities,
    below: BandVelocities,
) -> list[str]:
    """Store other radial velocities in a folder, and return the row of its table."""
    numbers = replace(
        whole.numbers,
        velocities=replace(whole.numbers.velocities, radial=rigid),
        below_bending=replace(whole.numbers.below_bending, radial=below),
    )
    write_stored(folder, replace(whole, numbers=numbers))
    return band_table(folders.stored_runs(folder)).splitlines()[1].split()


@pytest.mark.law("Bearing ±: one number has one ±, the root of the squares of its parts.")
def test_a_velocity_has_the_parts_of_its_uncertainty(run: BearingRun, folder: Path) -> None:
    """Waves on smooth raceways have no window; the loss factor is assumed."""
    numbers = stored(folder).numbers
    assert numbers.velocities == run.numbers.velocities
    table = pd.read_csv(folder / "runs.csv").iloc[0]
    for direction, bands in numbers.velocities.by_direction.items():
        for band, velocity in bands.by_band.items():
            assert set(velocity.parts) == {"record", "loss_factor"}
            squares = [part**2 for part in velocity.parts.values()]
            assert velocity.uncertainty == pytest.approx(math.sqrt(sum(squares)))
            assert velocity.unit_of_uncertainty == "dB"
            shown = table[f"velocities_{direction}_{band}_uncertainty_db"]
            assert shown == pytest.approx(velocity.uncertainty, rel=1e-6)
    window = {direction: dict.fromkeys(VELOCITY_BANDS_HZ, 1.7) for direction in DIRECTIONS}
    rough = numbered(run, MarchFindings(uncertainty=BandUncertainty({"window": window}))).numbers
    assert rough.velocities.radial.high.uncertainty >= 1.7
    assert rough.velocities.radial.high.verdict == "indicative"
    given = moved_as(run, run.record, run.scene.with_({"bearing.contact_loss_factor": 0.03}))
    assert set(given.numbers.velocities.radial.high.parts) == {"record"}


def test_a_velocity_prints_its_uncertainty_in_decibels(run: BearingRun) -> None:
    """Its value has two digits, and its ± another unit."""
    velocity = replace(run.numbers.below_bending.radial.low, value=81.234, uncertainty=0.04)
    assert str(velocity) == "81 um/s ± 0.1 dB, computed"
    assert "81 um/s ± 0.1 dB" in velocity._repr_html_()


def test_the_summary_shows_the_numbers_by_subject(folder: Path) -> None:
    shown = json.loads((folder / "summary.json").read_text())
    assert shown["format"] == 2 and shown["kind"] == "bearing"
    low = shown["below_bending"]["radial"]["low"]
    velocity = stored(folder).numbers.below_bending.radial.low
    assert low["value"] == float(f"{velocity.value:.6g}")
    assert low["verdict"]["word"] == velocity.verdict
    assert (low["unit"], low["uncertainty_unit"]) == ("um/s", "dB")


def test_former_names_warn_and_have_the_same_values(run: BearingRun) -> None:
    with pytest.warns(DeprecationWarning, match=r"BearingRun\.numbers"):
        former = run.summary
    numbers = run.numbers
    assert former["bands_um_s"]["radial"] == numbers.velocities.radial.um_s
    assert former["bands_verdict"]["axial"]["low"] == numbers.velocities.axial.low.verdict
    parts = former["bands_uncertainty_parts_db"]
    assert parts["record"]["axial"]["high"] == numbers.velocities.axial.high.parts["record"]
    assert former["lines"][0]["radial_um_s"] == numbers.lines[0].radial.um_s
    assert [doubt["key"] for doubt in former["doubts"]] == [one.key for one in numbers.doubts]
    with pytest.raises(TypeError):
        former["name"] = "other"


def test_a_smooth_bearing_under_an_axial_load_is_silent() -> None:
    scene = loads_bearing(WAVY, ["bearing.surfaces={}"])
    quiet = rolling.simulate(scene, progress=False)
    velocities = quiet.numbers.velocities.by_direction.values()
    assert max(max(bands.um_s.values()) for bands in velocities) < 1e-3


def test_the_outer_ring_may_turn() -> None:
    """The inner ring moves then, at the same rates of contact."""
    scene = loads_bearing(WAVY, ["bearing.turning=outer"])
    run = rolling.simulate(scene, progress=False)
    assert run.moving == "inner" and run.numbers.departures
    assert run.numbers.velocities.axial.low.value > 50


def test_a_radial_load_alone_has_a_load_zone_and_varying_compliance() -> None:
    """Clearance is open, so balls outside the zone bear nothing, and the ring moves at Z f_c."""
    words = ["bearing.axial_load_n=0", "bearing.radial_load_n=200", "bearing.surfaces={}"]
    run = rolling.simulate(loads_bearing(WAVY, words), progress=False)
    assert run.record.ball_load_n.min() == 0 < run.record.lost_contact_share
    around = bearing_figures.mean_loads_n(run)
    assert around[0] == np.nanmax(around) and around[len(around) // 2] == 0
    peak = max(run.numbers.lines, key=lambda line: line.radial.um_s)
    assert peak.frequency_hz == pytest.approx(8 * run.kinematics.cage_hz)
    assert any("varying compliance" in text for text in run.numbers.sentences)


def test_a_bearing_that_hardly_turns_has_few_lines_and_all_figures() -> None:
    """Its lines are closer than a record of 0.2 s can tell apart, and would name every peak."""
    text = WAVY.replace("0.5", "0.2").replace("1800", "0.01")
    run = rolling.simulate(loads_bearing(text), progress=False)
    assert len(run.numbers.lines) < 100
    found = lines.family_lines(run.model, wavy=lines.BODIES, faulty=(), highest_hz=1800.0)
    assert len(found) < 10_000
    for name in ("spectrum", "envelope", "load_distribution", "ball_forces"):
        assert run.plot(name).lines
    plt.close("all")


def test_the_page_of_former_names_leads_to_numbers_of_a_bearing(run: BearingRun) -> None:
    """Groups that this bearing lacks end at their name."""
    page = Path(rolling.__file__).parents[1] / "docs" / "former-names.md"
    section = page.read_text(encoding="utf-8").partition("\n## Bearings\n")[2]
    places = re.findall(r"`run\.numbers\.([\w.]+)`", section)
    assert len(places) > 20
    for place in places:
        if not place.startswith(("housing.", "without_faults.")):
            named = place.replace("DIRECTION", "axial").replace("BAND", "high")
            attrgetter(named)(run.numbers)


# ---- files


def samples_of(path: Path) -> Array:
    values, rate = soundfile.read(path)
    assert rate == RATE
    return values


def test_a_run_leaves_its_files(folder: Path) -> None:
    names = {path.name for path in folder.iterdir()}
    assert names == FILES | {"scene.yaml", "runs.csv", "report.html", "figures"}
    assert {path.stem for path in (folder / "figures").iterdir()} == {
        *("spectrum", "envelope", "load_distribution", "ball_forces")
    }
    assert stored(folder).numbers.motion.duration_s == 0.5
    table = pd.read_csv(folder / "lines.csv")
    assert "inner 9" in set(table["name"])
    spectrum = pd.read_csv(folder / "spectrum.csv")
    top = spectrum.loc[spectrum["radial_um_s"].idxmax(), "frequency_hz"]
    assert top == pytest.approx(177.8, abs=2)


def test_sounds_are_acceleration_and_its_scaled_copy(folder: Path, run: BearingRun) -> None:
    """Fades at the ends take 50 ms each."""
    acceleration = samples_of(folder / "acceleration.wav")
    inside = slice(RATE // 10, -RATE // 10)
    wanted = run.record.acceleration_m_s2[:, 0]
    assert len(acceleration) == RATE // 2
    assert acceleration[inside] == pytest.approx(wanted[inside], abs=2e-3 * np.abs(wanted).max())
    scale = stored(folder).files.listen.full_scale
    heard = samples_of(folder / "listen.wav")
    assert scale * heard == pytest.approx(acceleration, abs=1e-6 * scale)


def test_a_stored_run_is_the_run(folder: Path, run: BearingRun, tmp_path: Path) -> None:
    """Numbers are stored unrounded, and arrays in single precision."""
    opened = rolling.open_run(folder)
    assert replace(opened.numbers, effort=run.numbers.effort) == run.numbers
    track = opened.tracks.inner.at_loads(run.tracks.inner.loads_n)
    assert track == pytest.approx(run.tracks.inner.approach_m, abs=1e-13)
    tree = opened.to_xarray()
    assert tree.velocity.attrs["units"] == "m/s" and tree.velocity.dims == ("time", "axis")
    again = rolling.save_run(opened, tmp_path / "again", report=False)
    assert stored(again).numbers.velocities == opened.numbers.velocities
    assert stored_arrays(again / "result.h5") == stored_arrays(folder / "result.h5")


# ---- terminal


def test_the_answer_comes_first(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A run that is done is not done again."""
    before = (folder / "result.h5").stat().st_mtime_ns
    scene = written(folder.parent)
    assert cli.main(["run", str(scene), "--out", str(folder)]) == 0
    assert (folder / "result.h5").stat().st_mtime_ns == before
    printed = capsys.readouterr().out
    answer = " ".join(printed.split())
    said = "Bearing 6204 at 1800 rpm under 70 N axial: the outer ring vibrates radially at 81 um/s"
    assert said in answer
    assert answer.index(said) < answer.index("listen: ")
    assert str(folder / "report.html") in printed


def test_commands_on_a_stored_bearing(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"
    assert cli.main(["report", str(folder), "--out", str(page)]) == 0
    assert page.read_text().startswith("<!DOCTYPE html>")
    assert cli.main(["status", str(folder)]) == 0
    assert "1 done" in capsys.readouterr().out
    assert cli.main(["listen", str(folder), "--seconds", "1"]) == 0
    assert len(samples_of(folder / "long.wav")) == RATE
    (folder / "long.wav").unlink()
    assert cli.main(["listen", str(folder), "--speed", "1"]) == 2
    assert cli.main(["listen", str(folder), "--reverberation", "1"]) == 2
    assert "acceleration of its ring, which no room carries" in capsys.readouterr().err


def test_texts_of_the_spectrum_stay_in_its_axes() -> None:
    """Modes that an elastic ring leaves out begin near the end of the axis."""
    words = ["bearing.ring=elastic", "sound.duration_s=0.1", "sound.listen_s=0.1"]
    figure = Figure((6.2, 4.2))
    run = rolling.simulate(loads_bearing(WAVY, words), progress=False)
    ax = rolling.plot.spectrum(run, figure.subplots())
    figure.draw_without_rendering()
    assert "modes left out" in [text.get_text() for text in ax.get_legend().get_texts()]
    for text in (*ax.texts, *ax.get_legend().get_texts()):
        box = text.get_window_extent()
        assert box.x0 >= -2 and box.x1 <= figure.bbox.x1 + 2
    for text in ax.texts:
        assert text.get_window_extent().x1 <= ax.bbox.x1 + 2


def test_a_sweep_has_a_row_for_each_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = written(tmp_path, SWEPT)
    out = tmp_path / "out"
    words = ["run", str(scene), "--out", str(out), "--no-report", "--set", "sound.duration_s=0.05"]
    assert cli.main([*words, "--set", "sweep={bearing.axial_load_n: [65, 75]}"]) == 0
    assert cli.main(words) == 0  # adds the third run
    assert len(pd.read_csv(out / "runs.csv")) == 3
    places = [path.parent for path in out.glob("*/numbers.json")]
    scales = {stored(place).files.listen.full_scale for place in places}
    assert len(scales) == 1
    capsys.readouterr()
    assert cli.main(["table", str(out)]) == 0
    assert "75 N" in capsys.readouterr().out
    first = next(path.parent for path in out.glob("*/summary.json"))
    assert rolling.open_run(first).scene.bearing.axial_load_n == 65
    with pytest.raises(rolling.FolderError, match="holds 3 runs"):
        rolling.open_run(out)


@pytest.mark.slow
def test_housings_of_a_sweep_share_their_gain(tmp_path: Path) -> None:
    """Their comments name the same full scale, and the levels are in the table."""
    out = tmp_path / "out"
    words = ["run", str(written(tmp_path, SWEPT + PLATE)), "--out", str(out), "--no-report", "-q"]
    assert cli.main(words) == 0
    comments = [wav.read(path)[2] for path in out.glob("*/housing.wav")]
    scales = {comment[comment.index("full scale is") :] for comment in comments}
    assert len(comments) == 3 and len(scales) == 1
    table = pd.read_csv(out / "runs.csv")
    assert table["housing_laeq_db"].notna().all()
    assert table.shape[1] <= 45  # that a person reads


# ---- bad folders


def test_bad_folders_are_refused(folder: Path, tmp_path: Path, capsys) -> None:
    scene = written(tmp_path)
    other = ["run", str(scene), "--out", str(folder), "--set", "bearing.speed_rpm=900", "-q"]
    assert cli.main(other) == 2
    assert "bearing.speed_rpm: got 900, has 1800" in capsys.readouterr().err
    assert cli.main(["run", "quickstart", "--out", str(folder), "-q"]) == 2
    strange = tmp_path / "strange"
    strange.mkdir()
    (strange / "letter.txt").write_text("dear")
    assert cli.main(["run", str(scene), "--out", str(strange), "-q"]) == 2
    assert {path.name for path in strange.iterdir()} == {"letter.txt"}
    with pytest.raises(rolling.FolderError, match="no run folder"):
        rolling.open_run(strange)
    assert cli.main(["run", str(scene), "--out", str(tmp_path / "new"), "--part", "1/2"]) == 2
    assert not (tmp_path / "new").exists()


def test_nothing_is_written_for_a_scene_that_cannot_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = "bearing.surfaces.inner={kind: file, path: no.csv, height_unit: um, spacing_um: 2}"
    huge = "numerics={spacing_um: 0.01, window_mm: 100}"
    rough = "bearing.surfaces.balls={kind: graded, grade: G10, seed: 1}"
    for words in (["--set", missing], ["--set", rough, "--set", huge]):
        out = tmp_path / "out"
        assert cli.main(["run", str(written(tmp_path)), "--out", str(out), *words]) == 2
        assert capsys.readouterr().err.splitlines()[-1]
        assert not out.exists()


@pytest.mark.parametrize("name", ["result.h5", "numbers.json"])
def test_a_damaged_file_is_named(name: str, run: BearingRun, tmp_path: Path) -> None:
    folder = rolling.save_run(run, tmp_path / "own", report=False)
    content = (folder / name).read_bytes()
    (folder / name).write_bytes(content[: len(content) // 2])
    with pytest.raises(rolling.FolderError, match=name):
        rolling.open_run(folder)
