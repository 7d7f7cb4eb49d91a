export const RATE = 48000;
export const FADE_S = 0.01; // short enough to switch at once, long enough not to click
export const NEVER = 1e6; // seconds, within the range of every browser
export const STILL_MS = 2000; // without a sound after which the page says so
export const HOLD_MS = 400; // of a map while it plays: at most 2.5 changes a second, which is 1.25 flashes

export const $ = (selector) => document.querySelector(selector);
export const $$ = (selector) => [...document.querySelectorAll(selector)];
export const data = JSON.parse($("#data").textContent);
export const runs = data.runs;
export const motionUnwanted = matchMedia("(prefers-reduced-motion: reduce)");
export const modulo = (value, period) => ((value % period) + period) % period;

// All that changes. `long`: the long records are heard where there are any, otherwise the computed ones. The playhead rests at `at`, or moves with the audio clock from `from` to `end`, zero at `origin`. While looping it
// runs on beyond the longest record, so that records of other lengths go round in their own time.
export const state = {
  run: 0, blind: null, mode: "calibrated", long: data.long, loop: !data.long && runs.every((run) => run.loops && !run.buzzes), wanted: false, playing: false,
  at: 0, from: 0, end: 0, origin: 0, context: null, master: null, clock: null, voices: [], sheets: [], drawn: "", drawnAt: 0,
};

// ---- records ----

/** Tells whether a run is heard by its long record. */
export const isLong = (number) => state.long && runs[number].long.own;

/** Returns the gains of a run among the records that are heard. */
export const playbackOf = (number) => (state.long ? runs[number].long.playback : runs[number].playback);

/** Returns the length in seconds of the longest record that is heard. */
export const longest = () => Math.max(...runs.map((run, number) => (isLong(number) ? run.long.seconds : run.seconds)));

/** Tells whether a record goes round again within the longest one; one that buzzes or does not close does so only when asked to. */
export const goesRound = (number) => state.loop || (!isLong(number) && runs[number].loops && !runs[number].buzzes);

// ---- time ----

export function position() {
  if (!state.playing) return state.at;
  const heard = state.context.currentTime - (state.context.outputLatency || 0) - state.origin;
  return Math.min(state.end, Math.max(state.from, heard));
}

export const sharedTime = () => (position() === state.end ? longest() : modulo(position(), longest()));

/** Returns the time within a run's computed record: round again if it loops, at its end if it is over or the long record goes on. */
export function ownTime(number) {
  const { seconds, lap, long } = runs[number];
  if (isLong(number)) return Math.min(sharedTime(), long.solved, seconds);
  const lasts = (lap.end - lap.overlap - lap.begin) / RATE;
  return goesRound(number) && lasts < longest() ? lap.begin / RATE + modulo(position(), lasts) : Math.min(sharedTime(), seconds);
}
state.end = longest();
