// ---- the slow motion ----

import { $, FADE_S, runs, state } from "./core.js";
import { recordOf } from "./records.js";
import { audioContext, glide, pause, play, seek } from "./player.js";
import { seconds } from "./motion.js";
import { drawArrow, drawCircle, drawScale } from "./contact.js";
import { drawFlight, drawMotion, hardestMap, isEmptied, prepareMotion, saidMotion } from "./film_motion.js";

export const film = { at: 0, playing: false, began: 0, source: null, pictures: new Map() };
export const filmOf = () => runs[state.run].film;

/** The pictures of a run's film, read when they are first shown. */
export function picturesOf(number) {
  if (!film.pictures.has(number)) {
    const { ground, pressure, release } = runs[number].film;
    const read = (src) => Object.assign(new Image(), { onload: drawFilm, src });
    film.pictures.set(number, { ground: read(ground), pressure: read(pressure.png), release: read(release.png) });
  }
  return film.pictures.get(number);
}

export const watts = (uw) => (uw < 1000 ? `${Number(uw.toPrecision(3))} µW` : `${Number((uw / 1000).toPrecision(3))} mW`);

export const lengthOf = ({ times }) => `${Number((1e3 * (times[times.length - 1] - times[0])).toPrecision(2))} ms`;

export function showFilm() {
  if (!$("#film")) return;
  stopFilm();
  const shown = filmOf();
  $(".film").hidden = !shown;
  $("#no-film").hidden = Boolean(shown);
  if (!shown) return;
  const canvas = $("#film");
  canvas.width = $("#film-power").width = Math.min(1200, 2 * canvas.clientWidth || 1200); // small print stays legible
  canvas.height = Math.round((canvas.width * shown.size[1]) / shown.size[0]);
  $("#film-seek").max = shown.times.length - 1;
  $("#film-length").textContent = `It shows ${lengthOf(shown)} of the record in ${shown.times.length} maps.`;
  prepareMotion(shown, canvas.width);
  seekFilm(hardestMap(shown) ?? shown.power_uw.indexOf(Math.max(...shown.power_uw)));
}

export function seekFilm(number) {
  film.at = number;
  $("#film-seek").value = number;
  const { times, power_uw: power } = filmOf();
  const text = `${(1e3 * times[number]).toFixed(3)} ms, ${watts(power[number])}`;
  $("#film-time").textContent = text;
  $("#film-seek").setAttribute("aria-valuetext", text + saidMotion(filmOf(), times[number]));
  $("#film").setAttribute("aria-label", `Slow motion, ${runs[state.run].label}, map ${number + 1} of ${times.length}`);
  drawFilm();
}

export function drawFilm() {
  const shown = filmOf();
  if (!shown) return;
  const canvas = $("#film"), pen = canvas.getContext("2d");
  const { ground, pressure, release } = picturesOf(state.run);
  const scale = canvas.width / shown.size[0];
  pen.imageSmoothingEnabled = false; // a cell is what was computed
  if (ground.complete) pen.drawImage(ground, 0, 0, canvas.width, canvas.height);
  if (!isEmptied(shown, shown.times[film.at])) {
    drawPart(pen, pressure, shown.pressure, scale);
    drawPart(pen, release, shown.release, scale);
  } else drawFlight(pen);
  const [x, y] = shown.centres[film.at];
  drawCircle(pen, x * scale, y * scale, (shown.hertz_um / shown.cell_um) * scale);
  drawScale(pen, scale / shown.cell_um, (shown.size[0] * shown.cell_um) / 5);
  drawArrow(pen);
  drawPower(shown);
  drawMotion(shown);
}

export function drawPart(pen, picture, { tiles, places }, scale) {
  if (!picture.complete) return;
  const [x, y, width, height] = tiles[film.at], [left, top] = places[film.at];
  pen.drawImage(picture, x, y, width, height, left * scale, top * scale, width * scale, height * scale);
}

