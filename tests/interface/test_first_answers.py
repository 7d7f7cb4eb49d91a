"""A run says its first answer after a pilot: a number with a wide ±, a sound, a page."""

from __future__ import annotations

import math
from collections.abc import Hashable
from concurrent.futures import Future
from pathlib import Path
from typing import Any, ClassVar

import pytest

import rolling as rc
from rolling import figures
from rolling.ball_kinds import pilot_track
from rolling.bearing_kind.contact_marches import march_contacts
from rolling.commands import derived
from rolling.commands import run as commands
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import LISTEN, PAGE, RunFolder
from rolling.marches.piece import contact_identity
from rolling.numbers.bearing_numbers import BandVelocities
from rolling.report import report_page
from rolling.results.run_result import Run
from rolling.results.stored_numbers import read_stored
from rolling.run import folder as folders
from rolling.run import pilots, solving
from rolling.run.pools import Pool, Task
from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.terminal import progress
from tests.support.bearing_runs import WAVY, loads_bearing

TEXT = """\
name: first
sphere: {radius_mm: 2}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.5}
surface: {kind: gaussian, roughness_ra_um: 0.08, correlation_length_um: 11, \
spacing_um: 1.5, width_um: 192, seed: 77}
rolling: {load_n: 4, speed_m_s: 0.2, distance_mm: 0.6}
sound: {listen_s: 0.2}
sweep: {rolling.load_n: [2, 4]}
"""


def scene_of(*overrides: str) -> Scene:
    return loads(TEXT, overrides)


@pytest.fixture
def short_pilots(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let pilots be so short that a run takes a moment."""
    monkeypatch.setattr(pilot_track, "STEPS", 40)
    monkeypatch.setattr(pilot_track, "CONTACT_LENGTHS", 1)


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the lines that are said."""
    lines: list[str] = []
    monkeypatch.setattr(progress, "line", lines.append)
    return lines


# ---- which runs have a pilot


def test_a_pilot_is_a_short_closed_track_of_its_own() -> None:
    ((_, run),) = rc.read_scene("quickstart", ["sweep="]).runs()
    pilot = pilot_track.pilot_of(run)
    assert pilot is not None and pilot.scene.track.closed
    assert pilot_track.STEPS <= pilot.scene.track.steps <= run.track.steps / 5
    assert pilot.words == f"{pilot.scene.track.steps:,} steps"
    assert pilot.scene.load == run.load and pilot.scene.step == run.step
    assert not pilot.scene.numerics.error_estimate and pilot.scene.sound.listen_s is None


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("quickstart", ["sweep=", "rolling.duration_s=0.05"]),
        ("marble-dropped", []),
        ("measured-scan", []),
        ("accelerating", []),
        ("ball-with-pit", []),
        ("bearing-grades", ["sweep=", "rolling.distance_mm=400"]),
    ],
    ids=["short", "fall", "file", "speed", "faults", "turns"],
)
def test_a_run_that_is_short_or_has_nothing_like_it_has_no_pilot(
    name: str, overrides: list[str]
) -> None:
    _, run = rc.read_scene(name, overrides).runs()[0]
    assert pilot_track.pilot_of(run) is None


# ---- what a command says and writes


@pytest.mark.usefixtures("short_pilots")
def test_first_answers_stand_before_the_whole_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: list[str]
) -> None:
    folder = tmp_path / "run"
    seen: list[tuple[bytes, list[bool], list[bool]]] = []
    written = derived.write_first_page

    def write_first_page(*arguments: object) -> str:
        """Write the page, and note what the folder holds by then."""
        path = written(*arguments)  # type: ignore[arg-type]
        runs = folders.stored_runs(folder)
        sounds = [(run.folder / LISTEN).is_file() for run in runs]
        seen.append(((folder / PAGE).read_bytes(), [run.is_done for run in runs], sounds))
        return path

    def page_of(runs: list[Run], unsolved: object = (), notice: str = "") -> bytes:
        """Return a page that is soon drawn."""
        return f"{len(runs)} runs: {notice}".encode()

    monkeypatch.setattr(report_page, "page", page_of)
    monkeypatch.setattr(figures, "has_written_figures", lambda runs: False)
    monkeypatch.setattr(commands, "write_first_page", write_first_page)
    assert not commands.run_scene(scene_of(), folder, workers=1)
    ((page, done, sounds),) = seen
    assert done == [False, False] and sounds == [True, True]
    assert page.decode() == f"2 runs: {pilots.NOTICE}"
    told = [line for line in said if "going on" in line]
    assert f"the first page, which the whole one will replace: {folder / PAGE}" in said
    assert len(told) == 2
    assert told[0].startswith("load 2 N: vibration ") and told[1].startswith("load 4 N: vib")
    assert all(
        " dB(A), estimated, after " in line and line.endswith(" steps; going on") for line in told
    )
    # The whole runs replace all of it.
    assert (folder / PAGE).read_bytes() == b"2 runs: "
    assert not (folder / folders.PIECES).exists()
    assert [run.is_done for run in folders.stored_runs(folder)] == [True, True]


