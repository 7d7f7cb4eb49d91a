"""Commands on run folders as a user meets them, from `run` to `listen`."""

from __future__ import annotations

import os
import time
import webbrowser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from commands import SWEEP, contents, tree, words_of
from finished import VIBRATING
from scene_text import TINY

from acoustics import wav
from rolling import cli, open_run, read_scene
from rolling.contact import closed_forms
from rolling.marches.piece import contact_identity
from rolling.numbers.run_file import StoredNumbers
from rolling.results.listening import describe_long_record, long_record_of
from rolling.results.stored_numbers import read_stored
from rolling.run import folder as folders
from rolling.terminal import defaults

SEEDS = TINY + "sweep: {surface.seed: [1, 2, 3]}\n"
OF_A_RUN = {"result.h5", "numbers.json", "summary.json", "signal.wav", "listen.wav"}
OF_A_RUN |= {"released.wav", "released_signal.wav"}
OF_A_FOLDER = {"scene.yaml", "runs.csv", "bands.csv"}


def write(folder: Path, text: str = TINY) -> Path:
    path = folder / "scene.yaml"
    path.write_text(text)
    return path


def run(scene: Path, out: Path, *more: str) -> int:
    return cli.main(words_of(scene, out, "--workers", "1", *more))


def stored(folder: Path) -> StoredNumbers:
    return read_stored(folder)


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of three runs, with page and figures, which no test changes."""
    folder = tmp_path_factory.mktemp("swept")
    words = ["run", str(write(folder, SEEDS)), "--out", str(folder / "out"), "--workers", "1", "-q"]
    assert cli.main(words) == 0
    return folder / "out"


# ---- run


def test_a_run_leaves_few_files(tmp_path: Path, swept: Path) -> None:
    out = tmp_path / "out"
    assert run(write(tmp_path), out) == 0
    assert {path.name for path in out.iterdir()} == OF_A_RUN | OF_A_FOLDER
    below = {f"seed={seed}" for seed in (1, 2, 3)}
    assert {path.name for path in swept.iterdir()} == OF_A_FOLDER | below | {
        "report.html",
        "figures",
    }
    for name in below:
        assert {path.name for path in (swept / name).iterdir()} == OF_A_RUN
    written = {path.stem for path in (swept / "figures").iterdir()}
    assert "spectrum" in written
    assert not any("released" in name for name in written)  # they are on the page alone
    assert "released_spectrum" in (swept / "report.html").read_text()
    assert len([*swept.rglob("*.*")]) < 30
    for name in ("summary.json", "scene.yaml"):
        assert str(tmp_path) not in (out / name).read_text()


def test_the_same_command_says_that_all_is_done_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = write(tmp_path, SEEDS)
    out = tmp_path / "out"
    assert run(scene, out) == 0
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*.*")}
    capsys.readouterr()
    words = [word for word in words_of(scene, out) if word != "-q"]
    assert cli.main(words) == 0
    said = capsys.readouterr()
    assert "done" in said.err and "dB(A)" in said.out and str(out) in said.out
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*.*")} == before


@pytest.mark.slow
def test_values_that_a_sweep_gets_later_are_added(tmp_path: Path) -> None:
    scene = write(tmp_path, SEEDS)
    out = tmp_path / "out"
    whole = tmp_path / "whole"
    assert run(scene, out) == 0
    before = contents(out)
    more = ("--set", "sweep.surface.seed=[0, 1, 2, 3]")
    assert run(scene, out, *more) == 0
    assert run(scene, whole, *more) == 0
    assert contents(out) == contents(whole) and contents(out).items() > before.items()
    assert len(pd.read_csv(out / "runs.csv")) == 4
    assert run(scene, out) == 2  # fewer values are another scene


def test_the_default_folder_is_named_by_the_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    scene = write(tmp_path)
    words = ["run", str(scene), "--no-report", "-q", "--workers", "1"]
    for more in ([], [], ["--set", "rolling.load_n=0.006"]):
        assert cli.main([*words, *more]) == 0
    first, again, other = capsys.readouterr().out.split()
    assert first == again != other and len(first) == len("outputs/tiny-") + 8
    assert sorted(str(path) for path in Path("outputs").iterdir()) == sorted({first, other})


def test_parts_in_any_order_give_the_bytes_of_the_whole(tmp_path: Path, swept: Path) -> None:
    scene = write(tmp_path, SEEDS)
    out = tmp_path / "out"
    for number, done in ((2, 1), (3, 2), (1, 3)):
        assert not (out / "runs.csv").exists()
        assert run(scene, out, "--part", f"{number}/3") == 0
        assert [state for state, _ in folders.states(out).values()].count("done") == done
    assert contents(out) == contents(swept)
    assert run(scene, out, "--part", "9/9") == 0  # an array may have more parts than marches


def test_runs_with_one_march_stay_in_one_part(tmp_path: Path) -> None:
    """Speeds share a march where the sphere rolls the same distance; loads do not."""
    text = TINY.replace("duration_s: 0.0005", "distance_mm: 0.05")
    text += "sweep: {rolling.speed_m_s: [0.1, 0.2], rolling.load_n: [0.005, 0.01]}\n"
    scene = write(tmp_path, text)
    out = tmp_path / "out"
    marches = [contact_identity(single) for _, single in read_scene(scene).runs()]
    assert marches[0] == marches[2] != marches[1] == marches[3]
    assert run(scene, out, "--part", "1/2") == 0
    states = folders.states(out)
    assert [state for state, _ in states.values()] == ["done", "waiting", "done", "waiting"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--part", "4/3"], "got '4/3', allowed: K/N"),
        (["--part", "0/3"], "got '0/3', allowed: K/N"),
        (["--part", "a/b"], "got 'a/b', allowed: K/N"),
        (["--part", "1/2"], "the scene has none"),
        (["--set", "rolling.laod_n=3"], "nearest: rolling.load_n"),
        (["--set", "surface.kind=file", "--set", "surface.path=none.npy"], "surface"),
    ],
)
def test_bad_input_writes_nothing(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = write(tmp_path)
    out = tmp_path / "out"
    try:
        assert run(scene, out, *words) == 2
    except SystemExit as end:  # of the parser
        assert end.code == 2
    assert message in capsys.readouterr().err and not out.exists()


def test_a_run_that_fails_says_why_and_leaves_the_others_whole(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The plate carries 2.1 GPa times 50 x 128 um, 13.44 N."""
    text = TINY + "sweep: {rolling.load_n: [40, 0.005]}\n"
    scene = write(tmp_path, text)
    out = tmp_path / "out"
    for _ in range(2):  # the second command tries it again
        assert run(scene, out) == 1
        assert "failed: load 40 N: " in (said := capsys.readouterr().err)
        assert "13.44 N" in said
    assert [state for state, _ in folders.states(out).values()] == ["failed", "done"]
    table = pd.read_csv(out / "runs.csv")
    assert list(table["released_power_db"].notna()) == [False, True]