/** The release power, drawn as far as the film has come. */
export function drawPower({ times, power_uw: power }) {
  const canvas = $("#film-power"), pen = canvas.getContext("2d");
  const { width, height } = canvas;
  const [first, last] = [times[0], times[times.length - 1]];
  const [least, most] = [Math.min(...power.slice(1)), Math.max(...power)];
  const style = getComputedStyle(canvas);
  const x = (k) => ((times[k] - first) / (last - first)) * width;
  const y = (k) => height - 10 - ((power[k] - least) / (most - least || 1)) * (height - 50);
  pen.clearRect(0, 0, width, height);
  pen.fillStyle = style.color;
  pen.font = "22px system-ui, sans-serif";
  pen.textAlign = "left";
  pen.fillText(`release power, ${watts(least)} to ${watts(most)}`, 8, 24);
  pen.strokeStyle = style.color;
  pen.lineWidth = 3;
  pen.beginPath();
  for (let k = 1; k <= film.at; k++) pen.lineTo(x(k), y(k));
  pen.stroke();
  pen.beginPath();
  pen.arc(x(film.at), y(film.at), 7, 0, 2 * Math.PI);
  pen.fill();
}

/** Plays the film once: it never begins again by itself, so that nothing flashes. */
export async function playFilm() {
  if (film.playing) return stopFilm();
  const shown = filmOf();
  if (state.wanted) pause();
  const audio = audioContext();
  const [{ record }] = await Promise.all([recordOf(state.run, "run"), audio.resume()]);
  if (film.playing || shown !== filmOf()) return;
  const rate = Number($("#film-rate").value);
  const from = film.at >= shown.times.length - 1 ? 0 : film.at;
  Object.assign(film, { playing: true, began: audio.currentTime - rate * (shown.times[from] - shown.times[0]) });
  film.source = slowedSound(record, shown.times[from], shown.times[shown.times.length - 1], rate);
  $("#film-play").textContent = "Pause";
  tickFilm(rate);
}

/** The record from one time to another, slowed like the picture. */
export function slowedSound(buffer, from, to, rate) {
  const { context } = state, seconds = (to - from) * rate;
  const gain = runs[state.run].playback.calibrated ? 1 : 0;
  const source = new AudioBufferSourceNode(context, { buffer, playbackRate: 1 / rate });
  const smooth = new BiquadFilterNode(context, { type: "lowpass", frequency: 20000 / rate }); // images between samples
  const fade = new GainNode(context, { gain: 0 });
  fade.gain.setValueAtTime(0, context.currentTime);
  fade.gain.linearRampToValueAtTime(gain, context.currentTime + FADE_S);
  fade.gain.setValueAtTime(gain, context.currentTime + Math.max(FADE_S, seconds - FADE_S));
  fade.gain.linearRampToValueAtTime(0, context.currentTime + seconds);
  source.connect(smooth).connect(fade).connect(state.master);
  source.start(context.currentTime, from, to - from);
  return { source, fade };
}

export function tickFilm(rate) {
  if (!film.playing) return;
  const { times } = filmOf();
  const time = times[0] + (state.context.currentTime - film.began) / rate;
  const next = times.findLastIndex((each) => each <= time);
  if (next !== film.at) seekFilm(Math.max(0, next));
  if (next >= times.length - 1) stopFilm();
  else requestAnimationFrame(() => tickFilm(rate));
}

export function stopFilm() {
  if (!film.playing) return;
  film.playing = false;
  glide(film.source.fade.gain, 0);
  film.source.source.stop(state.context.currentTime + FADE_S);
  $("#film-play").textContent = "Play slowly";
}

/** The event at its own pace: the record from a quarter of a second before it. */
export function realTime() {
  stopFilm();
  if (state.wanted) pause();
  seek(Math.max(0, filmOf().times[film.at] - 0.25));
  play();
}
