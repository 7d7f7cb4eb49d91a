// ---- sound ----

import { $, $$, FADE_S, NEVER, RATE, STILL_MS, goesRound, longest, modulo, playbackOf, position, runs, state } from "./core.js";
import { bufferOf, recordOf } from "./records.js";
import { render, showButton, tick } from "./motion.js";
import { stopFilm } from "./film_sound.js";
import { restBall } from "./play_sound.js";

export const heardRun = () => state.blind ?? state.run;
export const gainOf = (number) => (number === heardRun() ? playbackOf(number)[state.mode] : 0);

export function glide(gain, target) {
  const now = state.context.currentTime;
  gain.cancelScheduledValues(now);
  gain.setValueAtTime(gain.value, now);
  gain.linearRampToValueAtTime(target, now + FADE_S);
}

/** All runs sound together, but only one is let through: switching moves gains and nothing else. */
export function mix() {
  state.voices.forEach((voice, number) => voice && glide(voice.gain.gain, gainOf(number)));
}

/** Starts all records that are decoded at a time, and the others in step with them as soon as they are. */
export function startVoices(at) {
  const { context } = state, when = context.currentTime;
  const voices = runs.map(() => null);
  Object.assign(state, { playing: true, from: at, origin: when - at, voices, clock: new ConstantSourceNode(context, { offset: 0 }) });
  state.clock.connect(state.master);
  state.clock.onended = () => voices === state.voices && finish();
  state.clock.start();
  runs.forEach((_, number) => bufferOf(number) && startVoice(number, when, at === 0));
  setEnd();
  mix();
  decodeOthers(voices);
}

/** Starts the record of a run in step with the clock; the first of all begins without a fade. */
export function startVoice(number, when, atOnce) {
  const { context } = state, buffer = bufferOf(number), loop = goesRound(number), at = when - state.origin;
  const source = new AudioBufferSourceNode(context, { buffer, loop });
  const gain = new GainNode(context, { gain: atOnce ? gainOf(number) : 0 });
  source.connect(gain).connect(state.master);
  source.start(when, loop ? modulo(at, buffer.duration) : Math.min(modulo(at, longest()), buffer.duration));
  state.voices[number] = { source, gain };
}

/** Decodes the records that are missing, one after another, and lets them join the voices. */
export async function decodeOthers(voices) {
  for (const number of runs.keys()) {
    await recordOf(number);
    if (voices !== state.voices) return;
    if (voices[number]) continue;
    startVoice(number, state.context.currentTime + FADE_S, false);
    glide(voices[number].gain.gain, gainOf(number));
  }
  setEnd();
}

/** Sets where it stops: at the end of this round, or never. */
export function setEnd() {
  state.end = state.loop ? Infinity : longest() * (Math.floor(position() / longest() + 1e-9) + 1);
  const when = state.loop ? NEVER : state.origin + state.end;
  for (const source of [state.clock, ...state.voices.map((voice) => voice?.source)]) source?.stop(when);
}

export function stopVoices() {
  const old = state.voices;
  state.clock.onended = null;
  state.clock.stop();
  state.voices = [];
  for (const voice of old.filter(Boolean)) {
    glide(voice.gain.gain, 0);
    voice.source.stop(state.context.currentTime + FADE_S);
  }
}

export function audioContext() {
  if (!state.context) {
    state.context = new AudioContext({ sampleRate: RATE });
    state.master = new GainNode(state.context, { gain: Number($("#volume").value) });
    state.master.connect(state.context.destination);
  }
  return state.context;
}

/** A browser without a sound device may wait for one without a word. */
export function sayIfStill() {
  $("#no-sound").hidden = !state.wanted || state.context.state === "running";
}

export async function play() {
  if (state.wanted) return;
  state.wanted = true;
  for (const player of $$("audio")) player.pause();
  stopFilm();
  restBall();
  showButton();
  const started = audioContext().resume();
  setTimeout(sayIfStill, STILL_MS);
  await Promise.all([recordOf(heardRun()), started]);
  if (!state.wanted || state.playing) return;
  $("#no-sound").hidden = true;
  startVoices(state.at >= state.end ? 0 : state.at);
  tick();
}

export function pause() {
  state.wanted = false;
  if (state.playing) {
    Object.assign(state, { at: position(), playing: false });
    stopVoices();
  }
  showButton();
  render();
}

export function finish() {
  Object.assign(state, { wanted: false, playing: false, voices: [], at: longest(), end: longest() });
  showButton();
  render();
}

export function seek(time) {
  const at = Math.min(Math.max(time, 0), longest());
  if (state.playing) {
    stopVoices();
    startVoices(at < longest() ? at : 0);
  } else {
    Object.assign(state, { at, end: longest() });
  }
  render();
}
