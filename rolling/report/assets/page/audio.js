// ---- the audio context, which all sounds of the page share, and one of which is heard at a time ----

import { $, $$, FADE_S, state } from "./core.js";
import { RATE } from "../engine/rate.js";

export const RESTING_MS = 200; // after a sound, which has faded out by then

// Sounds of the page: `stop` silences one, `isHeard` tells whether it needs the audio context, and `rest` is called when the context is suspended.
export const sounds = [];

// What has to be done once there is an audio context.
export const onContext = [];

export function audioContext() {
  if (!state.context) {
    state.context = new AudioContext({ sampleRate: RATE });
    state.master = new GainNode(state.context, { gain: Number($("#volume").value) });
    state.direct = new GainNode(state.context);
    state.ear = new GainNode(state.context);
    state.master.connect(state.direct).connect(state.ear).connect(state.context.destination);
    for (const act of onContext) act();
  }
  return state.context;
}

/** Begin a sound while the audio context stays awake. */
export async function starting(begin) {
  state.starting += 1;
  try {
    return await begin();
  } finally {
    state.starting -= 1;
  }
}

/** Suspend the audio context if nothing sounds: it takes processor time even for silence. */
export function restContext() {
  const { context } = state;
  if (context?.state !== "running" || state.starting || sounds.some(({ isHeard }) => isHeard())) return;
  for (const { rest } of sounds) rest?.();
  context.suspend();
}

/** Stop every sound of the page but one: the records, the slow motion, the ball, or a single player. */
export function soundAlone(own) {
  for (const { stop } of sounds) if (stop !== own) stop();
  for (const player of $$("audio")) if (player !== own) player.pause();
}

/** Move a gain to its target within the time of a fade. */
export const glide = ({ gain }, target, when = state.context.currentTime) => gain.setTargetAtTime(target, when, FADE_S / 4);

/** Fade out a voice, and end it. */
export function stopVoice({ source, gain }) {
  glide(gain, 0);
  source.stop(state.context.currentTime + 2 * FADE_S);
}
