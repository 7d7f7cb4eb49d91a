// ---- the slow motion played with its sound, both by the clock of the sound ----

import { $, FADE_S, runs, state } from "./core.js";
import { audioContext, glide, pause, play, seek } from "./player.js";
import { restBall } from "./play_sound.js";
import { recordOf } from "./records.js";
import { film, filmOf, filmRate, seekFilm } from "./film.js";

export const LEAD_S = 0.3; // of slowed sound before the first map and after the last one: the ear needs longer than the eye
export const SOON_S = 0.05; // until the sound starts, so that it starts when it is told to

/** Plays the film once: it never begins again by itself, so that nothing flashes. */
export async function playFilm() {
  if (film.playing) return stopFilm();
  const shown = filmOf();
  if (state.wanted) pause();
  restBall();
  const audio = audioContext();
  const [{ record }] = await Promise.all([recordOf(state.run, "run"), audio.resume()]);
  if (film.playing || shown !== filmOf()) return;
  const { times } = shown, rate = filmRate(), lead = LEAD_S / rate;
  const end = Math.min(times[times.length - 1] + lead, runs[state.run].seconds);
  const begin = Math.max(0, times[0] - lead);
  const from = film.time === null || film.time >= times[times.length - 1] ? begin : film.time;
  const when = audio.currentTime + SOON_S;
  Object.assign(film, { playing: true, origin: when - rate * from, source: slowedSound(record, when, from, end, rate) });
  $("#film-play").textContent = "Pause";
  tickFilm(rate, end);
}

/** Starts the record from one time to another, slowed like the picture, at a time of the audio clock. */
function slowedSound(buffer, when, from, to, rate) {
  const { context } = state, until = when + (to - from) * rate;
  const gain = runs[state.run].playback.calibrated ? 1 : 0;
  const source = new AudioBufferSourceNode(context, { buffer, playbackRate: 1 / rate });
  const smooth = new BiquadFilterNode(context, { type: "lowpass", frequency: 20000 / rate }); // images between samples
  const fade = new GainNode(context, { gain: 0 });
  fade.gain.setValueAtTime(0, when);
  fade.gain.linearRampToValueAtTime(gain, when + FADE_S);
  fade.gain.setValueAtTime(gain, Math.max(when + FADE_S, until - FADE_S));
  fade.gain.linearRampToValueAtTime(0, until);
  source.connect(smooth).connect(fade).connect(state.master);
  source.start(when, from, to - from);
  return { source, fade };
}

/** Shows the map of the time that is heard. */
function tickFilm(rate, end) {
  if (!film.playing) return;
  const { times } = filmOf(), { currentTime, outputLatency = 0 } = state.context;
  const time = (currentTime - outputLatency - film.origin) / rate;
  const next = Math.max(0, times.findLastIndex((start) => start <= time));
  if (next !== film.at) seekFilm(next);
  film.time = time;
  if (time >= end) stopFilm();
  else requestAnimationFrame(() => tickFilm(rate, end));
}

/** Pauses picture and sound. */
export function stopFilm() {
  if (!film.playing) return;
  film.playing = false;
  glide(film.source.fade.gain, 0);
  film.source.source.stop(state.context.currentTime + FADE_S);
  $("#film-play").textContent = `Play ${filmRate()} times slower`;
}

/** Plays the event at its own pace: the record from a quarter of a second before it. */
export function realTime() {
  stopFilm();
  if (state.wanted) pause();
  seek(Math.max(0, filmOf().times[film.at] - 0.25));
  play();
}