@pytest.mark.usefixtures("short_pilots")
def test_a_pilot_is_no_part_of_the_run(tmp_path: Path) -> None:
    scene = scene_of("sweep=")
    folder = tmp_path / "run"
    assert not commands.run_scene(scene, folder, workers=1, report=False)
    stored = rc.open_run(folder)
    alone = rc.simulate(scene, workers=1, progress=False)
    assert stored.vibration == alone.vibration
    assert (stored.series["release_energy"] == alone.series["release_energy"]).all()
    assert b"Wait for the whole run." in report_page.page([alone], notice="Wait for the whole run.")


@pytest.mark.usefixtures("short_pilots")
def test_an_interrupted_command_keeps_its_first_answers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: list[str]
) -> None:
    folder = tmp_path / "run"

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    told = solving.Pilots.tell

    def tell_and_stop(self: pilots.Pilots, pilot: pilots.PilotRun) -> None:
        """Say what a pilot found, and stop after the last one as by Ctrl-C."""
        told(self, pilot)
        if self.are_told:
            interrupt()

    monkeypatch.setattr(solving.Pilots, "tell", tell_and_stop)
    with pytest.raises(KeyboardInterrupt):
        commands.run_scene(scene_of(), folder, workers=1)
    assert [run.is_done for run in folders.stored_runs(folder)] == [False, False]
    assert (folder / "load_n=2" / LISTEN).is_file()
    said.clear()
    assert not commands.run_scene(scene_of(), folder, workers=1, report=False)
    assert "going on" not in "".join(said)  # they are known
    assert [run.is_done for run in folders.stored_runs(folder)] == [True, True]


@pytest.mark.usefixtures("short_pilots")
def test_a_pilot_without_a_solution_does_not_stop_its_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pilot_of = pilot_track.pilot_of

    def overloaded(scene: Scene) -> object:
        """Return the pilot with a load that its surface does not bear."""
        pilot = pilot_of(scene)
        assert pilot is not None
        return pilot._replace(scene=pilot.scene.with_(load_n=1e7))

    monkeypatch.setattr("rolling.ball_kinds.rolling_ball.pilot_of", overloaded)
    folder = tmp_path / "run"
    assert not commands.run_scene(scene_of("sweep="), folder, workers=1, report=False)
    assert rc.open_run(folder).vibration.value is not None


@pytest.mark.usefixtures("short_pilots")
def test_marches_that_are_there_need_no_pilot(tmp_path: Path, said: list[str]) -> None:
    """A new sound of stored marches is the answer itself."""
    folder = tmp_path / "run"
    assert not commands.run_scene(scene_of("sweep="), folder, workers=1, report=False)
    assert any(line.endswith("; going on") for line in said)
    said.clear()
    out = tmp_path / "farther"
    assert not commands.resound(folder, ["sound.distance_m=2"], out, workers=1, report=False)
    assert not any(line.endswith("; going on") for line in said)


# ---- bearings

BEARING = """\
name: small
bearing:
  named: "6204"
  speed_rpm: 1800
  axial_load_n: 10
  contact_angle_deg: 12
  radial_clearance_um: null
  surfaces:
    inner: {kind: gaussian, roughness_ra_um: 0.01, correlation_length_um: 40, seed: 2}
    outer: {kind: smooth, waviness: {8: 0.05}}
numerics: {window_mm: 1.5, spacing_um: 8}
sound: {duration_s: 0.2, listen_s: 0.2}
"""


@pytest.fixture
def stopping(monkeypatch: pytest.MonkeyPatch) -> list[list[Path]]:
    """Stop a command after its first answer as by Ctrl-C; return the marches that are done then."""
    marched: list[list[Path]] = []
    told = pilots.Pilots.tell

    def tell_and_stop(self: pilots.Pilots, pilot: pilots.PilotRun) -> None:
        told(self, pilot)
        marched.append([*pilot.run.home.rglob("*.npz")])
        raise KeyboardInterrupt

    monkeypatch.setattr(solving.Pilots, "tell", tell_and_stop)
    return marched


class TwoProcesses(Pool):
    """Pool of two teams, whose tasks are done when all their slots are full; it notes the tasks.

    It is stopped before the files of a run are written.
    """

    teams: ClassVar = {0: 1, 1: 1}
    slots = 2

    def __init__(self) -> None:
        super().__init__()
        self.tasks: list[str] = []

    def submit(self, task: Task, team: Hashable = 0) -> Future[Any]:
        if task.piece is None:
            raise KeyboardInterrupt
        self.tasks.append(task.piece.scene.name)
        return super().submit(task, team)