@pytest.mark.slow
def test_workers_change_no_byte(tmp_path: Path) -> None:
    scene = write(tmp_path, SWEEP)
    assert run(scene, tmp_path / "one") == 0
    assert cli.main(words_of(scene, tmp_path / "two", "--workers", "2")) == 0
    assert contents(tmp_path / "one") == contents(tmp_path / "two")


def test_a_smooth_ball_that_accelerates_is_silent(tmp_path: Path) -> None:
    scene = tmp_path / "s.yaml"
    out = tmp_path / "out"
    scene.write_text(
        "name: s\nsphere: {radius_mm: 5}\nplate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}\n"
        "surface: {kind: smooth, spacing_um: 2, width_um: 200}\n"
        "rolling: {load_n: 5, speed_m_s: [[0, 0.1], [0.01, 0.3]], duration_s: 0.004}\n"
    )
    assert run(scene, out) == 0
    numbers = stored(out).numbers
    assert numbers.of_record.laeq_db is None and numbers.of_record.level_db is None
    speed = read_scene(out / "scene.yaml").motion.distance(0.004) / 0.004
    power = closed_forms.smooth_release_power(5, speed, 5e-3, 210e9 / 0.91)
    # 0.3 % of release at a / spacing = 22, and a track rounded to whole nodes
    expected = 10 * np.log10(power / (4 * np.pi * 1e-12))
    assert numbers.of_record.steady_level_db == pytest.approx(expected, abs=0.02)


