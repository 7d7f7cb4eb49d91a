"""A choice goes on, ends and refuses by the same rules for scenes of every kind."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import rolling as rc
from acoustics.pairs import LOOKS
from rolling import cli
from rolling.ball_kinds.one_ball import OneBall
from rolling.bearing_kind import bearing_heard
from rolling.choice import choosing
from rolling.choice.audition import Audition
from rolling.choice.choice import Choice
from rolling.choice.choosing import choose_scenes
from rolling.run.budget import Budget, Clock
from rolling.terminal.whole_files import write_json
from tests.support.commands import tree
from tests.support.marched_specimens import stand_in

BALL = """\
name: smooth
sphere: {material: steel-100cr6, radius_mm: 5}
plate: {material: steel-s235, thickness_mm: 10}
surface: {kind: gaussian, seed: 1, roughness_ra_um: 0.1, correlation_length_um: 12, spacing_um: 4, width_um: 256}
rolling: {load_n: 0.3, speed_m_s: 0.1, distance_mm: 0.4}
dynamics: {}
"""  # noqa: E501
SMOOTH_BEARING = [
    "bearing.surfaces.balls={kind: smooth, waviness: {4: 0.02}}",
    "bearing.surfaces.inner=",
    "bearing.surfaces.outer=",
    "sound.duration_s=0.05",
    "bearing.tilt=held",  # without the slow rocking of the ring its run-in is a fifth as long
]
LOUDER = {
    "ball": {"surface.roughness_ra_um": 0.2},
    "bearing": {"bearing.surfaces.balls.waviness": {4: 0.03}},
}
OTHER = {
    "ball": {"rolling.speed_m_s": 0.2},
    "bearing": {"bearing.speed_rpm": 1700},
}


class Chosen(NamedTuple):
    """Two scenes of a kind, and where the heard specimens of a choice are counted."""

    scenes: Sequence[Any]
    heard: list[Any]
    out: Path

    def choose(self, pairs: int | None = 2) -> Choice:
        """Choose between both, with a ± that few pairs reach unless their number is given."""
        budget = Budget(within_db=3.0, pairs=pairs)
        return choose_scenes(self.scenes, self.out, budget, workers=1)


@pytest.fixture(params=["ball", "bearing"])
def chosen(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Chosen:
    """Return two scenes of a kind; the levels of balls are given, so that nothing is marched."""
    if request.param == "ball":
        (tmp_path / "smooth.yaml").write_text(BALL)
        scene = rc.read_scene(tmp_path / "smooth.yaml")
        heard = stand_in(monkeypatch)
    else:
        scene = rc.read_scene("bearing-6204", SMOOTH_BEARING)
        heard = _counted_rings(monkeypatch)
    louder = scene.with_({"name": "louder", **LOUDER[request.param]})
    return Chosen(scenes=[scene, louder], heard=heard, out=tmp_path / "out")


def _counted_rings(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Count the rings that are moved."""
    moved: list[Any] = []
    move = bearing_heard.heard_specimen

    def counted(*given: Any) -> Any:
        moved.append(given)
        return move(*given)

    monkeypatch.setattr(bearing_heard, "heard_specimen", counted)
    return moved


def test_the_number_of_pairs_may_be_given(chosen: Chosen) -> None:
    choice = chosen.choose(pairs=2)
    assert choice.pairs == 2 and len(chosen.heard) == 4
    assert choice.labels == [chosen.scenes[0].name, "louder"]
    assert choice.differences[0].db > 0
    assert all(len(of_one) == len(choice.quantities) for of_one in choice.by_quantity)
    frame = choice.table()
    assert len(frame) == 2 * len(choice.quantities)
    assert set(frame) >= {"candidate", "louder_db", "louder_uncertainty_db", "sureness"}
    choice.plot()


