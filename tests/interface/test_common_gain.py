"""The runs of a sweep share one gain in listen.wav, whatever the order in which they ended."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import contents, words_of
from made_numbers import blank, changed
from scene_text import TINY

from acoustics import wav
from acoustics.level import laeq_db
from rolling import cli
from rolling.kinds.heard_sound import common_gains
from rolling.numbers.run_file import StoredNumbers
from rolling.results.listening import listen_gains
from rolling.results.stored_numbers import read_stored, write_stored

LOADS = TINY + "sweep: {rolling.load_n: [0.005, 0.02]}\n"
FIRST = TINY + "sweep: {rolling.load_n: [0.005]}\n"
FIXED = TINY + "sound: {gain_pa_per_w_m2: 30}\n"


def write(folder: Path, text: str) -> Path:
    path = folder / "scene.yaml"
    path.write_text(text)
    return path


def run(scene: Path, out: Path, *more: str) -> int:
    return cli.main(words_of(scene, out, "--workers", "1", *more))


def summary(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text())


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("swept")
    assert run(write(folder, LOADS), folder / "out") == 0
    return folder / "out"


def listened(folder: Path, file: str = "listen") -> dict:
    return summary(folder)["files"][file]


@pytest.mark.law("listening: a louder run of a sweep is louder in its files, by its LAeq.")
@pytest.mark.parametrize(
    ("file", "quantity"), [("listen", "vibration"), ("released", "released_power")]
)
def test_a_louder_run_sounds_louder(file: str, quantity: str, swept: Path) -> None:
    """Levels of the files differ as those that are stated do, within the rounding to 24 bits."""
    heard = []
    stated = []
    for folder in sorted(swept.glob("load_n=*")):
        samples, rate, comment = wav.read(folder / f"{file}.wav")
        heard.append(laeq_db(samples, rate))
        stated.append(summary(folder)[quantity]["value"])
        facts = listened(folder, file)
        assert facts["rule"] == "the common gain of its sweep" and facts["rule"] in comment
        assert facts["common_gain_full_scale_per_pa"] == facts["gain_full_scale_per_pa"]
        assert facts["gain_full_scale_per_pa"] <= facts["own_gain_full_scale_per_pa"]
    assert len(heard) == 2 and abs(stated[1] - stated[0]) > 1
    # Laps are cross-faded at their LAeq.
    assert heard[1] - heard[0] == pytest.approx(stated[1] - stated[0], abs=0.05)


@pytest.mark.law("listening: listen.wav of a sweep does not depend on the order of its runs.")
@pytest.mark.parametrize(
    "order", [pytest.param("workers", marks=pytest.mark.slow), "grown", "reversed parts"]
)
def test_the_bytes_do_not_depend_on_the_order(order: str, swept: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    scene = write(tmp_path, LOADS)
    if order == "workers":
        words = ["run", str(scene), "--out", str(out), "--workers", "2", "--no-report", "-q"]
        assert cli.main(words) == 0
    elif order == "grown":
        (tmp_path / "first").mkdir()
        assert run(write(tmp_path / "first", FIRST), out) == 0
        alone = contents(out)
        assert run(scene, out) == 0
        own = listened(out / "load_n=0.005")["own_gain_full_scale_per_pa"]
        assert f"{own:.6g} full scale per Pa".encode() in alone["load_n=0.005/listen.wav"]
    else:
        assert run(scene, out, "--part", "2/2") == 0
        assert run(scene, out, "--part", "1/2") == 0
    assert contents(out) == contents(swept)


def test_a_command_that_was_killed_while_it_wrote_is_finished(swept: Path, tmp_path: Path) -> None:
    """A file with its own gain, or a summary that names it, is written again by the command."""
    out = tmp_path / "out"
    scene = write(tmp_path, LOADS)
    assert run(scene, out) == 0
    quiet = out / "load_n=0.005"
    whole = read_stored(quiet)
    listen = replace(whole.files.listen, common_gain_full_scale_per_pa=None)
    write_stored(quiet, replace(whole, files=replace(whole.files, listen=listen)))
    (out / "load_n=0.02" / "listen.wav").unlink()
    assert run(scene, out) == 0
    assert contents(out) == contents(swept)
    assert read_stored(quiet).files == whole.files
    stamps = [path.stat().st_mtime_ns for path in sorted(out.glob("*/listen.wav"))]
    assert run(scene, out) == 0
    assert stamps == [path.stat().st_mtime_ns for path in sorted(out.glob("*/listen.wav"))]


@pytest.mark.parametrize("text", [TINY, FIXED], ids=["release", "fixed gain"])
def test_a_single_run_keeps_its_own_gain(text: str, tmp_path: Path) -> None:
    assert run(write(tmp_path, text), tmp_path / "out") == 0
    facts = listened(tmp_path / "out")
    assert facts["common_gain_full_scale_per_pa"] is None
    assert facts["gain_full_scale_per_pa"] == facts["own_gain_full_scale_per_pa"]
    assert facts["rule"] in ("equal loudness", "the largest gain")


def test_silence_and_other_sources_do_not_share_the_gain() -> None:
    """The gain is the minimum of the sounding runs of a source: none clips."""

    def a_run(source: str, gain: float, rule: str = "equal loudness") -> StoredNumbers:
        listen = {"own_gain_full_scale_per_pa": gain, "rule": rule}
        numbers = {"record": {"source": source}}
        return changed(blank(StoredNumbers), {"files": {"listen": listen}, "numbers": numbers})

    runs = [
        a_run("release", 3.0),
        a_run("release", 2.0),
        a_run("release", 1.0, "silence"),
        a_run("vibration", 900.0),
        a_run("vibration", 4000.0),
    ]

    def gains(stored: Sequence[StoredNumbers]) -> dict[str, float]:
        return common_gains(file for one in stored for file in listen_gains(one))

    assert gains(runs) == {"release": 2.0, "vibration": 900.0}
    assert gains(runs[::-1]) == gains(runs)
    assert gains([a_run("release", 1.0, "silence")]) == {}


def test_a_run_far_below_the_others_says_that_it_may_be_inaudible(tmp_path: Path) -> None:
    """At 1000 times the distance a run is 60 dB quieter; the largest gain may leave less."""
    text = TINY + "sweep: {sound.distance_m: [0.1, 100]}\n"
    assert run(write(tmp_path, text), tmp_path / "out") == 0
    out = tmp_path / "out"
    near, far = (listened(out / f"distance_m={d}", "released") for d in ("0.1", "100"))
    assert "may not hear" not in near["meaning"]
    lowered = far["own_gain_full_scale_per_pa"] / far["gain_full_scale_per_pa"]
    lowered_db = 20 * np.log10(lowered)
    assert lowered_db > 30
    assert f"{lowered_db:.0f} dB below" in far["meaning"] and "you may not hear" in far["meaning"]
