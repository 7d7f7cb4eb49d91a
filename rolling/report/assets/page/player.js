// ---- sound ----

import { $, $$, FADE_S, RATE, STILL_MS, goesRound, longest, modulo, position, runs, state } from "./core.js";
import { render, showButton, tick } from "./motion.js";
import { stopFilm } from "./film_sound.js";

export function bytesOf(uri) {
  const text = atob(uri.slice(uri.indexOf(",") + 1));
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/** The part of a record that goes round: all of one that closes, otherwise cross-faded as in listen.wav. */
export function lapOf(record, { begin, end, overlap, correlation, factor }) {
  const { numberOfChannels } = record;
  const round = new AudioBuffer({ length: end - overlap - begin, sampleRate: RATE, numberOfChannels });
  for (let channel = 0; channel < numberOfChannels; channel++) {
    const samples = record.getChannelData(channel);
    const lap = samples.slice(begin, end - overlap);
    for (let i = 0; i < overlap; i++) {
      const rise = Math.sin((0.5 * Math.PI * (i + 0.5)) / overlap) ** 2;
      const fall = 1 - rise;
      lap[i] = (rise * lap[i] + fall * samples[end - overlap + i]) / Math.sqrt(rise ** 2 + fall ** 2 + 2 * correlation * rise * fall);
    }
    round.copyToChannel(lap.map((sample) => factor * sample), channel);
  }
  return round;
}

/** The samples of a player, its lap, and the record filled up with silence, so that all go round together. */
export async function decodeOne(player) {
  const offline = new OfflineAudioContext(1, 1, RATE); // may be had before the user has clicked anything
  const record = await offline.decodeAudioData(bytesOf(player.src).buffer);
  const { numberOfChannels } = record;
  const once = new AudioBuffer({ length: Math.round(longest * RATE), sampleRate: RATE, numberOfChannels });
  for (let channel = 0; channel < numberOfChannels; channel++) once.copyToChannel(record.getChannelData(channel), channel);
  return { record, round: lapOf(record, runs[Number(player.dataset.run)].lap), once };
}

export const decode = () => (state.decoding ??= Promise.all($$("audio[data-run]").map(decodeOne)));
export const gainOf = (number) => (number === (state.blind ?? state.run) ? runs[number].playback[state.mode] : 0);

/** The record of a run, round again or not. */
export function bufferOf(number) {
  const { round, once } = state.buffers[number];
  return goesRound(runs[number]) ? round : once;
}

export function glide(gain, target) {
  const now = state.context.currentTime;
  gain.cancelScheduledValues(now);
  gain.setValueAtTime(gain.value, now);
  gain.linearRampToValueAtTime(target, now + FADE_S);
}

/** All runs sound together, but only one is let through: switching moves gains and nothing else. */
export function mix() {
  state.voices.forEach(({ gain }, number) => glide(gain.gain, gainOf(number)));
}

export function startVoices(at) {
  const { context } = state;
  const when = context.currentTime;
  Object.assign(state, { playing: true, from: at, origin: when - at });
  state.voices = runs.map((_, number) => {
    const buffer = bufferOf(number);
    const source = new AudioBufferSourceNode(context, { buffer, loop: true });
    const gain = new GainNode(context, { gain: at === 0 ? gainOf(number) : 0 }); // a fade would change the beginning of the record
    source.connect(gain).connect(state.master);
    source.start(when, modulo(at, buffer.duration));
    return { source, gain };
  });
  const voices = state.voices;
  voices[0].source.onended = () => voices === state.voices && finish();
  setEnd();
  mix();
}

/** Where it stops: at the end of this round, or never. */
export function setEnd() {
  state.end = state.loop ? Infinity : longest * (Math.floor(position() / longest + 1e-9) + 1);
  const when = state.loop ? NEVER : state.origin + state.end;
  for (const { source } of state.voices) source.stop(when);
}

export function stopVoices() {
  const old = state.voices;
  state.voices = [];
  for (const { source, gain } of old) {
    glide(gain.gain, 0);
    source.stop(state.context.currentTime + FADE_S);
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
  showButton();
  const started = audioContext().resume();
  setTimeout(sayIfStill, STILL_MS);
  [state.buffers] = await Promise.all([decode(), started]);
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
  Object.assign(state, { wanted: false, playing: false, voices: [], at: longest, end: longest });
  showButton();
  render();
}

export function seek(time) {
  const at = Math.min(Math.max(time, 0), longest);
  if (state.playing) {
    stopVoices();
    startVoices(at < longest ? at : 0);
  } else {
    Object.assign(state, { at, end: longest });
  }
  render();
}
