"""A run with a page keeps contiguous maps around its loudest event, and the page plays them."""

from __future__ import annotations

from dataclasses import replace

import h5py
import numpy as np
import pytest
import xarray
from report_browser import data_of, hear, until
from report_runs import run_results

from rolling.report import films
from rolling.simulation import result_file, slow_march
from rolling.simulation.simulate import Order

# Luminance of the canvas as it is shown, a value for every eighth pixel along and across.
LUMINANCE = """() => {
  const canvas = document.querySelector('#film'), width = 150;
  const height = Math.round(width * canvas.height / canvas.width);
  const pen = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  const slider = document.querySelector('#film-seek'), frames = [];
  const linear = (byte) => (byte <= 10 ? byte / 3294 : ((byte / 255 + 0.055) / 1.055) ** 2.4);
  for (let k = 0; k <= Number(slider.max); k++) {
    slider.value = k;
    slider.dispatchEvent(new Event('input'));
    pen.drawImage(canvas, 0, 0, width, height);
    const { data } = pen.getImageData(0, 0, width, height);
    frames.push(Array.from({ length: data.length / 4 }, (_, i) => 0.2126 * linear(data[4 * i])
      + 0.7152 * linear(data[4 * i + 1]) + 0.0722 * linear(data[4 * i + 2])));
  }
  const shown = canvas.getBoundingClientRect();
  return { frames, pixels: shown.width * shown.height };
}"""


def flashes(frames: np.ndarray) -> np.ndarray:
    """Count the flashes of each pixel: pairs of opposing changes by 0.1, the darker below 0.8."""
    low, high = frames[0].copy(), frames[0].copy()
    rising = np.zeros(low.shape, int)
    turns = np.zeros(low.shape, int)
    for frame in frames[1:]:
        low, high = np.minimum(low, frame), np.maximum(high, frame)
        up = (frame - low >= 0.1) & (low < 0.8) & (rising != 1)
        down = (high - frame >= 0.1) & (frame < 0.8) & (rising != -1)
        turns += up | down
        rising = np.where(up, 1, np.where(down, -1, rising))
        low, high = np.where(up | down, frame, low), np.where(up | down, frame, high)
    return turns // 2


def test_the_stretch_lies_around_the_loudest_event_and_costs_little(runs, monkeypatch) -> None:
    (run,) = run_results(runs.one())
    assert slow_march.stretch([run.scene], run.result) is None  # 5 % of 300 steps are too few
    monkeypatch.setattr(slow_march, "SHARE", 0.3)
    part = slow_march.stretch([run.scene], run.result)
    assert part is not None and part.stride == 1
    assert part.last - part.first + slow_march.COLD_STEPS <= 0.3 * run.result.solved_steps
    energy = run.result.series["release_energy"]
    event = np.convolve(energy, np.ones(10), "valid").argmax() + 5
    assert part.first <= event <= part.last
    partial = run_results(runs.partial())[0]
    assert slow_march.stretch([partial.scene], partial.result) is None
    (smooth,) = run_results(runs.smooth())
    assert slow_march.stretch([smooth.scene], smooth.result) is None


def test_the_loudest_place_is_the_middle_of_the_largest_mean() -> None:
    power = np.zeros(100)
    power[40:50] = 1.0
    power[70] = 5.0  # a single step
    assert slow_march.loudest(power, 10) == 45 or slow_march.loudest(power, 10) in range(66, 76)
    power[70] = 2.0
    assert slow_march.loudest(power, 10) == 45


def test_maps_release_what_the_run_released(runs) -> None:
    """The sum of each map of release is the release of the run's step, as far as 16 bits go."""
    folder = runs.filmed()
    result = result_file.load(folder / "result.h5")
    slow = result.slow_motion
    assert slow is not None and len(slow.positions) >= slow_march.FEWEST
    steps = result.series["release_energy"][slow.positions[0] : slow.positions[-1]]
    released = slow.release[1:].sum(axis=(1, 2)) * slow.release_unit
    assert released == pytest.approx(steps, rel=0.02)
    load = slow.pressure.sum(axis=(1, 2)) * slow.pressure_unit * slow.cell**2
    assert load == pytest.approx(np.ones(len(load)), rel=0.02)  # 1 N
    # The run's own map of a position in the stretch has the same pressures at the same place.
    position = next(p for p in sorted(result.maps) if p in slow.positions)
    own = result.maps[position]
    k = int(position) - slow.first
    i, j = (
        round((a - b) / slow.cell) for a, b in ((own.along, slow.along), (own.across, slow.across))
    )
    rows, columns = own.pressure.shape
    shown = slow.pressure[k, i : i + rows, j : j + columns] * slow.pressure_unit
    assert own.cell == pytest.approx(slow.cell)
    assert np.abs(shown - own.pressure).max() < 0.02 * own.pressure.max()