def test_no_other_march_waits_in_a_process_that_a_first_answer_needs(
    tmp_path: Path, said: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The answer follows its own marches at once, though both processes have a free slot before."""
    pool = TwoProcesses()
    monkeypatch.setattr(solving, "local_pool", lambda workers, scenes: pool)
    pit = "{kind: pit, at_mm: [2, 0], size_um: 200, depth_um: 5}"
    scene = loads_bearing(BEARING.replace("{8: 0.05}}", f"{{8: 0.05}}, faults: [{pit}]}}"))
    with pytest.raises(KeyboardInterrupt):
        commands.run_scene(scene, tmp_path / "out", workers=2, report=False)
    assert sorted(pool.tasks) == ["outer-beside-pit", "outer-pit"]


class BusyPool(TwoProcesses):
    """Pool that is stopped while the files of a run are being written; it notes later marches."""

    def submit(self, task: Task, team: Hashable = 0) -> Future[Any]:
        if task.piece is None:
            self.tasks.append("files")
            return Future()
        return super().submit(task, team)

    def poll(self) -> None:
        if "files" in self.tasks:
            raise KeyboardInterrupt


@pytest.mark.parametrize(("processes", "is_held"), [(1, True), (2, True), (3, False)])
def test_two_processes_begin_other_marches_after_the_first_answer(
    processes: int, is_held: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One makes the answer, which the other one would slow down."""
    pool = BusyPool()
    pool.teams = dict.fromkeys(range(processes), 1)
    monkeypatch.setattr(solving, "local_pool", lambda workers, scenes: pool)
    pit = "{kind: pit, at_mm: [2, 0], size_um: 200, depth_um: 5}"
    scene = loads_bearing(BEARING.replace("{8: 0.05}}", f"{{8: 0.05}}, faults: [{pit}]}}"))
    with pytest.raises(KeyboardInterrupt):
        commands.run_scene(scene, tmp_path / "out", workers=2, report=False)
    assert (pool.tasks[-1] == "files") == is_held


def test_a_bearing_answers_before_its_contacts_are_marched(
    tmp_path: Path, said: list[str], stopping: list[list[Path]], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = loads_bearing(BEARING)
    kind = kind_of(scene)
    pilot = kind.pilot(scene)
    assert pilot is not None and not pilot.marches
    assert len(kind.marches(scene)) > 1
    assert kind.pilot(loads_bearing(WAVY)) is None
    folder = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        commands.run_scene(scene, folder, workers=1, report=False)
    assert stopping == [[]]
    (told,) = [line for line in said if line.endswith("; going on")]
    for words in (
        "radially ",
        " dB (50 to 300 Hz), ",
        " dB (300 to 1,800 Hz) and ",
        " dB (1,800 to ",
        ", after 0.2 s of motion over contacts that are linear",
    ):
        assert words in told.replace("\n  ", " ")
    assert f"the first sound: {folder / LISTEN}" in said
    # What a command leaves that was stopped is marked as a first answer.
    marked = (folder / folders.FIRST_ANSWER).read_text()
    assert marked.startswith("A first answer, which the whole run will replace: radially ")
    assert "1 of them with a first answer" in folders.status(folder)
    assert not folders.stored_runs(folder)[0].is_done
    (place,) = (folder / folders.PIECES / pilots.FIRST).glob("**/summary.json")
    first = read_stored(place.parent).numbers.below_bending.radial
    # The whole run replaces it, and differs from it by less than its ±.
    monkeypatch.undo()
    assert not commands.run_scene(scene, folder, workers=1, report=False)
    assert not (folder / folders.FIRST_ANSWER).exists()
    whole = rc.open_run(folder).numbers.below_bending.radial
    for band, quantity in whole.by_band.items():
        assert "linear" not in quantity.parts
        assert "linear" in first.by_band[band].parts
        assert abs(difference_db(first, whole, band)) < first.by_band[band].uncertainty


def difference_db(first: BandVelocities, whole: BandVelocities, band: str) -> float:
    """Return the velocity of a band in a first answer over that of the whole run [dB]."""
    values = first.by_band[band].value, whole.by_band[band].value
    assert values[0] is not None and values[1] is not None
    return 20 * math.log10(values[0] / values[1])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bearing-6204", "bearing-inner-fault", "bearing-in-oil"])
def test_first_answers_of_the_library_hold_within_their_uncertainty(name: str) -> None:
    """What both share, such as assumed surfaces, is left out of the ±."""
    scene = rc.read_scene(name, ["sound.duration_s=2", "sound.listen_s=2"])
    kind = kind_of(scene)
    pilot = kind.pilot(scene)
    assert pilot is not None
    marches = march_contacts([march.scene for march in kind.marches(scene)], name=name, workers=0)
    marched = [marches[contact_identity(march.scene)] for march in kind.marches(scene)]
    whole = kind.make_run(RunFolder({}, scene, Path()), "", marched)
    place = RunFolder({}, pilot.scene, Path())
    first = kind.make_run(place, "", marched[: len(pilot.marches)])
    for band, quantity in first.numbers.below_bending.radial.by_band.items():
        parts = [quantity.parts.get(source, 0.0) for source in ("record", "linear", "one_load")]
        decibels = difference_db(
            first.numbers.below_bending.radial, whole.numbers.below_bending.radial, band
        )
        assert abs(decibels) <= 2 * math.hypot(*parts)