def test_a_choice_goes_on_where_it_stopped(chosen: Chosen, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = chosen._replace(out=chosen.out.with_name("whole")).choose(pairs=None)
    chosen.heard.clear()
    read = choosing.OpenChoice.hear
    looks: list[int] = []

    def stopped(self: choosing.OpenChoice, candidates: Any, count: int, **words: Any) -> Any:
        looks.append(count)
        if count > LOOKS[0]:
            raise KeyboardInterrupt
        return read(self, candidates, count, **words)

    with monkeypatch.context() as context:
        context.setattr(choosing.OpenChoice, "hear", stopped)
        with pytest.raises(KeyboardInterrupt):
            chosen.choose(pairs=None)
    assert len(chosen.heard) == 2 * LOOKS[0]
    again = chosen.choose(pairs=None)
    assert len(chosen.heard) == 2 * whole.pairs
    assert again.sentences == whole.sentences
    chosen.heard.clear()
    assert chosen.choose(pairs=None).sentences == whole.sentences
    assert chosen.heard == []


@pytest.mark.parametrize("pairs", [1, 61, True])
def test_other_numbers_of_pairs_are_refused(chosen: Chosen, pairs: Any) -> None:
    with pytest.raises(rc.SceneError, match=r"pairs: got .*, allowed: a whole number from 2 to 60"):
        chosen.choose(pairs=pairs)
    assert chosen.heard == [] and not chosen.out.exists()


def test_the_limit_of_time_ends_a_choice_early_and_says_so(
    chosen: Chosen, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Clock, "is_over", True)
    monkeypatch.setattr(choosing, "pairs_needed_of", lambda choice, work: 60)
    choice = chosen.choose(pairs=None)
    assert choice.pairs == LOOKS[0] and choice.is_early
    said = " ".join(choice.sentences)
    assert "ended early, because the limit of 10 min was reached" in said


def test_a_wide_uncertainty_names_what_limits_it(chosen: Chosen) -> None:
    budget = Budget(within_db=0.001, pairs=3)
    choice = choose_scenes(chosen.scenes, chosen.out, budget, workers=1)
    assert "3 " in choice.limit and "asked for" in choice.limit
    assert any(doubt.key.startswith("uncertain_by_") for doubt in choice.doubts)


@pytest.mark.parametrize("heard", ["[", '{"low": "much", "loss_factors": 1}'])
def test_damaged_numbers_are_named(chosen: Chosen, heard: str) -> None:
    chosen.choose()
    path = sorted(chosen.out.glob("runs/*/*/heard.json"))[0]
    path.write_text(heard)
    with pytest.raises(rc.FolderError, match=r"heard\.json: not readable"):
        chosen.choose()


def test_a_specimen_of_another_scene_with_the_same_name_is_refused(
    chosen: Chosen, request: pytest.FixtureRequest
) -> None:
    """Its level would pass for that of the changed scene."""
    chosen.choose()
    chosen.heard.clear()
    kind = request.node.callspec.params["chosen"]
    changed = chosen._replace(scenes=[one.with_(OTHER[kind]) for one in chosen.scenes])
    with pytest.raises(rc.FolderError, match="another scene"):
        changed.choose()
    assert chosen.heard == []


def test_a_folder_of_somebody_else_stays_as_it_is(chosen: Chosen) -> None:
    chosen.out.mkdir()
    (chosen.out / "thesis.txt").write_text("mine")
    before = tree(chosen.out)
    with pytest.raises(rc.FolderError, match="other files"):
        chosen.choose()
    assert tree(chosen.out) == before


@pytest.mark.parametrize("form", [choosing.FORMATS[1], choosing.FORMATS[-1]])
def test_a_choice_of_an_older_version_is_kept_or_starts_anew(chosen: Chosen, form: str) -> None:
    """Numbers of two programs are not mixed."""
    chosen.out.mkdir()
    old = {"format": form, "program": "version 0.8.0, sources 1", "sentences": []}
    write_json(chosen.out / "choice.json", old)
    with pytest.raises(rc.FolderError, match=r"version 0\.8\.0"):
        chosen.choose()
    del old["sentences"]
    write_json(chosen.out / "choice.json", old)
    assert chosen.choose().pairs == 2
    stored = json.loads((chosen.out / "choice.json").read_text())
    assert stored["format"] == choosing.FORMAT


def test_scenes_of_two_kinds_are_not_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["choose", "bearing-6204", "quickstart"])
    assert ended.value.code == 2
    assert "one kind" in capsys.readouterr().err


# ---- a kind without an audition of its own


@pytest.fixture
def by_defaults(monkeypatch: pytest.MonkeyPatch) -> Callable[[], Any]:
    """Let balls be compared as a kind that says nothing of comparisons."""
    monkeypatch.setattr(OneBall, "audition", lambda _: None)
    return lambda: rc.read_scene(
        "quickstart",
        [
            "sweep=",
            "rolling.load_n=1",
            "rolling.duration_s=0.002",
            "surface={kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 20,"
            " spacing_um: 4, width_um: 256, seed: 1}",
        ],
    )


def test_a_kind_without_an_audition_is_heard_by_the_sound_of_its_runs(
    by_defaults: Callable[[], Any], tmp_path: Path
) -> None:
    """A quarter of the distance is 12 dB more in each specimen, so the ± is rounding alone."""
    far = by_defaults().with_({"name": "far", "sound.distance_m": 4})
    near = far.with_({"name": "near", "sound.distance_m": 1})
    choice = choose_scenes([near, far], tmp_path / "out", Budget(pairs=2), workers=1)
    assert isinstance(choice.audition, Audition) and choice.noun == "surfaces"
    assert choice.labels == ["far", "near"]
    assert choice.differences[0].db == pytest.approx(12.04, abs=0.01)
    assert choice.differences[0].uncertainty_db == pytest.approx(0.0, abs=0.01)
    seeds = [specimen.scene.surface.seed for specimen in choice.contenders[0].specimens]
    assert seeds == [far.surface.seed, far.surface.seed + 1]
    _refuse_nothing_of_its_files(choice)


def _refuse_nothing_of_its_files(choice: Choice) -> None:
    """Write all files of a choice, and look at them."""
    from rolling.choice.choose_command import write_choice

    write_choice(choice)
    names = {path.name for path in choice.folder.iterdir()}
    sounds = {f"{one.candidate.folder_name}.wav" for one in choice.contenders}
    assert names >= {"choice.html", "choice.csv", "choice.png", "choice.json", *sounds}
    page = (choice.folder / "choice.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    assert page.count("<audio") == len(choice.contenders)
    assert choice.sentences[0].split(" (")[0] in page
    stored = json.loads((choice.folder / "choice.json").read_text())
    assert stored["sentences"] == choice.sentences
    assert len(stored["differences"]) == len(choice.quantities) * (len(choice.contenders) - 1)


def test_a_choice_of_bearings_has_a_page_with_a_sound_of_each(tmp_path: Path) -> None:
    scene = rc.read_scene("bearing-6204", [*SMOOTH_BEARING, "sound.listen_s=0.2"])
    louder = scene.with_({"name": "louder", **LOUDER["bearing"]})
    choice = choose_scenes([scene, louder], tmp_path / "out", Budget(pairs=2), workers=1)
    _refuse_nothing_of_its_files(choice)
