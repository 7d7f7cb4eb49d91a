// ---- sound by place: a patch of the track is heard by a click ----

import { $, FADE_S, runs, say, state } from "./core.js";
import { RATE } from "../engine/rate.js";
import { RESTING_MS, audioContext, glide, restContext, soundAlone, sounds, starting, stopVoice } from "./audio.js";
import { samplesOf } from "./records.js";

const PATCH_TIMES = 4; // that a patch is heard
const PATCH_LEAST_S = 0.25; // between its beginnings, so that a short patch does not become a tone
const PATCH_SOON_S = 0.02; // until a patch begins
const PATCH_LEADS_S = [0.005, 0.1]; // shortest and longest part of the record before and after a patch
let patchVoice = null;

/** Stop the patch that is heard. */
export function stopPatch() {
  if (!patchVoice) return;
  stopVoice(patchVoice);
  patchVoice = null;
  setTimeout(restContext, RESTING_MS);
}

/** Return a part of a record about a patch, faded, with the silence until it is heard again. */
function patchSound(record, begin, end) {
  const lead = Math.min(PATCH_LEADS_S[1], Math.max(PATCH_LEADS_S[0], end - begin));
  const first = Math.max(0, Math.round((begin - lead) * RATE)), last = Math.min(record.length, Math.round((end + lead) * RATE));
  const count = last - first, fade = Math.min(Math.round(FADE_S * RATE), Math.round((lead * RATE) / 2), Math.floor(count / 2));
  const length = Math.max(Math.round(PATCH_LEAST_S * RATE), Math.round(1.5 * count));
  const buffer = new AudioBuffer({ length, numberOfChannels: record.numberOfChannels, sampleRate: RATE });
  for (let channel = 0; channel < record.numberOfChannels; channel++) {
    const from = record.getChannelData(channel), to = buffer.getChannelData(channel);
    for (let i = 0; i < count; i++) {
      const inside = Math.min(i, count - 1 - i);
      to[i] = from[first + i] * (inside < fade ? Math.sin((0.5 * Math.PI * inside) / fade) ** 2 : 1);
    }
  }
  return buffer;
}

/** Play the part of a record in which the ball crosses a patch of the track, four times. */
export async function playPatch({ run, patch, place }) {
  const { begin, end } = patch, context = audioContext();
  const [record] = await starting(() => Promise.all([samplesOf($(`audio[data-run="${run}"]`)), context.resume()]));
  soundAlone(stopPatch);
  stopPatch();
  const buffer = patchSound(record, begin, end), when = context.currentTime + PATCH_SOON_S;
  const source = new AudioBufferSourceNode(context, { buffer, loop: true }), gain = new GainNode(context, { gain: 0 });
  source.connect(gain).connect(state.master);
  glide(gain, runs[run].playback[$("#equal")?.checked ? "equal" : "calibrated"]);
  source.start(when);
  source.stop(when + PATCH_TIMES * buffer.duration);
  const voice = { source, gain };
  source.onended = () => { if (patchVoice === voice) stopPatch(); };
  patchVoice = voice;
  say(`Plays the patch at ${place}, four times.`);
}

sounds.push({ stop: stopPatch, isHeard: () => patchVoice !== null });
