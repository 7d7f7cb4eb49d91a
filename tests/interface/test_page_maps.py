"""Maps, playheads and films of the page follow the time that it plays, and keys control it."""

from __future__ import annotations

import numpy as np
import pytest
from report_browser import PIXELS, data_of, hear, map_of, play, seek, time_of, until
from report_runs import runs_of

from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.kinds.registry import kind_of
from rolling.report import film
from rolling.report.maps import lens, palette
from rolling.results.run_result import Run

FLASHING_PX = 21824  # on which WCAG 2.3.1 allows more than three flashes a second
# Luminance of the canvas as it is shown, a value for every eighth pixel along and across, as text:
# a million numbers one by one take seconds.
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
    const channel = (i, k) => linear(data[4 * i + k]);
    frames.push(Array.from({ length: data.length / 4 }, (_, i) => (0.2126 * channel(i, 0)
      + 0.7152 * channel(i, 1) + 0.0722 * channel(i, 2)).toFixed(4)).join(' '));
  }
  const shown = canvas.getBoundingClientRect();
  return { frames, pixels: shown.width * shown.height };
}"""
# Keeps the map that is shown after each step of the film, with the time that the step has read.
FRAMES = """() => {
  const next = window.requestAnimationFrame.bind(window);
  const slider = document.querySelector('#film-seek');
  const keep = ({ prototype }, name) => {
    const { get } = Object.getOwnPropertyDescriptor(prototype, name);
    Object.defineProperty(prototype, name, { get() { return (tap[name] = get.call(this)); } });
  };
  keep(BaseAudioContext, 'currentTime');
  keep(AudioContext, 'outputLatency');
  tap.frames = [];
  window.requestAnimationFrame = (act) => next((now) => {
    tap.currentTime = null;
    act(now);
    if (!String(act).includes('tickFilm') || tap.currentTime === null) return; // paused
    tap.frames.push([Number(slider.value), tap.currentTime - (tap.outputLatency || 0)]);
    // A slow browser may be at the end by the next frame.
    if (Number(slider.value) > 20 && !tap.before) {
      tap.before = tap.frames.length;
      document.querySelector('#film-play').click(); // pause
    }
  });
}"""
SEEK_FILM = """(n) => {
  const slider = document.querySelector('#film-seek');
  slider.value = n;
  slider.dispatchEvent(new Event('input'));
}"""


def nearest_map(run: Run, seconds: float) -> int:
    """Return the nearest kept position on the closed lap at 0.1 m/s."""
    lap = run.result.solved_steps * run.result.step
    places = np.array(sorted(run.result.maps)) * run.result.step
    away = np.abs(places - 0.1 * seconds % lap)
    return int(np.argmin(np.minimum(away, lap - away)))


def test_the_map_follows_the_playhead_and_shows_the_stored_pressure(pages, opened) -> None:
    path = pages("three")
    run = runs_of("three")[1]
    view = data_of(path)["view"]
    middle = 49.5 * 2e-6
    maps = [run.result.maps[position] for position in sorted(run.result.maps)]
    with opened(path) as page:
        page.check("input[name=run][value='1']")
        canvas = page.locator("#map")
        for seconds in (0.0, 0.00141, 0.0051, 0.00599, 0.8765):
            seek(page, seconds)
            number = map_of(page)
            assert number == nearest_map(run, seconds), seconds
            shown = maps[number]
            pressure = float(page.text_content("#map-pressure").split()[0])
            assert pressure == pytest.approx(shown.pressure.max() * 1e-9, rel=1e-3)
            width = canvas.evaluate("c => c.width")
            per_m = width / (2e-6 * view["half_um"])
            circle = smooth_contact_of(run.scene).semi_axes_m()[0] * per_m
            cells = []
            places = []
            for i, j in np.argwhere(shown.pressure > 0)[::20]:
                x = width / 2 + (shown.along + (i + 0.5) * shown.cell - shown.distance) * per_m
                y = width / 2 - (shown.across + (j + 0.5) * shown.cell - middle) * per_m
                radius = np.hypot(x - width / 2, y - width / 2)
                if abs(radius - circle) > 4:  # not under the dashed circle
                    cells.append((i, j))
                    places.append((x, y))
            assert len(cells) > 5
            for (i, j), pixel in zip(cells, canvas.evaluate(PIXELS, places), strict=True):
                shade = 1 + round(254 * float(shown.pressure[i, j]) / 2.1e9)
                assert pixel == palette(ends_at_hardness=True)[shade].tolist(), (seconds, i, j)


@pytest.mark.parametrize("wish", ["no-preference", "reduce"])
def test_maps_move_while_it_plays_unless_motion_is_unwanted(wish: str, pages, opened) -> None:
    with opened(pages("three"), reduced_motion=wish) as page:
        page.evaluate("""() => {
          window.drawn = new Set();
          const fill = CanvasRenderingContext2D.prototype.fillRect;
          CanvasRenderingContext2D.prototype.fillRect = function (...place) {
            if (this.canvas.id === 'map') drawn.add(tap.now);
            return fill.call(this, ...place);
          };
        }""")
        play(page)
        page.evaluate("drawn.clear()")
        if wish == "reduce":
            hear(page, 0.8)
            assert page.evaluate("drawn.size") == 0
        else:
            until(page, "drawn.size >= 3")
            # A map stays for 0.4 s, long enough to be seen.
            assert np.diff(page.evaluate("[...drawn]")).min() >= 400
        page.click("#play")  # paused: the map of its place
        until(page, "document.querySelector('#play').textContent === 'Play'")
        assert map_of(page) == nearest_map(runs_of("three")[0], float(page.input_value("#seek")))


def test_keys_act_as_the_page_states(pages, opened) -> None:
    with opened(pages("three")) as page:
        press = page.keyboard.press
        press("Space")
        until(page, "parseFloat(document.querySelector('#seek').value) > 0.02")
        assert page.text_content("#play") == "Pause"
        press("Space")
        assert page.text_content("#play") == "Play"
        seek(page, 0.2)
        press("ArrowRight")
        assert time_of(page) == pytest.approx(0.245)
        press("3")
        assert page.is_checked("input[name=run][value='2']") and page.input_value("#choose") == "2"
        press("9")  # there is none
        assert page.input_value("#choose") == "2"
        page.locator("#map-seek").focus()  # a focused control keeps its own keys
        before = map_of(page)
        press("ArrowRight")
        assert map_of(page) == (before + 1) % 120


def contact_shapes() -> dict[str, np.ndarray]:
    """Return pressures of a disk, a line, two far points, one cell, and a wide flat contact."""
    x, y = np.mgrid[:96, :96]
    points = np.zeros((96, 90))
    points[2, 3] = 1.0
    points[93, 80] = 2.0
    return {
        "disk": np.where(np.hypot(x - 48, y - 48) < 47, 1.0, 0.0),
        "line": np.where(y[:, :3] == 1, 1.0 + x[:, :3], 0.0),
        "points": points,
        "cell": np.ones((1, 1)),
        "flat": np.ones((96, 20)),
    }


@pytest.mark.parametrize("name", contact_shapes())
def test_the_lens_shows_the_highest_pressure_of_any_shape(name: str) -> None:
    """The contact fills 4 % of the lens, or the lens is 8 to 12 cells wide.

    A width is rounded up by a step of the root of 2 at most.
    """
    pressure = contact_shapes()[name]
    cell = 3.0
    left = -40.0
    top = 70.0
    x, y, width = lens(pressure, (left, top, cell))
    rows, columns = np.indices(pressure.shape)
    across = top - (pressure.shape[1] - columns - 0.5) * cell
    away = np.hypot(left + (rows + 0.5) * cell - x, across - y)
    assert away.ravel()[np.argmax(pressure)] < width / 2
    share = ((away < width / 2) & (pressure > 0)).sum() * cell**2 / (np.pi / 4 * width**2)
    assert share >= 0.039 or 8 * cell <= width <= 12 * cell


# ---- film


def flashes(frames: np.ndarray) -> np.ndarray:
    """Count the flashes of each pixel: pairs of opposing changes by 0.1, the darker below 0.8."""
    low = frames[0].copy()
    high = frames[0].copy()
    rising = np.zeros(low.shape, int)
    turns = np.zeros(low.shape, int)
    for frame in frames[1:]:
        low = np.minimum(low, frame)
        high = np.maximum(high, frame)
        up = (frame - low >= 0.1) & (low < 0.8) & (rising != 1)
        down = (high - frame >= 0.1) & (frame < 0.8) & (rising != -1)
        turns += up | down
        rising = np.where(up, 1, np.where(down, -1, rising))
        low = np.where(up | down, frame, low)
        high = np.where(up | down, frame, high)
    return turns // 2


def shown_film(page) -> tuple[np.ndarray, float]:
    """Return the luminance of each map of the film, shape (maps, places), and its pixels."""
    shown = page.evaluate(LUMINANCE)
    return np.array([np.fromstring(row, sep=" ") for row in shown["frames"]]), shown["pixels"]


def test_flashes_are_counted_as_pairs_of_changes() -> None:
    assert flashes(np.tile([[0.0], [0.5]], (4, 1))).tolist() == [3]  # up and down, up and down, ...
    assert flashes(np.linspace(0, 1, 50)[:, None]).tolist() == [0]


def test_the_film_plays_once_and_follows_its_slider(pages, opened) -> None:
    path = pages("filmed")
    film = data_of(path)["runs"][0]["film"]
    last = len(film["times"]) - 1
    loudest = film["loudest"]
    with opened(path) as page:
        assert int(page.input_value("#film-seek")) == loudest
        assert f"{1e3 * film['times'][loudest]:.3f} ms" in page.text_content("#film-time")
        until(page, "tap.images.every((image) => image.complete)")
        frames, pixels = shown_film(page)
        assert np.abs(np.diff(frames, axis=0)).max(axis=1).min() > 0.05  # every map moves
        # The film may pass within a second: at most three flashes on more than 21,824 px.
        assert (flashes(frames) > 3).mean() * pixels < FLASHING_PX
        page.evaluate(SEEK_FILM, 0)
        page.select_option("#film-rate", "1000")
        page.click("#film-play")
        ended = f"document.querySelector('#film-seek').value === '{last}'"
        button = "document.querySelector('#film-play').textContent === 'Play 1000 times slower'"
        until(page, f"{button} && {ended}")
        hear(page)
        assert page.input_value("#film-seek") == str(last)  # it does not begin again
        rates = page.evaluate("tap.sources.map((s) => s.playbackRate.value)")
        assert rates == pytest.approx([1e-3])
        page.click("#film-real")
        until(page, "tap.starts === 2")  # the whole record of 6 ms
        assert page.evaluate("tap.sources.at(-1).buffer.length") == 288


def test_the_film_shows_the_map_that_is_heard_and_pauses_with_it(pages, opened) -> None:
    """Each step shows the last map begun at the time that it reads, within 1 µs of rounding."""
    path = pages("filmed")
    rate = 1000
    times = np.array(data_of(path)["runs"][0]["film"]["times"])
    with opened(path) as page:
        page.select_option("#film-rate", str(rate))
        page.evaluate(FRAMES)
        page.click("#film-play")
        until(page, "tap.before")
        heard_before = page.evaluate("tap.before")
        page.click("#film-play")
        until(page, f"document.querySelector('#film-seek').value === '{len(times) - 1}'")
        starts = page.evaluate("tap.whens.map((when, k) => [when, tap.offsets[k]])")
        frames = np.array(page.evaluate("tap.frames"))
    # It goes on where it was paused.
    paused = starts[0][1] + (frames[heard_before - 1, 1] - starts[0][0]) / rate
    assert starts[1][1] == pytest.approx(paused, abs=1e-6 / rate)
    for begin, end, (when, offset) in (
        (0, heard_before, starts[0]),
        (heard_before, len(frames), starts[1]),
    ):
        shown, clock = frames[begin:end].T
        time = offset + (clock - when) / rate
        moving = (time > times[0]) & (time < times[-1])
        assert moving.any()
        late = times[shown[moving].astype(int)] - time[moving]  # negative: until the next map
        early = time[moving] - times[np.minimum(shown[moving].astype(int) + 1, len(times) - 1)]
        assert rate * max(late.max(), early.max()) < 1e-6


def test_the_film_starts_at_the_slowest_rate_that_is_heard(pages, opened) -> None:
    """The first choice is the slowest of 20, 50 and 100 that leaves half above 100 Hz."""
    path = pages("flying", "filmed", "seeds")
    with opened(path) as page:
        for number, run in enumerate(data_of(path)["runs"]):
            if not run["film"]:
                continue
            page.check(f"input[name=run][value='{number}']")
            heard = run["film"]["heard"]
            rate = run["film"]["rate"]
            slower = [x for x in (50, 100) if x > rate]
            assert all(heard[str(x)] < 0.5 for x in slower)
            assert rate == 20 or heard[str(rate)] >= 0.5
            assert page.text_content("#film-play") == f"Play {rate} times slower"
            assert f"{rate} times slower" in page.get_attribute("#film", "aria-label")


def test_reduced_motion_leaves_the_slider_alone(pages, opened) -> None:
    with opened(pages("filmed"), reduced_motion="reduce") as page:
        assert not page.locator("#film-play").is_visible()
        page.locator("#film-seek").focus()
        before = page.text_content("#film-time")
        page.keyboard.press("ArrowRight")
        assert page.text_content("#film-time") != before


def test_the_film_marks_flights_and_has_no_curves_without_dynamics(pages, opened) -> None:
    path = pages("flying", "filmed", "seeds")
    film = data_of(path)["runs"][1]["film"]
    assert any(film["flight_s"])
    with opened(path) as page:
        curves = page.locator("[data-name=film_motion] >> visible=true")
        said = "#film-time"
        page.check("input[name=run][value='1']")
        # It opens at the maximum of the force.
        assert "presses with" in page.text_content(said)
        curves.scroll_into_view_if_needed()
        curves.locator(".playhead").wait_for(state="attached")
        until(page, "tap.images.every((image) => image.complete)")
        for number, flight in enumerate(film["flight_s"]):
            page.evaluate(SEEK_FILM, number)
            assert ("and flies" in page.text_content(said)) == (flight > 0)
            assert page.locator("#film-flies").is_visible() == (flight > 0)
        frames, pixels = shown_film(page)
        assert (flashes(frames) > 3).mean() * pixels < FLASHING_PX
        page.check("input[name=run][value='2']")
        assert curves.count() == 0


def test_a_falling_ball_does_not_roll_under_its_load(pages, opened) -> None:
    """A fall of 0.1 mm takes 4.5 ms, and the ball bounces until the end of the record, at 30 ms.

    No still, slow motion or map shows a contact in that time, and the page says why.
    """
    path = pages("falling")
    run = runs_of("falling")[0]
    player = data_of(path)["runs"][0]
    assert run.result.slow_motion is not None and player["film"] is None
    assert kind_of(run.scene).still(run) is None
    maps = player["maps"]
    motion = run.vibration_sound.motion
    first = motion.time_s[np.argmax(motion.force_n > 0)]
    assert first == pytest.approx(4.5e-3, rel=0.02)
    for begin, sentence in zip(maps["begins"], maps["instead"], strict=True):
        if begin < first - 1e-3:
            assert sentence is not None and "flies" in sentence
    with opened(path) as page:
        assert page.locator("#still").count() == 0 or page.locator("#still").is_hidden()
        assert page.locator("#film").count() == 0 or page.locator(".film").is_hidden()
        seek(page, 0.0)
        assert "flies" in page.text_content("#map-flies")
        places = [(x, y) for x in range(20, 640, 40) for y in range(20, 600, 40)]
        assert np.max(page.locator("#map").evaluate(PIXELS, places)) == 0
        assert page.text_content("#map-pressure") == "\N{EN DASH}"


# ---- the key of the pictures

# Linear light of people without a kind of cones, from that of others: Machado, Oliveira and
# Fernandes, IEEE Transactions on Visualization and Computer Graphics 15 (2009) 1291, severity 1.
SEEN_BY = {
    "all cones": np.eye(3),
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
}
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = np.array([0.95047, 1.0, 1.08883])
APART = 40.0  # difference in CIELAB; 2.3 is just noticeable, and black and white differ by 100


def lab(colours: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return colours (n, 3) of sRGB as someone sees them, in CIELAB."""
    share = np.asarray(colours, dtype=float) / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    xyz = np.clip(light @ np.asarray(seen).T, 0, 1) @ XYZ.T / WHITE
    root = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    x, y, z = root.T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


