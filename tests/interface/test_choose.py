"""`rolling choose` and `rc.choose`: their files, what is kept, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import soundfile

import rolling as rc
from acoustics.pairs import FEWEST_PAIRS
from rolling import cli
from rolling.ball_kinds.ball_audition import BallAudition
from rolling.ball_kinds.ball_candidates import candidate, candidates_of
from rolling.choice import choosing
from rolling.results import listening
from rolling.terminal import progress

SCENE = """\
name: {name}
sphere: {{radius_mm: 3, material: steel-100cr6}}
plate: {{material: steel-100cr6, thickness_mm: {thickness}, contact_loss_factor: 0.01}}
surface: {{kind: gaussian, roughness_ra_um: {ra}, correlation_length_um: 12, spacing_um: 3, width_um: 192, seed: 1}}
rolling: {{load_n: 1, speed_m_s: 0.1, distance_mm: 1}}
dynamics: {{}}
{more}
"""  # noqa: E501


def write(folder: Path, name: str, ra: float = 0.2, thickness: float = 3, more: str = "") -> str:
    """Write a small scene, and return its path."""
    path = folder / f"{name}.yaml"
    path.write_text(SCENE.format(name=name, ra=ra, thickness=thickness, more=more))
    return str(path)


@pytest.fixture(scope="module")
def chosen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Choose between two finishes, in a folder that tests read."""
    folder = tmp_path_factory.mktemp("chosen")
    scenes = [write(folder, "ground", ra=0.2), write(folder, "lapped", ra=0.05)]
    out = folder / "out"
    words = ["--pairs", "2", "--out", str(out), "-q", "--workers", "1"]
    assert cli.main(["choose", *scenes, *words]) == 0
    return out


