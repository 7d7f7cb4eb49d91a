"""What a choice leaves out, when it ends, and what it keeps, without a march.

Levels of specimens are given, and a stand-in writes them as marches would.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import rolling as rc
from acoustics.arrays import Array
from acoustics.pairs import LOOKS
from rolling import cli
from rolling.ball_kinds import ball_audition
from rolling.ball_kinds.ball_audition import BallAudition
from rolling.ball_kinds.ball_candidates import candidate, candidates_of
from rolling.ball_kinds.ball_heard import read_heard
from rolling.ball_kinds.ball_specimens import BallSpecimens
from rolling.check import narrow_surface
from rolling.choice import choice_doubts as choice_doubts
from rolling.choice import choice_picture, choice_sentences, omissions, specimen_solving
from rolling.choice.choice_numbers import OmittedPair
from rolling.choice.choose_command import as_json, write_answer
from rolling.choice.choosing import choose_scenes, open_choice
from rolling.choice.heard_specimen import Specimen
from rolling.choice.specimen_solving import RunSolver
from rolling.contact.solver import ContactError
from rolling.run.budget import Budget
from rolling.terminal import progress
from rolling.terminal.whole_files import FolderError, write_json
from tests.support.marched_specimens import stand_in, write_heard

# The third specimen of these scenes has a lone summit 68 um beside the middle, which is loaded.
NARROW = """\
name: narrow
sphere: {material: steel-100cr6, radius_mm: 5}
plate: {material: steel-s235, thickness_mm: 10, length_mm: 200, width_mm: 150, edges: free, loss_factor: 0.02}
surface: {kind: gaussian, seed: 1, roughness_ra_um: 0.1, correlation_length_um: 12, spacing_um: 4, width_um: 128}
rolling: {load_n: 0.3, speed_m_s: 0.1, distance_mm: 0.4}
dynamics: {}
"""  # noqa: E501

Marching = Callable[..., None]


@pytest.fixture
def scene(tmp_path: Path) -> rc.Scene:
    path = tmp_path / "narrow.yaml"
    path.write_text(NARROW)
    return rc.read_scene(path)


@pytest.fixture
def wide(scene: rc.Scene) -> rc.Scene:
    """Return the scene on a surface that is wider than any contact on it."""
    return scene.with_({"surface.width_um": 256})


@pytest.fixture
def marched(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Write what is heard of specimens in place of marches, and list which were asked for."""
    return stand_in(monkeypatch)


def two(wide: rc.Scene, name: str = "x") -> list[rc.Scene]:
    """Return two scenes, the second of which is rougher."""
    return [wide.with_(name="smooth"), wide.with_({"name": name, "roughness_ra_um": 0.2})]


# ---- specimens without a solution


def test_a_specimen_without_solution_is_left_out_with_its_partner(
    wide: rc.Scene, tmp_path: Path, marched: list[str]
) -> None:
    """The same command does not march it again, and another scene with its contact neither."""
    wide = wide.with_(seed=4)  # so that one of five is the failing seed 6
    out = tmp_path / "out"
    choice = choose_scenes(two(wide), out, Budget(pairs=5), workers=1)
    assert [(pair.number, pair.label) for pair in choice.omitted] == [(3, "x")]
    assert choice.pairs == 4 and choice.tried == 5 and choice.numbers == [1, 2, 4, 5]
    assert all(len(one.heard) == len(one.specimens) == 4 for one in choice.contenders)
    sentence = choice.sentences[1]
    assert "number 3 is left out" in sentence and "surface.width_um" in sentence
    assert choice.table()["left_out"].to_list() == [1, 1]
    stored = json.loads(json.dumps(as_json(choice)))
    assert stored["left_out"][0]["number"] == 3 and stored["pairs"] == 4
    assert "(1 left out)" in _title(choice)
    marched.clear()
    again = choose_scenes(two(wide), out, Budget(pairs=5), workers=1)
    assert again.sentences == choice.sentences
    assert marched == []


def _title(choice: rc.Choice) -> str:
    """Return the line above the picture of a choice."""
    return str(choice_picture.picture(choice).figure.axes[0].get_title(loc="left"))


@pytest.mark.parametrize(("seed", "pairs"), [(3, 4), (1, 12)])
def test_a_choice_that_would_leave_out_many_ends_with_the_remedy(
    wide: rc.Scene, tmp_path: Path, marched: list[str], seed: int, pairs: int
) -> None:
    """Half of four are many, and more than one in ten of twelve."""
    with pytest.raises(ContactError, match=r"of .* surfaces have no solution.*surface\.width_um"):
        choose_scenes(two(wide.with_(seed=seed)), tmp_path / "out", Budget(pairs=pairs), workers=1)


