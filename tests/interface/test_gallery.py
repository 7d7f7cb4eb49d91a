"""The gallery shows many runs on one page, of which one sounds at a time."""

from __future__ import annotations

import base64
import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import soundfile
from bearing_runs import turning
from commands import rolling
from PIL import Image
from report_browser import axe_findings, data_of, until
from report_runs import runs_of

from rolling.report.gallery import gallery_page
from rolling.results.listening import ListenSound

PHONE = {"width": 390, "height": 844}


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a gallery of runs with a film, with maps only, and without sound, one with a page."""
    folder = tmp_path_factory.mktemp("gallery") / "a #1 gallery"
    home = folder / "runs & more?"
    home.mkdir(parents=True)
    (home / "report.html").write_text("the page")
    runs = runs_of("filmed", "flying", "three", "smooth")
    runs[0] = replace(runs[0], folder=home, label='<b> "quoted"')
    (folder / "gallery.html").write_bytes(gallery_page(iter(runs), len(runs), folder, ["waiting"]))
    return folder / "gallery.html"


def records(path: Path) -> list[np.ndarray]:
    """Return the samples of the sounds of a page."""
    found = re.findall(r'src="data:audio/\w+;base64,([^"]+)"', path.read_text())
    return [soundfile.read(io.BytesIO(base64.b64decode(text)))[0] for text in found]


def test_cards_have_drawing_sound_level_and_sentence(path: Path, opened) -> None:
    with opened(path, viewport=PHONE) as page:
        assert page.locator(".card").count() == 7
        assert page.locator(".card audio").count() == 6  # one run is silent
        assert page.locator(".card svg.machine").count() == 7
        assert page.locator(".card img.field").count() == 7
        assert page.locator(".card .said .two b").count() >= 7
        assert page.evaluate("document.scrollingElement.scrollWidth") <= 390
        assert page.inner_text("h2 small >> nth=0").replace("\xa0", " ") == '<b> "quoted"'
        assert "waiting" in page.text_content(".notice")
        link = page.locator(".card a")
        assert link.count() == 1
        report = path.parent / "runs & more?" / "report.html"
        assert link.evaluate("a => a.href") == report.as_uri()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(scheme: str, path: Path, opened) -> None:
    with opened(path, viewport=PHONE, color_scheme=scheme) as page:
        assert axe_findings(page) == []


def test_one_sounds_at_a_time_with_equal_or_calibrated_gain(path: Path, opened) -> None:
    """Volumes turn the sounds into equal levels, or into one full scale: 20 lg of their ratio."""
    volumes = "[...document.querySelectorAll('audio')].map((player) => player.volume)"
    playing = "[...document.querySelectorAll('audio')].filter((player) => !player.paused).length"
    with opened(path) as page:
        equal = np.array(page.evaluate(volumes))
        page.check("input[value=calibrated]")
        calibrated = np.array(page.evaluate(volumes))
        for number in range(3):
            page.locator("audio").nth(number).evaluate("player => player.play()")
            until(page, f"{playing} === 1")
    sounding = runs_of("filmed", "flying", "three", "smooth")[:6]
    levels = np.array([run.stated().level.level_db for run in sounding])
    assert 0 < equal.max() <= 1 and calibrated.max() == pytest.approx(1)
    # A volume is a single-precision number.
    assert np.ptp(20 * np.log10(calibrated / equal) - levels) < 1e-3


@pytest.mark.slow
def test_sounds_begin_like_the_record_and_stay_short(path: Path) -> None:
    """The MP3 follows the record, apart from the band above 19 kHz, 20 dB below the whole."""
    (filmed, *_), (sound, *_) = runs_of("filmed"), records(path)
    record = ListenSound(filmed).samples[:20000]
    sound = sound[:20000] * (record @ sound[:20000]) / (sound[:20000] @ sound[:20000])
    assert np.std(sound - record) < 0.1 * np.std(record)
    assert all(len(samples) <= 8.1 * 48000 for samples in records(path))
    many = gallery_page((runs_of("one")[0] for _ in range(100)), 100, path.parent)
    assert len(many) < 8e6


def test_pictures_show_the_surface_under_the_contact(path: Path) -> None:
    """Pixels of a film are grey on the bare surface, and coloured where the contact is."""
    source = re.search(r'src="data:image/png;base64,([^"]+)"', path.read_text())
    pixels = np.asarray(Image.open(io.BytesIO(base64.b64decode(source[1]))).convert("RGB"))
    slow = runs_of("filmed")[0].result.slow_motion
    nodes = pixels.shape[0] // slow.pressure.shape[2]
    loudest = int(np.argmax(slow.release.sum(axis=(1, 2), dtype=np.int64)))
    cells = np.ptp(pixels[::nodes, ::nodes].astype(int), axis=2).T[:, ::-1] > 0
    touched = (slow.pressure[loudest] > 0) | (slow.release[loudest] > 0)
    assert not (cells & ~touched).any()
    assert (cells & touched).sum() > 0.8 * touched.sum()  # faint releases stay grey


def test_without_scripts_it_plays_and_without_folders_it_says_what_to_give(
    path: Path, browser, tmp_path: Path
) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(path.as_uri())
    assert page.locator("audio >> visible=true").count() == 6
    assert not page.locator(".modes").is_visible()
    context.close()
    done = rolling(["gallery"], tmp_path)
    assert done.returncode == 2 and "required: RUN" in done.stderr
    done = rolling(["gallery", "nothing"], tmp_path)
    assert done.returncode == 2 and not [*tmp_path.iterdir()]
    done = rolling(["gallery", "nothing", "--out", "cards"], tmp_path)
    assert done.returncode == 2 and "cards.html" in done.stderr


def test_a_card_says_what_to_listen_for_as_the_scene_says_it(tmp_path: Path) -> None:
    (run,) = runs_of("smooth")
    words = "a <tick>\n  once per turn."
    told = replace(run, scene=run.scene.model_copy(update={"listen_for": words}))
    page = gallery_page(iter([told, run]), 2, tmp_path).decode()
    assert page.count("<p>Listen for a &lt;tick&gt; once per turn.</p>") == 1
    assert page.count("Listen for") == 1


def test_a_gallery_is_a_page_of_parts(tmp_path: Path) -> None:
    """Each drawing has ids of its own, and a bearing shows its spectrum as a chart."""
    runs = [*runs_of("smooth"), turning(), turning()]
    path = tmp_path / "gallery.html"
    path.write_bytes(gallery_page(iter(runs), 3, tmp_path))
    content = path.read_text()
    ids = re.findall(r' id="([^"]+)"', content)
    assert len(ids) == len({*ids}) and content.count('<svg class="machine"') == 3
    assert [chart["name"] for chart in data_of(path)["charts"]] == ["spectrum", "spectrum"]
    assert content.count('<img class="field"') == 1 == content.count("<img")