@pytest.mark.slow
def test_a_choice_leaves_its_answer_in_files(chosen: Path) -> None:
    stored = json.loads((chosen / "choice.json").read_text())
    assert stored["differences"][0]["pairs"] == 2
    labels = [one["label"] for one in stored["candidates"]]
    assert sorted(labels) == ["ground", "lapped"]
    for name in ("choice.html", "choice.csv", "choice.png", "ground.wav", "lapped.wav"):
        assert (chosen / name).is_file()
    page = (chosen / "choice.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    assert stored["sentences"][0].split(" (")[0].replace("&", "&amp;") in page


@pytest.mark.slow
def test_a_flat_scan_is_silent(tmp_path: Path) -> None:
    """Rounding errors of a contact without waves, at -240 dB, are no level that one compares."""
    np.save(tmp_path / "flat.npy", np.zeros((64, 64)))
    path = write(tmp_path, "ground", more="sweep: {surface.path: [flat.npy, rough.npy]}")
    np.save(tmp_path / "rough.npy", 1e-8 * np.random.default_rng(1).normal(size=(64, 64)))
    keys = "surface={kind: file, path: flat.npy, spacing_um: 3, level: none}"
    scene = rc.read_scene(path, ["rolling.distance_mm=", f"{keys}"])
    choice = rc.choose(scene, pairs=2, folder=tmp_path / "out", workers=1, progress=False)
    assert "flat makes no sound within hearing" in choice.sentences[0].lower()
    assert choice.differences[0].db is None


@pytest.mark.slow
def test_sounds_of_a_choice_have_one_gain(chosen: Path) -> None:
    gains = []
    for name in ("ground", "lapped"):
        with soundfile.SoundFile(chosen / f"{name}.wav") as file:
            gains.append(listening.gain_of_comment(file.comment).full_scale_per_pa)
    assert gains[0] == gains[1]


@pytest.mark.slow
def test_sounds_of_a_choice_go_on_beyond_the_track(chosen: Path) -> None:
    """A track of 10 ms that repeats is a buzz: each lap would be equal to the one before."""
    for name in ("ground", "lapped"):
        sound, rate = soundfile.read(chosen / f"{name}.wav")
        assert len(sound) == 5 * rate
        middle = sound[rate : 4 * rate]
        lap = round(0.01 * rate)
        same = float(middle[lap:] @ middle[:-lap] / (middle @ middle))
        assert abs(same) < 0.3


@pytest.mark.slow
def test_a_specimen_is_a_run(chosen: Path) -> None:
    run = rc.open_run(chosen / "runs" / "ground" / "02")
    assert run.scene.surface.seed == 2


@pytest.fixture
def without_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the loudness in the room, which takes most of the time of a small choice."""
    monkeypatch.setattr(BallAudition, "audible", lambda *_: ())


@pytest.mark.slow
@pytest.mark.usefixtures("without_room")
def test_the_same_command_solves_nothing_again(
    chosen: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("a march began")

    monkeypatch.setattr("rolling.choice.specimen_solving.RunLoop", refuse)
    scenes = [str(chosen.parent / f"{name}.yaml") for name in ("ground", "lapped")]
    before = (chosen / "runs" / "ground" / "01" / "result.h5").stat().st_mtime_ns
    assert cli.main(["choose", *scenes, "--pairs", "2", "--out", str(chosen), "-q"]) == 0
    assert (chosen / "runs" / "ground" / "01" / "result.h5").stat().st_mtime_ns == before


@pytest.mark.slow
@pytest.mark.usefixtures("without_room")
def test_an_interrupted_choice_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = [write(tmp_path, "ground"), write(tmp_path, "lapped", ra=0.05)]
    words = ["choose", *scenes, "--within", "9", "--out", str(tmp_path / "out"), "--workers", "1"]
    words += ["--set", "rolling.distance_mm=0.4"]
    finished = []
    hear = choosing.OpenChoice.hear

    def hear_some(
        self: choosing.OpenChoice, candidates: list, count: int, are_all: bool = True
    ) -> choosing.HeardPairs:
        if finished:
            raise KeyboardInterrupt
        finished.append(count)
        return hear(self, candidates, count, are_all)

    monkeypatch.setattr(choosing.OpenChoice, "hear", hear_some)
    assert cli.main(words) == 130
    kept = sorted((tmp_path / "out").glob("runs/*/*/heard.json"))
    assert len(kept) == 2 * FEWEST_PAIRS
    before = [path.stat().st_mtime_ns for path in kept]
    monkeypatch.setattr(choosing.OpenChoice, "hear", hear)
    assert cli.main(words) == 0
    assert [path.stat().st_mtime_ns for path in kept] == before
    assert len(sorted((tmp_path / "out").glob("runs/*/*/heard.json"))) == 12


def test_a_candidate_that_shares_the_contact_costs_no_march(tmp_path: Path) -> None:
    scene = rc.read_scene(write(tmp_path, "thin"))
    both = [candidate("thin", scene), candidate("thick", scene.with_(thickness_mm=9))]
    with choosing.open_choice(both, tmp_path / "out", workers=1) as work:
        (thin, thick), _ = work.hear(both, 1)
    times = [rc.open_run(one.specimens[0].folder).series["step_time"] for one in (thin, thick)]
    np.testing.assert_array_equal(times[0], times[1])  # of the same march
    assert thin.level_db != thick.level_db


@pytest.mark.slow
@pytest.mark.usefixtures("without_room")
def test_python_keeps_the_numbers_alone(tmp_path: Path) -> None:
    scene = rc.read_scene(write(tmp_path, "ground"))
    scenes = [scene, scene.with_(name="lapped", roughness_ra_um=0.05)]
    choice = rc.choose(scenes, pairs=2, workers=1, progress=False)
    assert choice.contenders[0].level_db <= choice.contenders[1].level_db
    frame = choice.table()
    assert frame["louder_db"][1] == pytest.approx(choice.differences[0].db)
    assert choice.plot().get_xlabel() == "frequency [Hz]"
    assert not choice.folder.exists()


# ---- refusals


@pytest.mark.parametrize(
    ("more", "other", "key"),
    [
        ("", "sound: {distance_m: 2}", "sound.distance_m"),
        ("", "sound: {room_db: {1000: 30}}", "sound.room_db"),
    ],
)
def test_other_listeners_are_refused_by_their_key(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: str, other: str, key: str
) -> None:
    scenes = [write(tmp_path, "one", more=more), write(tmp_path, "other", more=other)]
    assert cli.main(["choose", *scenes, "--out", str(tmp_path / "out")]) == 2
    assert key in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_short_records_of_other_lengths_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [write(tmp_path, "one"), "--set", "sweep={rolling.distance_mm: [1, 2]}"]
    assert cli.main(["choose", *words, "--out", str(tmp_path / "out")]) == 2
    assert "rolling.duration_s" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_one_scene_leaves_nothing_to_choose(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["choose", write(tmp_path, "one"), "--out", str(tmp_path / "out")]) == 2
    assert "nothing to choose between" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_choice_of_another_program_is_not_mixed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenes = [write(tmp_path, "ground"), write(tmp_path, "lapped", ra=0.05)]
    out = tmp_path / "out"
    out.mkdir()
    program = "version 0.0.1, sources 0"
    stored = {"format": choosing.FORMAT, "program": program, "sentences": []}
    (out / "choice.json").write_text(json.dumps(stored))
    assert cli.main(["choose", *scenes, "--out", str(out)]) == 2
    assert "version 0.0.1" in capsys.readouterr().err
    assert [path.name for path in out.iterdir()] == ["choice.json"]


@pytest.mark.slow
def test_damaged_numbers_are_named(tmp_path: Path, chosen: Path) -> None:
    from rolling.ball_kinds.ball_heard import read_heard
    from rolling.choice.heard_specimen import Specimen

    stored = rc.open_run(chosen / "runs" / "ground" / "01")
    one = candidate("ground", stored.scene)
    specimen = Specimen({}, stored.scene, tmp_path, candidate=one, number=0)
    (tmp_path / "heard.json").write_text('{"squares_pa2": [1]}')
    with pytest.raises(rc.FolderError, match=r"heard\.json"):
        read_heard(specimen)


def test_a_long_choice_says_how_long_its_first_marches_take(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A drop needs marches at many loads, and no answer comes before the first of them."""
    dropped = rc.read_scene("marble-dropped", ["sweep={rolling.drop_mm: [10, 20]}"])
    candidates = candidates_of([dropped])
    for expected in (True, False):  # a choice that goes on says nothing
        with (
            progress.begin(progress.Level.NORMAL),
            choosing.open_choice(candidates, tmp_path / "out", workers=1),
        ):
            pass
        said = capsys.readouterr()
        assert ("the marches of the first 4" in said.out + said.err) == expected