@pytest.mark.parametrize("correlation", [None, np.eye(6)])
def test_one_surface_under_two_names_is_told(
    wide: rc.Scene,
    tmp_path: Path,
    marched: list[str],
    monkeypatch: pytest.MonkeyPatch,
    correlation: Array | None,
) -> None:
    """Neither a further scan nor more specimens would tell what does not differ."""
    monkeypatch.setattr(BallSpecimens, "correlation", lambda *_: correlation)
    scenes = [wide.with_(name="first"), wide.with_(name="second")]
    choice = choose_scenes(scenes, tmp_path / "out", Budget(pairs=6), workers=1)
    assert choice.differences[0].db == choice.differences[0].parts_db["scatter"] == 0.0
    told = " ".join(choice.sentences)
    assert "stays open" in told and "the same to the last digit" in told
    assert "further scan" not in told
    others = choose_scenes(two(wide, "rough"), tmp_path / "two", Budget(pairs=6), workers=1)
    assert "the same to the last digit" not in " ".join(others.sentences)


def test_a_choice_without_any_solution_says_so() -> None:
    omitted = [OmittedPair(number, "x", "take a larger scan") for number in (1, 2, 3, 4)]
    with pytest.raises(ContactError, match=r"^none of 4 places has a solution; x, specimen 1"):
        omissions.refuse_many(omitted, 4, "places")


def test_another_contact_is_marched_again(
    wide: rc.Scene, tmp_path: Path, marched: list[str]
) -> None:
    scenes = two(wide.with_(seed=4))
    with open_choice(candidates_of(scenes), tmp_path / "out", workers=1) as work:
        (rough,) = [one for one in candidates_of(scenes) if one.label == "x"]
        specimen = work._specimen(rough, 0)
        omissions.remember(tmp_path / "out", specimen, "no solution")
        assert specimen.no_solution == "no solution"
        changed = rough.scene.with_({"surface.width_um": 512, "surface.seed": 4})
        other = Specimen({}, changed, specimen.folder, rough, number=0)
        assert other.no_solution == ""


