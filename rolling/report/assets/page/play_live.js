// ---- the instrument: its state, which sound, panel, meters and picture share ----

import { runs } from "./core.js";

export const SPECTRUM = 16384; // samples, whose lines resolve the third octave at 20 Hz

// `out`: speed [m/s], slowing [m/s2] and time of the beginning of a ball that rolls out, or null.
// `rolling`: direction of the ball, 0 at rest. `fastest`: speed of the hand [m/s], which the time steps have to resolve.
// `dropped`: drops are wanted. `behind`: the settings have changed since the worker was asked; `preparing`: promise of the
// time when it is not behind. `latest`: the settings prepared last. `node`: the instrument that sounds, and `sounding` its
// settings. `resting`: the audio context is suspended until the ball is touched again. `asleepAt`: time of the audio clock
// since which the ball rests. `joined`: the
// instrument is connected with its way out, as it is from the first touch on. `limited`: the latest gain of the limiter.
export const live = {
  number: -1, settings: {}, rolling: 0, held: false, fastest: 0, dropped: false, report: null, heardAt: 0,
  worker: null, behind: false, preparing: null, latest: null, refused: false,
  out: null, opening: null, bus: null, meters: [], volume: null, limiter: null, joined: false, node: null, body: null,
  sounding: null, resting: false, asleepAt: null, limited: 1,
};

export const liveOf = () => runs[live.number].live;

/** Return the speed [m/s] of a free ball now: that of the settings, or what is left of it as it rolls out. */
export function freeSpeed() {
  if (!live.out) return live.settings.speed;
  const { speed, slowing, begun } = live.out;
  return Math.max(speed - (slowing * (performance.now() - begun)) / 1000, 0);
}

/** Send a message to the processor; it is lost before the sound has started. */
export const tellInstrument = (message) => live.node?.port.postMessage(message);

/** Return the position of the ball [m] now: the latest report is carried on by its speed. */
export function heardPosition(unheard) {
  if (!live.report) return unheard;
  const { position, speed } = live.report.state;
  return position + speed * Math.min((performance.now() - live.heardAt) / 1000, 0.1);
}
