// Entry of the engine: the instrument as an audio processor, whose output goes through the convolvers
// of the page, and the preparation of its slow parts in a Worker.

import { Limiter } from "./limiter.js";
import { BLOCK, ForceSource } from "./vibration.js";
import { prepare } from "./prepare.js";
import { ReleaseSource } from "./release.js";

const FOLLOW_S = 0.06; // time constant of the ball that follows a hand; it takes another speed in half of it
const BLOCKS = 12; // of a report: 31 a second
const ASLEEP = 375; // blocks without motion, a second, after which nothing is computed
const STILL = 1e-7; // speed [m/s] below which a ball is at rest
const UNHEARD = 1e-6; // range of the force [N] or pressure [Pa] below which a block is silent

/** Travel of the ball along the track: its speed [m/s] glides, or its position [m] follows a hand. */
class Travel {
  constructor(position, speed, fastest) {
    Object.assign(this, { position, speed, fastest: Math.max(speed, fastest), target: speed, hand: null });
  }

  /** Go on by a time [s] and return the position [m]. */
  advance(step) {
    const { position, fastest, hand } = this;
    // Critically damped, and never faster than the time steps resolve.
    const pull = hand === null ? 0 : (hand - position) / FOLLOW_S;
    const speed = this.speed + (step / FOLLOW_S) * (pull + 2 * (this.target - this.speed));
    this.speed = Math.min(Math.max(speed, -fastest), fastest);
    this.position = position + step * this.speed;
    return this.position;
  }
}

/** Ball and track of a run: source of contact force [N], or of pressure [Pa] for a release. */
export class Instrument {
  constructor({ run, settings, prepared, from }) {
    const { kind, start, length } = prepared;
    const begin = { position: start, speed: settings.speed, hold: 0, ...from };
    this.source = new (kind === "vibration" ? ForceSource : ReleaseSource)(run, settings, prepared, begin);
    this.travel = new Travel(begin.position, begin.speed, run.limits.speed[1]);
    // Of each block of a report: lowest and highest force or pressure, and the share of it that the ball flew.
    this.report = { low: new Float32Array(BLOCKS), high: new Float32Array(BLOCKS), flies: new Float32Array(BLOCKS) };
    Object.assign(this, { length, blocks: 0, idle: 0, still: 0, plays: true });
  }

  /** Obey a message of the page. */
  obey({ task, speed, position }) {
    this.idle = 0;
    if (task === "roll") Object.assign(this.travel, { hand: null, target: speed });
    else if (task === "drag") Object.assign(this.travel, { hand: position, target: 0 });
    else this.plays = false;
  }

  /** Set a block of samples; return a report when it is due. */
  fill(samples) {
    const { source, travel, report, length } = this;
    if (this.idle < ASLEEP) source.block(travel, samples);
    else samples.fill(this.still);
    this.still = samples[BLOCK - 1];
    const { lowest, highest, flies } = source.extremes;
    const block = this.blocks++ % BLOCKS;
    report.low[block] = lowest;
    report.high[block] = highest;
    report.flies[block] = flies;
    const moves = flies > 0 || Math.abs(travel.speed) > STILL || highest - lowest > UNHEARD;
    this.idle = moves ? 0 : this.idle + 1;
    if (block < BLOCKS - 1) return null;
    const { position, speed } = travel;
    return { ...report, asleep: this.idle >= ASLEEP, state: { ...source.state, position, speed, length } };
  }
}

/** Register the processors: the instrument obeys messages of the page, and both report to it. */
function registerInstrument() {
  registerProcessor("limiter", class extends AudioWorkletProcessor {
    constructor() {
      super();
      Object.assign(this, { limiter: new Limiter(2), blocks: 0, lowest: 1 });
    }

    process([input], [output]) {
      this.lowest = Math.min(this.lowest, this.limiter.process(input, output));
      if (++this.blocks % BLOCKS === 0) {
        this.port.postMessage(this.lowest);
        this.lowest = 1;
      }
      return true;
    }
  });
  registerProcessor("instrument", class extends AudioWorkletProcessor {
    constructor({ processorOptions }) {
      super();
      this.instrument = new Instrument(processorOptions);
      this.port.onmessage = ({ data }) => this.instrument.obey(data);
    }

    process(_, [[samples]]) {
      const report = this.instrument.fill(samples);
      if (report) this.port.postMessage(report);
      return this.instrument.plays;
    }
  });
}

/** Answer the page, which asks for the slow parts of a run at settings. */
function answer({ data: { number, run, settings } }) {
  try {
    postMessage({ number, settings, prepared: prepare(run, settings) });
  } catch (error) {
    postMessage({ number, failed: String(error?.message ?? error) });
  }
}

if (globalThis.registerProcessor) registerInstrument();
else if (globalThis.WorkerGlobalScope) onmessage = answer;