def test_a_wider_surface_goes_on_in_the_folder_of_the_narrow_one(
    scene: rc.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where no specimen had a solution, and each was remembered before a march."""

    class Loop:
        """A loop over pieces that only begins."""

        def __init__(self, *_: object) -> None:
            raise KeyboardInterrupt

    with open_choice(candidates_of(two(scene)), tmp_path / "out", workers=1) as work:
        narrow = work._specimen(candidates_of(two(scene))[0], 0)
        omissions.remember(tmp_path / "out", narrow, "no solution")
        wider = scene.with_({"surface.width_um": 256})
        specimen = Specimen({}, wider, narrow.folder, narrow.candidate, number=0)
        monkeypatch.setattr(specimen_solving, "RunLoop", Loop)
        with pytest.raises(KeyboardInterrupt):
            work._solver.solve([specimen], ["wider"], stored=[])
    assert (narrow.folder / "scene.yaml").is_file()
    assert not (narrow.folder / "failed.json").exists()


def test_the_reason_of_a_stranger_steers_no_page(
    wide: rc.Scene, tmp_path: Path, marched: list[str]
) -> None:
    out = tmp_path / "out"
    scenes = two(wide, "rough")
    with open_choice(candidates_of(scenes), out, workers=1) as work:
        specimen = work._specimen(candidates_of(scenes)[0], 2)
        omissions.remember(out, specimen, "none\x1b]0;title\x07\nsurely")
    choice = choose_scenes(scenes, out, Budget(pairs=6), workers=1)
    assert choice.omitted[0].number == 3
    assert all(sentence.isprintable() for sentence in choice.sentences)


def test_a_narrow_surface_is_foreseen_before_a_march(
    scene: rc.Scene, tmp_path: Path, marched: list[str]
) -> None:
    scenes = [scene, scene.with_({"name": "heavier", "rolling.load_n": 0.35})]
    choice = choose_scenes(scenes, tmp_path / "out", Budget(pairs=4), workers=1)
    assert [pair.number for pair in choice.omitted] == [3]
    assert not any("specimen 3" in label for label in marched)
    # for both scenes alike, of which the smooth one is found first
    assert "surface.width_um: 256" in choice.omitted[0].reason


def test_a_march_that_fails_is_remembered(
    scene: rc.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where nothing was foreseen; its pieces are removed, and no second march begins."""
    monkeypatch.setattr(BallAudition, "foresee", lambda *_: "")
    failing = [candidate("narrow", scene.with_(seed=3))]
    for _ in range(2):
        with (
            open_choice(failing, tmp_path / "out", workers=1) as work,
            pytest.raises(ContactError, match="um wide across the track"),
        ):
            work.hear(failing, 1)
        assert not (tmp_path / "out" / "pieces").exists()
        monkeypatch.setattr(specimen_solving, "RunLoop", None)


def test_a_failure_that_is_not_of_the_contact_is_not_remembered(
    wide: rc.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Killed:
        """A loop whose process was killed, as by a lack of memory."""

        failures: ClassVar = {0: "a worker process was killed"}
        without_solution: ClassVar = set()

        def __init__(self, *_: object) -> None:
            pass

        def finished_runs(self, pool: object) -> list:
            return []

    monkeypatch.setattr(specimen_solving, "RunLoop", Killed)
    both = candidates_of(two(wide))
    with (
        open_choice(both, tmp_path / "out", workers=1) as work,
        pytest.raises(ContactError, match="killed"),
    ):
        work.hear(both, 4)
    assert [*(tmp_path / "out").glob("**/failed.json")] == []


def test_a_check_foresees_the_surfaces_of_a_choice(
    scene: rc.Scene, wide: rc.Scene, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    doubts = {doubt.key: doubt for doubt in scene.check(solve=False).doubts["narrow"]}
    assert "seed 3" in doubts["narrow_specimens"].text
    assert "window" not in doubts  # the surface of the scene itself is wide enough
    other = scene.with_(seed=3).check(solve=False).doubts["narrow"]
    assert "window" in {doubt.key for doubt in other}
    assert "narrow_specimens" not in {
        doubt.key for doubt in wide.check(solve=False).doubts["narrow"]
    }
    assert cli.main(["check", "--fast", str(tmp_path / "narrow.yaml")]) == 0
    assert "On 1 of the first 12 surfaces" in capsys.readouterr().out


def test_a_check_foresees_the_seeds_that_a_choice_takes(
    scene: rc.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A ball with a surface of its own has another seed, which is no first one."""
    monkeypatch.setattr("rolling.check.widest_places.may_be_too_narrow", lambda _: True)
    ball = {"kind": "gaussian", "seed": 1, "roughness_ra_um": 0.02, "correlation_length_um": 12}
    both = scene.with_({"surface.seed": 5, "sphere.surface": ball})
    one = candidate("both", both)
    taken = BallSpecimens([one])
    seeds = [taken.scene(one, number).surface.seed for number in range(3)]
    (_, doubt) = narrow_surface.rules(both)
    assert seeds == [5, 6, 7] and "(seed 5, 6, 7," in doubt.text


# ---- number of pairs, and time


def test_a_number_of_pairs_takes_the_time_that_it_takes(
    wide: rc.Scene, tmp_path: Path, marched: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rolling.run.budget.time.monotonic", iter(range(0, 10**6, 3600)).__next__)
    choice = choose_scenes(two(wide, "rough"), tmp_path / "out", Budget(pairs=9), workers=1)
    assert choice.pairs == 9 and not choice.is_early
    assert "9 surfaces were asked for" in choice.limit


def test_a_choice_that_was_killed_gives_the_same_answer(
    wide: rc.Scene, tmp_path: Path, marched: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed in any batch, it takes the same looks again."""
    whole = choose_scenes(two(wide, "rough"), tmp_path / "whole", Budget(), workers=1)
    assert whole.pairs > LOOKS[1] and not whole.is_early
    solve = RunSolver.solve
    calls = []

    def killed(
        self: RunSolver, specimens: Sequence[Specimen], names: Sequence[str], **stored: Any
    ) -> None:
        calls.append(0)
        if len(calls) == 3:
            half = len(specimens) - 3  # within a batch
            solve(self, specimens[:half], names[:half], **stored)
            raise KeyboardInterrupt
        solve(self, specimens, names, **stored)

    with monkeypatch.context() as context:
        context.setattr(RunSolver, "solve", killed)
        with pytest.raises(KeyboardInterrupt):
            choose_scenes(two(wide, "rough"), tmp_path / "killed", Budget(), workers=1)
    again = choose_scenes(two(wide, "rough"), tmp_path / "killed", Budget(), workers=1)
    assert again.sentences == whole.sentences and again.pairs == whole.pairs
    fixed = choose_scenes(
        two(wide, "rough"), tmp_path / "fixed", Budget(pairs=whole.pairs), workers=1
    )
    assert fixed.sentences == whole.sentences


def test_the_answer_names_the_command_that_repeats_it(
    wide: rc.Scene,
    tmp_path: Path,
    marched: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("rolling.choice.choose_command.write_choice", lambda choice: None)
    (tmp_path / "a file.yaml").write_text(NARROW.replace("128", "256"))
    words = ["choose", str(tmp_path / "a file.yaml"), "--out", str(tmp_path / "out")]
    words += ["--set", "sweep={surface.roughness_ra_um: [0.1, 0.2]}", "--workers", "1"]
    assert cli.main(words) == 0
    out = capsys.readouterr().out
    (line,) = [line for line in out.splitlines() if line.startswith("the same answer again: ")]
    assert "--pairs " in line and "'--set'" not in line
    assert f"'{tmp_path}/a file.yaml'" in line and "--set 'sweep=" in line


# ---- folders


def test_no_name_of_a_candidate_is_that_of_a_file_of_the_choice(
    wide: rc.Scene, tmp_path: Path, marched: list[str]
) -> None:
    names = ["choice.csv", "choice.json", "choice.html", "choice.png", "b", "b.wav", "runs"]
    scenes = [
        wide.with_({"name": name, "roughness_ra_um": 0.1 + 0.01 * number})
        for number, name in enumerate(names)
    ]
    choice = choose_scenes(scenes, tmp_path / "out", Budget(pairs=4), workers=1)
    assert {path.name for path in (tmp_path / "out").iterdir() if path.is_dir()} == {"runs"}
    files = {"choice.csv", "choice.json", "choice.html", "choice.png", "runs", "pieces"}
    sounds = {f"{one.candidate.folder_name}.wav" for one in choice.contenders}
    assert len(sounds) == len(names) and not sounds & files
    folders = {one["folder"] for one in as_json(choice)["candidates"]}
    assert folders == {f"runs/{name}" for name in names}


OLD = {"format": "rolling-contact-noise choice, format 1", "program": "version 0.8.0, sources 1"}


def test_an_unfinished_choice_of_an_older_version_starts_anew(
    wide: rc.Scene, tmp_path: Path, marched: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """Its files stay, since numbers of two programs are not mixed."""
    run = tmp_path / "out" / "smooth" / "01" / "heard.json"
    run.parent.mkdir(parents=True)
    run.write_text("old")
    write_json(tmp_path / "out" / "choice.json", OLD)
    with rolling_messages():
        choice = choose_scenes(two(wide, "rough"), tmp_path / "out", Budget(pairs=4), workers=1)
    assert "starts anew" in "".join(capsys.readouterr())
    assert choice.pairs == 4 and len(marched) == 8 and run.read_text() == "old"
    marched.clear()
    choose_scenes(two(wide, "rough"), tmp_path / "out", Budget(pairs=4), workers=1)
    assert marched == []  # from now on it goes on


def rolling_messages() -> Any:
    """Show lines of progress, as a command does."""
    from rolling.terminal import progress

    return progress.begin(progress.Level.NORMAL)


@pytest.mark.parametrize("name", ["choice.html", "choice.png", "smooth.wav"])
def test_a_folder_by_the_name_of_a_file_is_refused_before_a_march(
    wide: rc.Scene, tmp_path: Path, marched: list[str], name: str
) -> None:
    """Candidates of version 0.8.0 stood beside the files of a choice."""
    (tmp_path / "out" / name).mkdir(parents=True)
    write_json(tmp_path / "out" / "choice.json", OLD)
    with pytest.raises(FolderError, match="take another --out"):
        choose_scenes(two(wide), tmp_path / "out", Budget(pairs=4), workers=1)
    assert marched == []


# ---- doubts and files


def test_each_rule_of_a_choice_raises_its_doubt(
    wide: rc.Scene, tmp_path: Path, marched: list[str]
) -> None:
    """Answer, table, JSON and page take the doubts and their sentences from one list."""
    only_with_dynamics = ("thickness_mm", "length_mm", "width_mm", "edges", "loss_factor")
    changes = {f"plate.{key}": None for key in only_with_dynamics}
    scenes = [one.with_({"dynamics": None, **changes}) for one in two(wide.with_(seed=4))]
    choice = choose_scenes(scenes, tmp_path / "out", Budget(pairs=5), workers=1)
    wide_apart = replace(choice.differences[0], uncertainty_db=9.0, released_db=-1.0, sureness=0.99)
    alike = replace(choice.differences[0], independent=1.4, further_scan_db=0.3)
    equal = replace(choice.differences[0], db=0.0, parts_db={"scatter": 0.0})
    changed = [
        choice,
        replace(choice, by_quantity=[{"vibration": alike}], is_early=True, limit="time is over"),
        replace(choice, by_quantity=[{"vibration": equal}]),
        replace(choice, by_quantity=[{"vibration": wide_apart}], omitted=[], limit="that is all"),
        replace(
            choice,
            by_quantity=[
                {"vibration": replace(wide_apart, parts_db={"scatter": 0.1, "baffle": 3.0})}
            ],
        ),
    ]
    found = {doubt.key: doubt for one in changed for doubt in one.doubts}
    rules = {*choice_doubts.RULES, *ball_audition.RULES}
    assert {rule for rule in rules for one in changed if [*rule(one)]} == rules
    assert found["uncertain_by_baffle"].decibels == 3.0
    assert {"uncertain_by_scatter", "pairs_without_solution", "left_out_parts"} <= found.keys()
    for one in changed:
        said = " ".join([*one.sentences, *choice_sentences.notes(one)])
        assert all(doubt.line in said for doubt in one.doubts)
        stored = json.loads(json.dumps(as_json(one)))
        assert [doubt["key"] for doubt in stored["doubts"]] == [doubt.key for doubt in one.doubts]
    stored = as_json(choice)
    assert {"ball", "plate", "load", "speed", "listener", "surface"} <= {
        name for conditions in stored["conditions"]["scenes"].values() for name in conditions
    }
    assert rc.__version__ in stored["methods"]
    assert stored["differences"][0]["left_out_db"].keys() == {"time_step", "baffle"}
    assert choice.table()["uncertainty_left_out"].to_list()[1] == "time_step baffle"


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("released_power_db", "60", "released_power_db"),
        ("squares_pa2", [1.0, 2.0, 3.0], "squares of another shape"),
        ("bands_pa2", [[0.0] * 30], "bands of another shape"),
        ("baffle_db", [1e400] * 31, "inf is no number"),
        ("parts_db", {"record": None}, "parts_db.record"),
    ],
)
def test_what_is_heard_is_read_with_its_types(
    wide: rc.Scene, tmp_path: Path, name: str, value: object, message: str
) -> None:
    stated = candidate("stated", wide.with_({"plate.contact_loss_factor": 0.01}))
    specimen = Specimen({}, wide, tmp_path / "01", candidate=stated, number=0)
    write_heard(specimen, seed=1)
    assert read_heard(specimen).baffle_db is not None
    path = specimen.folder / "heard.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {name: value}))
    with pytest.raises(FolderError, match=message):
        read_heard(specimen)


# ---- the answer so far


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the lines that are said."""
    lines: list[str] = []
    monkeypatch.setattr(progress, "line", lines.append)
    return lines


def test_an_interrupted_choice_keeps_its_last_answer(
    wide: rc.Scene, tmp_path: Path, marched: list[str], said: list[str]
) -> None:
    """It says an answer after each batch, from two pairs on, and the same command goes on."""
    scenes = two(wide.with_(seed=7))
    budget = Budget(within_db=0.01)
    kept: list[int] = []

    def keep(choice: rc.Choice) -> None:
        """Keep an answer, and stop after that of four surfaces as by Ctrl-C."""
        write_answer(choice)
        kept.append(choice.pairs)
        if len(kept) == 2:
            raise KeyboardInterrupt

    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        choose_scenes(scenes, out, budget, workers=1, keep=keep)
    assert kept == [2, 3]  # the third is left out
    told = [line for line in said if " quieter than " in line]
    assert [line.split(":")[0] for line in told] == ["2 surfaces", "3 surfaces"]
    assert "± " in told[0] and " dB(A) quieter than " in told[0]
    stored = json.loads((out / "choice.json").read_text())
    assert stored["pairs"] == 3 and stored["ended_early"]
    assert "it was interrupted after 4 surfaces" in " ".join(
        doubt["text"] for doubt in stored["doubts"]
    )
    assert (out / "choice.csv").read_text().count("\n") == 3
    choice = choose_scenes(scenes, out, Budget(pairs=4), workers=1)
    assert choice.sentences[0].split(",")[0] == stored["sentences"][0].split(",")[0]
    assert not choice.is_early


def test_two_pairs_are_too_few_to_judge_how_many_are_left_out(
    wide: rc.Scene, tmp_path: Path, marched: list[str], said: list[str]
) -> None:
    choice = choose_scenes(two(wide.with_(seed=5)), tmp_path / "out", Budget(pairs=4), workers=1)
    assert [pair.number for pair in choice.omitted] == [2]
    assert [line.split(":")[0] for line in said if " quieter than " in line] == ["3 surfaces"]