def test_a_height_file_is_found_from_the_folder(tmp_path: Path) -> None:
    np.save(tmp_path / "z.npy", np.random.default_rng(1).standard_normal((40, 60)) * 2e-8)
    head, _, tail = TINY.partition("surface:")
    rest = tail[tail.index("rolling:") :].replace("0.0005", "0.0016")  # two laps
    text = f"{head}surface: {{kind: file, path: z.npy, spacing_um: 2}}\n{rest}"
    scene = write(tmp_path, text)
    out = tmp_path / "a" / "b"
    assert run(scene, out) == 0
    assert "path: ../../z.npy" in (out / "scene.yaml").read_text()
    release = open_run(out).series["release_energy"]
    assert len(release) == 80
    np.testing.assert_array_equal(release[:40], release[40:])
    far = tmp_path / "far"
    words = ["resound", str(out), "--set", "sound.distance_m=2", "--out", str(far), "-q"]
    assert cli.main([*words, "--no-report"]) == 0 and "path: ../z.npy" in tree(far)["scene.yaml"]


def test_very_many_runs_have_a_table_and_no_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(defaults, "MAX_RUNS_COMPARED", 2)
    monkeypatch.setattr(defaults, "FEW_RUNS", 1)
    out = tmp_path / "out"
    words = ["run", str(write(tmp_path, SEEDS)), "--out", str(out), "--workers", "1"]
    assert cli.main(words) == 0
    assert not (out / "report.html").exists() and (out / "runs.csv").is_file()
    printed = capsys.readouterr().out
    assert "seed 1" in printed and "seed 3" not in printed and "2 more runs" in printed


@pytest.mark.slow
def test_a_thousand_runs_of_different_seeds_start_within_seconds(tmp_path: Path) -> None:
    """Each worker makes its own surface: the first piece of many runs comes as soon as of two."""
    from commands import started, wait_for

    text = TINY.replace("width_um: 128", "width_um: 512").replace("0.0005", "0.01")
    seconds = []
    for count in (2, 1000):
        folder = tmp_path / str(count)
        folder.mkdir()
        scene = write(folder, f"{text}sweep: {{surface.seed: {[*range(count)]}}}\n")
        began = time.monotonic()
        with started(words_of(scene, folder / "out", "--workers", "2"), folder):
            wait_for(lambda: [*folder.glob("out/pieces/*/*.npz")])  # noqa: B023
        seconds.append(time.monotonic() - began)
    # A thousand surfaces made in advance would take minutes; 5 s each on an idle machine.
    assert seconds[1] < 4 * seconds[0]


@pytest.mark.slow
def test_runs_that_share_a_march_are_as_runs_alone(tmp_path: Path) -> None:
    """Loads, film and marches of an earlier run of another speed leave no trace in a later one."""
    moving = VIBRATING.replace("distance_mm: 0.48", "distance_mm: 1.4").replace("160", "120")
    moving = moving.replace("load_n: 1,", "load_n: 0.05,")
    moving = moving.replace("sound: {", "sound: {listen_s: 0.5, ")
    speeds = "sweep: {rolling.speed_m_s: [%s]}\n"
    whole = tmp_path / "whole"
    assert run(write(tmp_path, moving + speeds % "0.1, 1"), whole, "--no-report") == 0
    stored = contents(whole)
    assert {"speed_m_s=0.1/result.h5", "speed_m_s=1/result.h5"} < stored.keys()
    for first in ("0.1", "1"):
        added = tmp_path / f"first-{first}"
        for listed in (first, "0.1, 1"):
            assert run(write(tmp_path, moving + speeds % listed), added, "--no-report") == 0
        assert contents(added) == stored


