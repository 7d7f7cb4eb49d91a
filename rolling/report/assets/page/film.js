// ---- the slow motion: maps and sound by the same clock ----

import { $, $$, FADE_S, heardNow, runs, state } from "./core.js";
import { RESTING_MS, audioContext, glide, restContext, soundAlone, sounds, starting, stopVoice } from "./audio.js";
import { setPlayhead } from "./chart_touch.js";
import { play, seek } from "./player.js";
import { samplesOf } from "./records.js";
import { drawContact } from "./contact.js";

const LEAD_S = 0.3; // of slowed sound before the first map and after the last one: the ear needs longer than the eye
const SOON_S = 0.05; // until the sound starts, so that it starts when it is told to
const FLASH_S = 1 / 3; // three flashes a second are too many by WCAG 2.3.1

// The film goes on at `time` in the record [s], or at its beginning where it is not `begun`; the audio clock is at `origin` at time zero. It has a `voice` while it plays.
export const film = { at: 0, time: 0, begun: false, origin: 0, voice: null };
sounds.push({ stop: stopFilm, isHeard: () => film.voice !== null });
const filmOf = () => runs[state.run].film;
const filmRate = () => Number($("#film-rate").value);
const twoDigits = (value) => Number(value.toPrecision(2));

/** Show the film of the chosen run. */
export function showFilm() {
  if (!$("#film")) return;
  const shown = filmOf();
  $(".film").hidden = !shown;
  $("#no-film").hidden = Boolean(shown);
  if (!shown) return;
  $("#film").height = Math.round(($("#film").width * shown.size_um[1]) / shown.size_um[0]);
  $("#film-seek").max = shown.times.length - 1;
  $("#film-rate").value = shown.rate;
  showRate();
}

/** State the rate, the length, and the audible share of the sound; show the loudest moment. */
export function showRate() {
  stopFilm();
  const { times, heard, loudest } = filmOf(), rate = filmRate(), lasts = times.at(-1) - times[0];
  $("#film-play").textContent = `Play ${rate} times slower`;
  $("#film-length").textContent = `It shows ${twoDigits(1e3 * lasts)} ms of the record in ${times.length} maps, which last ${twoDigits(lasts * rate)} s.`
    + ` Slowed ${rate} times, ${Math.round(100 * heard[rate])} % of the A-weighted sound lies above 100 Hz.`;
  seekFilm(loudest);
  film.begun = false;
}

/** Show a map of the film, from which the film goes on. */
export function seekFilm(number) {
  const { times, said } = filmOf();
  Object.assign(film, { at: number, time: times[number], begun: true });
  $("#film-seek").value = number;
  $("#film-seek").setAttribute("aria-valuetext", said[number]);
  $("#film-time").textContent = said[number];
  $("#film").setAttribute("aria-label", `Slow motion, ${filmRate()} times slower, ${runs[state.run].label}, map ${number + 1} of ${times.length}`);
  drawFilm();
}

/** Draw the map; in a flight only the surface, unless the picture would flash. */
function drawFilm() {
  const shown = filmOf(), flight = shown?.flight_s[film.at];
  if (!shown) return;
  const flies = flight > 0 && (!film.voice || flight * filmRate() > FLASH_S);
  $("#film-flies").hidden = !flies;
  drawContact($("#film"), flies ? { ...shown, sheets: shown.sheets.slice(0, 1) } : shown, film.at, drawFilm);
  for (const figure of $$(".film figure.timeline")) if (figure.plot) setPlayhead(figure.plot, film.time);
}

const mapAt = (time) => Math.max(0, filmOf().times.findLastIndex((start) => start <= time));

/** Stop at the map of a time [s]. */
export function seekFilmTo(time) {
  stopFilm();
  seekFilm(mapAt(time));
}

/** Play the film once: it never begins again by itself, so that nothing flashes. */
export async function playFilm() {
  if (film.voice) return stopFilm();
  const shown = filmOf(), rate = filmRate(), lead = LEAD_S / rate, context = audioContext();
  const [record] = await starting(() => Promise.all([samplesOf($(`audio[data-run="${state.run}"]`)), context.resume()]));
  if (film.voice || shown !== filmOf() || rate !== filmRate()) return;
  soundAlone(stopFilm);
  const first = shown.times[0], last = shown.times.at(-1), end = Math.min(last + lead, record.duration);
  const from = film.begun && film.time < last ? film.time : Math.max(0, first - lead);
  const when = context.currentTime + SOON_S;
  Object.assign(film, { origin: when - rate * from, voice: slowedVoice(record, when, from, end, rate) });
  $("#film-play").textContent = "Pause";
  tickFilm(film.voice, rate, end);
}

/** Start a part of the record, slowed like the picture, at a time of the audio clock. */
function slowedVoice(buffer, when, from, to, rate) {
  const { context } = state;
  const source = new AudioBufferSourceNode(context, { buffer, playbackRate: 1 / rate });
  const smooth = new BiquadFilterNode(context, { type: "lowpass", frequency: 20000 / rate }); // images between samples
  const gain = new GainNode(context, { gain: 0 });
  glide(gain, 1, when);
  glide(gain, 0, when + (to - from) * rate - 2 * FADE_S);
  source.connect(smooth).connect(gain).connect(state.master);
  source.start(when, from, to - from);
  return { source, gain };
}

/** Show the map of the time that is heard. */
function tickFilm(voice, rate, end) {
  if (film.voice !== voice) return;
  const time = (heardNow() - film.origin) / rate, next = mapAt(time);
  if (next !== film.at) seekFilm(next);
  Object.assign(film, { time, begun: true });
  if (time >= end) stopFilm();
  else requestAnimationFrame(() => tickFilm(voice, rate, end));
}

/** Pause picture and sound. */
export function stopFilm() {
  if (!film.voice) return;
  stopVoice(film.voice);
  film.voice = null;
  setTimeout(restContext, RESTING_MS);
  $("#film-play").textContent = `Play ${filmRate()} times slower`;
}

/** Play the event at its own pace: the record from a quarter of a second before it. */
export function realTime() {
  seek(filmOf().times[film.at] - 0.25);
  play();
}
