// ---- data and elements of the page, and state of the player ----

import { RATE } from "../engine/rate.js";

export const FADE_S = 0.01; // short enough to switch at once, long enough not to click

export const $ = (selector) => document.querySelector(selector);
export const $$ = (selector) => [...document.querySelectorAll(selector)];
export const data = JSON.parse($("#data").textContent);
export const runs = data.runs;
export const motionUnwanted = matchMedia("(prefers-reduced-motion: reduce)");
export const modulo = (value, period) => ((value % period) + period) % period;
export const signed = (value) => (Math.abs(value) < 0.05 ? "0.0" : `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(1)}`);

/** Announce a text to a screen reader. */
export function say(text) {
  $("#said").textContent = text;
}

// The playhead of all runs rests at `at`, or moves with the audio clock from zero at `origin` as long as there are `voices`. `wanted`: Play is pressed. `blind`: the run of a blind test. `starting`: number of sounds that are about to start. `master` goes through `direct`, and through the `room` that is asked for, to the `ear`. `released`: the released power is heard in place of what plays first.
export const state = { run: 0, released: false, blind: null, wanted: false, at: 0, origin: 0, voices: null, context: null, master: null, direct: null, room: null, ear: null, starting: 0 };

/** Return the time of the audio clock that is heard now. */
export const heardNow = () => state.context.currentTime - (state.context.outputLatency || 0);

export const position = () => (state.voices ? Math.max(state.at, heardNow() - state.origin) : state.at);

/** Return lap, gains and ends of the sound of a run that is heard: what plays first, or its released power. */
export const soundOf = (number) => (state.released && runs[number].released) || runs[number];

/** Return the length in seconds after which a record goes round, or ends. */
export const lengthOf = (number) => soundOf(number).lap.end / RATE;

/** Return the time in seconds within a run's record, which goes round in its own time or stays at its end. */
export function ownTime(number, at = position()) {
  const { lap: { begin, overlap }, ends } = soundOf(number), end = lengthOf(number), again = (begin + overlap) / RATE;
  if (ends) return Math.min(at, end);
  return at < end ? at : again + modulo(at - again, end - again);
}

/** Return the time within the solved track, at whose end it stays while a long record goes on. */
export const solvedTime = (number) => Math.min(ownTime(number), soundOf(number).solved);

export const seconds = (time) => `${time.toFixed(lengthOf(state.run) < 1 ? 3 : 2)} s`;