# ---- resound


@pytest.mark.law("Speed: a speed times c multiplies the release power by c, without a new solve.")
def test_resound_solves_nothing_and_speed_scales(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    first = tmp_path / "first"
    fast = tmp_path / "fast"
    far = tmp_path / "far"
    assert run(write(tmp_path), first) == 0
    monkeypatch.setattr("rolling.marches.march_piece.march", None)
    words = ["--no-report", "-q", "--workers", "1"]
    speed = ["resound", str(first), "--set", "rolling.speed_m_s=0.2", "--out", str(fast)]
    assert cli.main([*speed, *words]) == 0
    slow = stored(first).numbers
    quick = stored(fast).numbers
    # Speed times 2: power times 2, half the time.
    assert quick.energy.release_power_mean_w == pytest.approx(
        2 * slow.energy.release_power_mean_w, rel=1e-12
    )
    assert quick.record.duration_s == pytest.approx(slow.record.duration_s / 2, rel=1e-12)
    louder = slow.of_record.steady_level_db + 10 * np.log10(2)
    assert quick.of_record.steady_level_db == pytest.approx(louder, abs=1e-9)
    distance = ["resound", str(fast), "--set", "sound.distance_m=10", "--out", str(far)]
    assert cli.main([*distance, *words]) == 0
    far_db = stored(far).numbers.of_record.level_db
    assert far_db == pytest.approx(quick.of_record.level_db - 20, abs=1e-6)
    capsys.readouterr()
    load = ["resound", str(first), "--set", "rolling.load_n=2", "--out", str(tmp_path / "no")]
    assert cli.main([*load, *words]) == 2
    assert "rolling.load_n" in capsys.readouterr().err and not (tmp_path / "no").exists()


@pytest.mark.slow
def test_a_resounded_sweep_has_the_bytes_of_a_run(tmp_path: Path, swept: Path) -> None:
    scene = write(tmp_path, SEEDS)
    out = tmp_path / "out"
    new = tmp_path / "new"
    change = ["--set", "sound.distance_m=2"]
    assert cli.main(["resound", str(swept), *change, "--out", str(out), "--no-report", "-q"]) == 0
    assert run(scene, new, *change) == 0
    assert contents(out) == contents(new)


def test_the_shortest_run_of_a_sweep_is_heard_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = TINY + "sweep: {rolling.load_n: [0.02, 0.005, 0.01]}\n"
    out = tmp_path / "out"
    words = ["--out", str(out), "--workers", "1", "--no-report"]
    assert cli.main(["run", str(write(tmp_path, text)), *words]) == 0
    sound = out / "load_n=0.005" / "listen.wav"
    assert f"the first sound, load 0.005 N: {sound}\n" in capsys.readouterr().err
    times = [
        (out / f"load_n={load}" / "signal.wav").stat().st_mtime_ns for load in (5e-3, 2e-2, 1e-2)
    ]
    assert times == sorted(times)


# ---- status, table, plot, report, listen


def test_status_counts_states_and_names_failures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    assert run(write(tmp_path, SEEDS), out, "--part", "1/3") == 0
    (out / "seed=2").mkdir()
    (out / "seed=2" / "failed.json").write_text('{"reason": "the load is too large"}')
    before = tree(out)
    capsys.readouterr()
    assert cli.main(["status", str(out)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"{out}: 3 runs: 1 done, 1 waiting, 1 failed",
        "  failed: seed=2: the load is too large",
    ]
    assert tree(out) == before
    assert cli.main(["status", str(out / "seed=1")]) == 0
    assert "1 run: 1 done" in capsys.readouterr().out
    assert cli.main(["status", str(tmp_path)]) == 2
    assert "no run folder" in capsys.readouterr().err

    def finish(seconds: float) -> None:
        (out / "seed=3").mkdir()
        (out / "seed=3" / "failed.json").write_text("{}")

    monkeypatch.setattr("time.sleep", finish)
    assert cli.main(["status", str(out), "--watch"]) == 0
    assert "2 failed" in capsys.readouterr().out


def test_table_writes_statistics_and_plots(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = TINY + "sweep: {rolling.load_n: [0.005, 0.01], surface.seed: [1, 2]}\n"
    out = tmp_path / "out"
    assert run(write(tmp_path, text), out) == 0
    capsys.readouterr()
    words = ["--plot", "contact_plastic_ratio", "released_power_db", "-q"]
    assert cli.main(["table", str(out), *words]) == 0
    paths = [Path(line) for line in capsys.readouterr().out.splitlines()]
    assert all(path.is_file() for path in paths)
    assert {"runs.csv", "statistics.csv"} < {path.name for path in paths}
    assert any("plastic_ratio" in path.name for path in paths)
    statistics = pd.read_csv(out / "statistics.csv")
    levels = statistics[statistics["level"] == "released_power_db"].set_index("rolling.load_n")
    runs = pd.read_csv(out / "runs.csv").groupby("rolling.load_n")["released_power_db"]
    np.testing.assert_allclose(levels["mean"], runs.mean(), rtol=1e-12)
    for words, message in (
        (["--plot", "released_power"], "nearest: released_power_db"),
        (["--against", "rolling.load"], "nearest: rolling.load_n"),
        (["--against", "rolling.load_n", "rolling.load_n"], "two different ones for a map"),
        (["--over", "rolling.seed"], "no swept key"),
    ):
        assert cli.main(["table", str(out), *words]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("form", ["png", "svg", "csv"])
def test_plot_draws_single_figures(
    form: str, swept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["plot", str(swept / "seed=1"), "--figure", "release_power", "--format", form]
    assert cli.main([*words, "--out", str(tmp_path / "drawn")]) == 0
    (path,) = (tmp_path / "drawn").iterdir()
    assert capsys.readouterr().out == f"{path}\n"
    assert path.name == f"release_power.{form}" and path.stat().st_size > 200
    assert cli.main([*words, "--out", str(tmp_path / "drawn")]) == 2  # of another run, for all that
    assert f"{path}: exists; take another folder" in capsys.readouterr().err
    before = {*swept.rglob("*")}
    assert cli.main(["plot", str(swept), "--figure", "release_pwoer"]) == 2
    assert {*swept.rglob("*")} == before  # no empty folder for it
    assert "release_power" in capsys.readouterr().err


def test_report_is_made_again_and_of_several_folders(
    swept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    page = tmp_path / "page.html"
    assert run(write(tmp_path), out) == 0
    assert cli.main(["report", str(out), "-q"]) == 0
    assert "tiny" in (out / "report.html").read_text()
    assert cli.main(["report", str(out), str(swept), "--out", str(page), "-q"]) == 0
    assert "seed 3" in page.read_text()
    capsys.readouterr()
    assert cli.main(["report", str(out), "--out", str(page)]) == 2
    assert "exists" in capsys.readouterr().err
    assert cli.main(["report", str(out), str(swept)]) == 2
    assert "--out" in capsys.readouterr().err


@pytest.mark.parametrize("is_found", [True, False])
def test_a_run_opens_its_page(
    is_found: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda page: bool(opened.append(page)) or is_found)
    scene = write(tmp_path, TINY + 'title: "Ball & plate <b>"\n')
    out = tmp_path / "out"
    assert cli.main(["run", str(scene), "--out", str(out), "--open", "--workers", "1"]) == 0
    assert opened == [(out / "report.html").as_uri()]
    assert ("no browser was found" in capsys.readouterr().err) == (not is_found)
    html = (out / "report.html").read_text(encoding="utf-8")
    assert "Ball &amp; plate &lt;b&gt;" in html and "plate <b>" not in html


def refuse_or_hear_a_room(out: Path, order: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """A room is for listening only: its file says so, and no number and no other file changes."""
    dry, rate, _ = wav.read(out / "long.wav")
    before = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
    assert cli.main([*order, "--seed", "2", "--reverberation", "20"]) == 2
    assert "reverberation: got 20 s, allowed: 0.1 to 10 s" in capsys.readouterr().err
    assert cli.main([*order, "--seed", "2", "--reverberation", "0.5"]) == 0
    said = capsys.readouterr()
    assert said.out == f"{out / 'room.wav'}\n"
    assert "heard in a made room of 50 m3" in said.err
    after = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
    del after["room.wav"]
    assert after == before
    heard, _, comment = wav.read(out / "room.wav")
    assert "reverberation time of 0.5 s, which no level includes" in comment
    assert heard.shape == (len(heard), 2) and len(heard) > len(dry) + 0.5 * rate - 1
    assert np.abs(heard).max() <= wav.PEAK + 2**-23
    assert np.abs(heard[-rate // 100 :]).max() < 0.01 * np.abs(heard).max()  # it dies away
    (out / "room.wav").unlink()


def test_a_run_is_listened_to_for_as_long_as_wanted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    text = VIBRATING.replace("sound: {source", "sound: {listen_s: 1.5, source")
    assert run(write(tmp_path, text), out, "--set", "rolling.distance_mm=0.2") == 0
    listening = stored(out).numbers.listening
    assert listening.seconds == 1.5 and listening.rolled_mm == pytest.approx(450)
    assert listening.solved_mm == pytest.approx(0.2) and listening.impacts == 0
    samples, rate, comment = wav.read(out / "listen.wav")
    assert len(samples) == 1.5 * rate and "of which the first 0.2 mm" in comment
    assert "0.2 mm (0.044 % of the time) are solved" in stored(out).files.listen.content
    opened = open_run(out)
    # from the file of 24 bits, and made anew
    heard = long_record_of(opened)
    made = opened.long
    assert (
        heard is not None
        and heard is not made
        and "1.5 s over 450 mm" in describe_long_record(opened.stated(), heard)
    )
    full_scale = stored(out).files.listen.pascal_per_full_scale
    assert np.abs(heard.pressure - made.pressure).max() <= full_scale * 2**-23
    for words, reason in (
        (("--seconds", "1e9"), "allowed is 0.1 to 120"),
        (("--speed", "nan"), "speed: got nan"),
        (("--speed", "0:0"), "speed: got 0:0"),
        (("--speed", "200"), "2e+09 positions, allowed is up to 5e+08"),
    ):
        assert cli.main(["listen", str(out), *words]) == 2
        assert reason in capsys.readouterr().err
    before = {path.name for path in out.iterdir()}
    order = ["listen", str(out), "--seconds", "0.5", "--speed", "0.2:0.8"]
    files = []
    for seed in ("1", "1", "2"):
        assert cli.main([*order, "--seed", seed]) == 0
        files.append((out / "long.wav").read_bytes())
    assert files[0] == files[1] != files[2]
    said = capsys.readouterr()
    assert said.out == f"{out / 'long.wav'}\n" * 3 and "0.5 s over 250 mm" in said.err
    assert {path.name for path in out.iterdir()} - before == {"long.wav"}
    refuse_or_hear_a_room(out, order, capsys)
    (out / "listen.wav").unlink()
    os.mkfifo(out / "listen.wav")  # a pipe in its place is not waited for: the record is made anew
    assert long_record_of(opened) is made
