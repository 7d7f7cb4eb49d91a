// ---- the slow motion: its maps, and the power that they release ----

import { $, runs, state } from "./core.js";
import { drawMoment, fitCanvas, loudestMap, readFilm } from "./film_still.js";
import { drawFlight, isEmptied, openCurves, saidMotion, showInCurves } from "./film_motion.js";
import { drawArrow, drawScale } from "./marks.js";
import { stopFilm } from "./film_sound.js";

// `time` in the record [s] is where the film goes on; null: at its beginning.
export const film = { at: 0, time: null, playing: false, origin: 0, source: null, pictures: new Map() };
export const filmOf = () => runs[state.run].film;
export const filmRate = () => Number($("#film-rate").value);

/** Returns the pictures of a run's film, read when they are first shown. */
export function picturesOf(number, onload = drawFilm) {
  if (!film.pictures.has(number)) film.pictures.set(number, readFilm(runs[number].film));
  for (const picture of Object.values(film.pictures.get(number))) if (!picture.complete) picture.addEventListener("load", onload, { once: true });
  return film.pictures.get(number);
}

export const watts = (uw) => (uw < 1000 ? `${Number(uw.toPrecision(3))} µW` : `${Number((uw / 1000).toPrecision(3))} mW`);
const twoDigits = (value) => Number(value.toPrecision(2));

/** Shows the film of the chosen run at its loudest moment. */
export function showFilm() {
  if (!$("#film")) return;
  stopFilm();
  const shown = filmOf();
  $(".film").hidden = !shown;
  $("#no-film").hidden = Boolean(shown);
  if (!shown) return;
  fitCanvas($("#film"), shown);
  openCurves(shown);
  $("#film-seek").max = shown.times.length - 1;
  $("#film-rate").value = shown.rate;
  showRate();
}

/** Says by which factor the film is slowed, and how much of its sound is then heard. */
export function showRate() {
  stopFilm();
  const { times, heard } = filmOf(), rate = filmRate();
  const lasts = times[times.length - 1] - times[0];
  $("#film-play").textContent = `Play ${rate} times slower`;
  $("#film-length").textContent = `It shows ${twoDigits(1e3 * lasts)} ms of the record in ${times.length} maps, which last ${twoDigits(lasts * rate)} s.`
    + ` Slowed ${rate} times, ${Math.round(100 * heard[rate])} % of the A-weighted sound lies above 100 Hz.`;
  seekFilm(loudestMap(filmOf()));
  film.time = null;
}

/** Shows the map of a time that is clicked in the curves. */
export function seekFilmTo(event) {
  event.stopPropagation(); // the record of the player stays where it is
  stopFilm();
  seekFilm(Math.max(0, filmOf().times.findLastIndex((start) => start <= event.detail.time)));
}

/** Shows a map of the film, from which the film goes on. */
export function seekFilm(number) {
  const { times, power_uw: power } = filmOf();
  Object.assign(film, { at: number, time: times[number] });
  $("#film-seek").value = number;
  const text = `${(1e3 * times[number]).toFixed(3)} ms, ${watts(power[number])}${saidMotion(filmOf(), times[number])}`;
  $("#film-time").textContent = text;
  $("#film-seek").setAttribute("aria-valuetext", text);
  $("#film").setAttribute("aria-label", `Slow motion, ${filmRate()} times slower, ${runs[state.run].label}, map ${number + 1} of ${times.length}`);
  drawFilm();
}

export function drawFilm() {
  const shown = filmOf();
  if (!shown) return;
  const pen = $("#film").getContext("2d"), scale = pen.canvas.width / shown.size[0];
  const isEmpty = isEmptied(shown, shown.times[film.at]);
  drawMoment(pen, picturesOf(state.run), shown, film.at, scale, isEmpty);
  drawScale(pen, scale / shown.cell_um, (shown.size[0] * shown.cell_um) / 5);
  drawArrow(pen);
  if (isEmpty) drawFlight(pen);
  showInCurves(shown.times[film.at]);
}
