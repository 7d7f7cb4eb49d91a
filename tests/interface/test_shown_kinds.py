"""Runs of every kind of scene are drawn, heard and shown by the same code."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
import soundfile
from bearing_runs import turning
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydantic import Field
from report_runs import runs_of

from acoustics import wav
from rolling import plot
from rolling.figures.catalogue import figures_of, names_of, plot_run
from rolling.kinds import registry
from rolling.kinds.heard_sound import PlainSound, common_gains, plain_gains
from rolling.kinds.kind import Kind
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import RunFolder
from rolling.kinds.shown_run import ShownRun
from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.fields import group, number
from rolling.numbers.file_facts import BearingFiles, SoundFacts
from rolling.numbers.quantity import Quantity
from rolling.report.gallery import gallery_page
from rolling.report.report_page import page as page_of
from rolling.scene.swept import SweptScene
from rolling.terminal.streams import unbroken

KINDS = ["ball", "bearing"]


def run_of_kind(kind: str) -> Any:
    """Return a run in memory of a kind."""
    return turning() if kind == "bearing" else runs_of("three")[0]


# ---- figures


@pytest.mark.parametrize("kind", KINDS)
def test_every_figure_of_a_kind_is_drawn_by_its_name(kind: str, tmp_path: Path) -> None:
    """By `plot_run`, by the method of the run, and where it has a table as CSV."""
    run = run_of_kind(kind)
    names = names_of([run])
    tabulated = [name for name in names if figures_of([run])[name].table is not None]
    assert len(names) >= 4 and len(tabulated) >= 3
    first = names[0]
    assert [path.name for path in plot_run(run, [first], "svg", tmp_path)] == [f"{first}.svg"]
    assert len(plot_run(run, form="csv", out=tmp_path)) == len(tabulated)
    ax = Figure().subplots()
    assert run.plot(first, ax) is ax and ax.get_title("left")
    assert isinstance(run.plot(ax=Figure().subplots()), Axes)


@pytest.mark.parametrize("kind", KINDS)
def test_a_figure_of_another_kind_is_refused_with_those_of_the_run(kind: str) -> None:
    other = {"ball": "ball_forces", "bearing": "contact_pressure"}[kind]
    own = {"ball": "contact_pressure", "bearing": "ball_forces"}[kind]
    with pytest.raises(ValueError, match=f"{other}: no figure of these runs.* allowed: .*{own}"):
        run_of_kind(kind).plot(other)


@pytest.mark.parametrize("kind", KINDS)
def test_the_spectrum_is_that_of_the_kind(kind: str) -> None:
    ax = plot.spectrum(run_of_kind(kind), Figure().subplots())
    assert ("velocity" if kind == "bearing" else "level") in ax.get_ylabel()


def test_runs_of_two_kinds_have_no_common_figure() -> None:
    with pytest.raises(ValueError, match="got ball, bearing, allowed: runs of one kind"):
        plot_run([run_of_kind(kind) for kind in KINDS])


def test_two_bearings_have_a_figure_each(tmp_path: Path) -> None:
    runs = [replace(turning(), label=label) for label in ("a", "b")]
    paths = plot_run(runs, ["envelope"], "csv", tmp_path)
    assert [path.name for path in paths] == ["envelope-a.csv", "envelope-b.csv"]
    with pytest.raises(ValueError, match="spectrum: got 2 runs, allowed: one run"):
        plot.spectrum(runs)


def test_a_load_distribution_stands_on_any_axes() -> None:
    """Polar axes have the angle around, others along."""
    figure = Figure()
    straight = turning().plot("load_distribution", figure.add_subplot(121))
    polar = turning().plot("load_distribution", figure.add_subplot(122, projection="polar"))
    assert straight.get_xlim() == (0, 360) and polar.name == "polar"
    assert turning().plot("load_distribution").name == "polar"


# ---- sounds


@pytest.mark.parametrize("kind", KINDS)
def test_a_common_gain_scales_the_same_samples(kind: str) -> None:
    """Samples over gain are the record, within half a step of 24 bits, at any gain."""
    run = run_of_kind(kind)
    (sound, *_) = kind_of(run.scene).sounds(run)
    assert sound.file == "listen.wav"
    gain = wav.listening_gain(sound.samples) / 3
    samples, _ = soundfile.read(io.BytesIO(sound.wav(gain)))
    written = samples / gain
    assert np.abs(written[: len(sound.samples)] - sound.samples[: len(written)]).max() < (
        2**-23 / gain
    )


def test_gains_of_plain_files_are_the_least_of_each_group() -> None:
    """A full scale of 4 m/s2 is the loudest of two rings; a housing has a gain of its own."""

    def facts(own: float, unit: str) -> SoundFacts:
        return SoundFacts(duration_s=1.0, unit=unit, own_full_scale=own, full_scale=own)

    loud = BearingFiles(listen=facts(4.0, "m/s2"), housing=facts(0.5, "Pa"))
    quiet = BearingFiles(listen=facts(2.0, "m/s2"), housing=facts(0.8, "Pa"))
    gains = [gain for files in (loud, quiet) for gain in plain_gains(files)]
    assert common_gains(gains) == {"listen": 0.25, "housing": 1.25}
    assert {gain.file for gain in gains} == {"listen.wav", "housing.wav"}


@pytest.mark.parametrize("kind", KINDS)
def test_a_script_names_the_sound_that_it_plays(kind: str, capsys) -> None:
    assert run_of_kind(kind).play() is None
    printed = capsys.readouterr().out
    path = Path(printed.split("   ")[0].removeprefix("listen: ").strip())
    assert soundfile.info(path).frames > 0
    path.unlink()


# ---- cards and pages


def test_bearings_and_balls_stand_on_one_gallery(tmp_path: Path) -> None:
    """Equal loudness holds for all; each unit has a full scale of its own."""
    runs = [turning(), *runs_of("filmed"), replace(turning(), label="again")]
    page = gallery_page(iter(runs), len(runs), tmp_path).decode()
    assert page.count('class="card"') == 3 and page.count("<audio") == 3
    assert "acceleration of the outer ring" in page and "velocities of the ring" in page
    gains = [float(text) for text in re.findall(r'data-calibrated="([^"]+)"', page)]
    assert gains == pytest.approx([1, 1, 1])


@pytest.mark.parametrize("kind", KINDS)
def test_all_pages_have_the_same_sections(kind: str) -> None:
    page = page_of([run_of_kind(kind)]).decode()
    for id in ("doubts", "notes", "again", "levels-table"):
        assert page.count(f'id="{id}"') == 1, id
    assert page.count("<h1>") == 1 and "Not shown" not in page
    assert "Not shown:</strong> later" in page_of([run_of_kind(kind)], ["later"]).decode()


def test_a_page_has_runs_of_one_kind() -> None:
    with pytest.raises(ValueError, match="got ball, bearing, allowed: runs of one kind"):
        page_of([run_of_kind(kind) for kind in KINDS])


def test_a_page_of_very_many_bearings_has_their_numbers_alone() -> None:
    runs = [replace(turning(), label=f"run {number}") for number in range(25)]
    page = page_of(runs).decode()
    assert page.count("run 24") >= 2 and "<audio" not in page and len(page) < 200_000


@dataclass(frozen=True, kw_only=True)
class BellNumbers:
    """Numbers of a bell."""

    strike: Quantity = group("how hard it is struck")
    turns: float = number("turns of the wheel", "1", in_table=True, word="turns of the wheel")
    doubts: tuple[Doubt, ...] = ()


class BellScene(SweptScene):
    """Scene of a bell."""

    SECTION: ClassVar[str] = "bell"
    TITLE: ClassVar[str] = "Bell"
    name: str = "bell"
    title: str | None = "A bell of <bronze>"
    sweep: dict[str, Any] = Field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class BellRun(RunFolder, ShownRun):
    """Run of a bell."""

    label: str
    numbers: BellNumbers
    stored: None = None


class Bells(Kind):
    """A kind that gives numbers and a sound, and nothing that shows them."""

    name = "bell"
    scene_type = BellScene
    description = "A bell."
    stored_type = BellNumbers

    def sounds(self, run: Any) -> list[PlainSound]:
        tone = 0.1 * np.sin(2 * np.pi * 500 * np.arange(4800) / 48000)
        return [PlainSound("listen.wav", "Pa", "bell", tone, heard="the bell", title="bell")]


Bells.__abstractmethods__ = frozenset()  # those of folders and marches are not called here


def test_a_registered_kind_has_page_card_and_sound_from_defaults(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys
) -> None:
    monkeypatch.setattr(registry, "_added", dict(registry._added))
    registry.register(Bells())
    doubt = Doubt("cracked", "the bell is cracked", Severity.INDICATIVE, about=("strike",))
    strike = Quantity(name="strike", unit="N", value=12.0, how="computed", doubts=(doubt,))
    numbers = BellNumbers(strike=strike, turns=3.0, doubts=(doubt,))
    run = BellRun({}, BellScene(name="bell"), tmp_path, label="", numbers=numbers)
    page = page_of([run]).decode()
    assert "<h1>A bell of &lt;bronze&gt;</h1>" in page and "<b>12.0</b>" in page
    assert "Strike is indicative: the bell is cracked." in page
    # 0.1 of a sine of 500 Hz has 71.0 dB less 3.2 dB of the A-weighting
    told = "the bell, LAeq 67.7 dB(A)"
    assert f"{told}, 0.1 s; full scale " in page and page.count("<audio") == 1
    assert "turns of the wheel" in page and "rolling run bell.yaml" in page
    card = gallery_page(iter([run]), 1, tmp_path).decode()
    assert unbroken(f"You hear: {told}.") in card and card.count("<audio") == 1
    assert names_of([run]) == []
    with pytest.raises(ValueError, match=r"no figure of these runs.*none"):
        run.plot("plot")
    assert run.play() is None and "the bell" in capsys.readouterr().out