def test_the_file_opens_in_xarray_in_pascals_and_refuses_damage(runs, tmp_path) -> None:
    folder = runs.filmed()
    result = result_file.load(folder / "result.h5")
    tree = xarray.open_datatree(folder / "result.h5", engine="h5netcdf")
    slow = result.slow_motion
    assert slow is not None
    pressure = tree["slow_motion/pressure"]
    assert pressure.dims == ("map_position", "along", "across")
    assert float(pressure.max()) == pytest.approx(255 * slow.pressure_unit)
    assert tree["slow_motion/release"].attrs["units"] == "J"
    tree.close()
    for change, words in (
        (lambda group: group["map_position"].__setitem__(3, 1), "slow_motion/map_position"),
        (lambda group: group.attrs.__setitem__("cell_m", -1.0), "slow_motion/cell_m"),
        (
            lambda group: group["release"].attrs.__setitem__("scale_factor", np.nan),
            "slow_motion/release: scale_factor",
        ),
    ):
        path = tmp_path / "result.h5"
        path.write_bytes((folder / "result.h5").read_bytes().rpartition(b"\nrolling")[0])
        with h5py.File(path, "a") as file:
            change(file["slow_motion"])
            with pytest.raises(result_file._result_reading.Damage, match=words):
                result_file._result_reading.read(file)


def test_runs_without_a_page_have_none(runs) -> None:
    result = result_file.load(runs.lap() / "result.h5")
    assert result.slow_motion is None


def test_a_contact_that_cannot_be_solved_leaves_the_run_whole(runs, monkeypatch) -> None:
    (run,) = run_results(runs.one())
    monkeypatch.setattr(slow_march, "SHARE", 0.3)
    part = slow_march.stretch([run.scene], run.result)
    assert part is not None
    hopeless = run.scene.with_(load_n=1e6)
    slow = slow_march.march_stretch(hopeless, part, Order(), lambda: False, lambda _: None)
    assert slow.pressure.size == 0
    without = replace(run, result=replace(run.result, slow_motion=slow))
    assert films.film_of(without, 2.1) is None


def test_the_page_plays_the_film_once_and_scrubs_it(pages, opened) -> None:
    path = pages("filmed")
    film = data_of(path)["runs"][0]["film"]
    last = len(film["times"]) - 1
    with opened(path) as page:
        loudest = int(np.argmax(film["power_uw"]))
        assert int(page.input_value("#film-seek")) == loudest
        assert f"{1e3 * film['times'][loudest]:.3f} ms" in page.text_content("#film-time")
        milliseconds = 1e3 * (film["times"][-1] - film["times"][0])
        said = page.text_content("#film-length")
        assert said == f"It shows {milliseconds:.2g} ms of the record in {last + 1} maps."
        until(page, "tap.images.every((image) => image.complete)")
        shown = page.evaluate(LUMINANCE)
        frames = np.array(shown["frames"])
        assert np.abs(np.diff(frames, axis=0)).max(axis=1).min() > 0.05  # every map moves
        # The film may pass within a second: at most three flashes on more than 21,824 px.
        assert (flashes(frames) > 3).mean() * shown["pixels"] < 21824
        page.evaluate(
            "() => { const s = document.querySelector('#film-seek'); s.value = 0;"
            " s.dispatchEvent(new Event('input')); }"
        )
        page.click("#film-play")
        until(
            page,
            "document.querySelector('#film-play').textContent === 'Play slowly'"
            f" && document.querySelector('#film-seek').value === '{last}'",
        )
        hear(page)
        assert page.input_value("#film-seek") == str(last)  # it does not begin again
        source = page.evaluate("tap.sources.map((s) => s.playbackRate.value)")
        assert source == pytest.approx([1e-3])
        page.click("#film-real")
        until(page, "tap.starts === 2")  # the whole record of 6 ms
        assert page.evaluate("tap.sources.at(-1).buffer.length") == 288


def test_reduced_motion_leaves_the_slider_alone(pages, opened) -> None:
    with opened(pages("filmed"), reduced_motion="reduce") as page:
        assert not page.locator("#film-play").is_visible()
        assert page.locator(".motion-unwanted").is_visible()
        page.locator("#film-seek").focus()
        before = page.text_content("#film-time")
        page.keyboard.press("ArrowRight")
        assert page.text_content("#film-time") != before


def test_flashes_are_counted_as_pairs_of_changes() -> None:
    blinking = np.tile([[0.0], [0.5]], (4, 1))  # up and down, up and down, ...
    assert flashes(blinking).tolist() == [3]
    assert flashes(np.linspace(0, 1, 50)[:, None]).tolist() == [0]