@pytest.mark.law("page: released energy differs from all pressures and greys without red or green.")
@pytest.mark.parametrize("who", SEEN_BY)
@pytest.mark.parametrize("ends_at_hardness", [False, True])
def test_released_energy_is_told_from_pressures_without_red_or_green(
    who: str, ends_at_hardness: bool
) -> None:
    scale = {"max_gpa": 1.0, "hardness": ends_at_hardness}
    key = film.contact_key(scale)
    pressures = [numbers_of(colour) for colour in key.pressures]  # above which releases are lit
    greys = [[grey] * 3 for grey in range(0, 256, 5)]
    others = lab(np.array([*pressures, *greys]), SEEN_BY[who])
    lit = lab(np.array([numbers_of(key.lit)]), SEEN_BY[who])
    assert np.linalg.norm(others - lit, axis=1).min() > APART


def numbers_of(colour: str) -> list[int]:
    """Return red, green and blue of a colour of CSS."""
    return [int(part) for part in colour.removeprefix("rgb(").removesuffix(")").split(",")]


def test_the_key_of_the_contact_says_pressures_and_energies(opened, pages) -> None:
    (run,) = runs_of("filmed")
    with opened(pages("filmed")) as page:
        keys = page.locator(".contact-key:visible")
        assert keys.count() == 2  # in the first view, and at the slow motion
        text = keys.first.inner_text()
        assert "2.1 GPa, yielded" in text
        released = film.film_of(run, 1.0, False)["released"]
        assert released in text and released.endswith("per cell of 2 µm")
        shown = page.evaluate(
            "getComputedStyle(document.querySelector('.released')).backgroundImage"
        )
        assert "rgb(0, 150, 255)" in shown
