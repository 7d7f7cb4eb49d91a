// Sound of the ring at the settings: the acceleration of the small model, in a loop.

import { RATE } from "../engine/rate.js";
import { $, state } from "./state.js";

const OVERLAP = 4800; // samples over which the end of a loop fades into its beginning
const FADE_S = 0.03; // from one loop to the next
const LOUDEST = 0.9; // of full scale

const sound = { context: null, source: null, gain: null, playing: false };

/** Return a record whose end leads to its beginning. */
function looped(record) {
  const count = record.length - OVERLAP;
  const loop = record.slice(0, count);
  for (let k = 0; k < OVERLAP; k++) {
    const angle = (Math.PI / 2) * ((k + 0.5) / OVERLAP);
    loop[k] = Math.sin(angle) * record[k] + Math.cos(angle) * record[count + k];
  }
  return loop;
}

/** Fade the present loop out. */
function fadeOut() {
  const { context, source, gain } = sound;
  if (!source) return;
  gain.gain.setTargetAtTime(0, context.currentTime, FADE_S / 3);
  source.stop(context.currentTime + 3 * FADE_S);
  sound.source = null;
}

/** Play the latest record, if sound is wanted. */
export function soundLatest() {
  if (!sound.playing || !state.moved) return;
  fadeOut();
  const { context } = sound;
  const loop = looped(state.moved.sound);
  let peak = 0;
  for (const value of loop) peak = Math.max(peak, Math.abs(value));
  const wanted = state.run.gain;
  const level = peak > 0 ? Math.min(wanted, LOUDEST / peak) : wanted;
  const buffer = new AudioBuffer({ length: loop.length, sampleRate: RATE });
  buffer.copyToChannel(loop, 0);
  sound.gain = new GainNode(context, { gain: 0 });
  sound.source = new AudioBufferSourceNode(context, { buffer, loop: true });
  sound.source.connect(sound.gain).connect(context.destination);
  sound.gain.gain.setTargetAtTime(level, context.currentTime, FADE_S / 3);
  sound.source.start();
  const lowered = 20 * Math.log10(wanted / level);
  $("#heard").textContent = lowered > 0.05 ? `It is turned down by ${lowered.toFixed(1)} dB so that nothing clips.` : "";
}

/** Begin or end the sound of the small model. */
export function hear(wanted) {
  sound.playing = wanted;
  $("#hear").setAttribute("aria-pressed", String(wanted));
  $("#hear").textContent = wanted ? "Silence" : "Hear it at these settings";
  if (!wanted) {
    $("#heard").textContent = "";
    fadeOut();
    return;
  }
  for (const player of document.querySelectorAll("audio")) player.pause();
  sound.context ??= new AudioContext();
  sound.context.resume();
  soundLatest();
}
