// Entry of the engine: the instrument as an audio processor, whose output goes through the convolvers
// of the page, and the preparation of its slow parts in a Worker.

import { prepare } from "./prepare.js";
import { ReleaseSource } from "./release.js";
import { BLOCK, Travel } from "./travel.js";
import { ForceSource } from "./vibration.js";

const BLOCKS = 12; // of a report: 31 a second
const ASLEEP = 375; // blocks without motion, a second, after which nothing is computed
const STILL = 1e-7; // speed [m/s] below which a ball is at rest
const UNHEARD = 1e-6; // change of the force [N] or pressure [Pa] below which a block is silent
const LATE_S = 0.05; // by which the clock has to fall behind at once to be a drop-out
const WARM = 375; // blocks in which the code becomes fast
const SMOOTHING = 0.002; // of the load, per block

/** Load of the processor, and the time [s] that its clock has lost. */
export class Pace {
  constructor(rate, clock = Date.now) {
    Object.assign(this, { rate, clock, load: 0, lost: 0, lag: Infinity, blocks: 0 });
  }

  begin() {
    this.begun = this.clock();
  }

  /** End a block; times in whole milliseconds are right in the mean over many blocks. */
  end() {
    const now = this.clock(), length = BLOCK / this.rate;
    this.blocks++;
    this.load += ((now - this.begun) / 1000 / length - this.load) * Math.max(SMOOTHING, 1 / this.blocks);
    const lag = now / 1000 - this.blocks * length;
    const late = lag - this.lag;
    if (late < 0 || this.blocks < WARM) this.lag = lag; // blocks are computed ahead of time
    else if (late > LATE_S) Object.assign(this, { lost: this.lost + late, lag });
  }
}

/** Ball and track of a run, from a hand's moves to the contact force [N], or to the pressure [Pa] of a release. */
export class Instrument {
  constructor({ run, settings, prepared, from = null }) {
    const { kind, start, length } = prepared;
    this.source = new (kind === "vibration" ? ForceSource : ReleaseSource)(run, settings, prepared);
    this.travel = new Travel(start, (from ?? settings).speed, run.limits.speed[1]);
    this.shift = from ? from.position - start : 0; // of a position that is counted on through all runs
    Object.assign(this, { length, idle: 0, still: 0, plays: true });
    this.clear();
  }

  /** Begin a new report: lowest and highest force or pressure of each block, and the share of it that the ball flew. */
  clear() {
    this.report = { blocks: 0, low: new Float32Array(BLOCKS), high: new Float32Array(BLOCKS), flies: new Float32Array(BLOCKS) };
  }

  /** Obey a message of the page. */
  obey({ task, speed, position, height, settings, prepared }) {
    this.idle = 0;
    if (task === "roll") this.travel.roll(speed);
    else if (task === "drag") this.travel.dragTo(position - this.shift);
    else if (task === "take") this.source.take(settings, prepared);
    else if (task === "end") this.plays = false;
    else this.source[task]?.(height); // lift and drop
  }

  /** Set a block of samples; return a report when it is due. */
  fill(samples) {
    if (this.idle < ASLEEP) this.source.block(this.travel, samples);
    else samples.fill(this.still);
    const { report, source } = this;
    const { lowest, highest, flies } = source.extremes;
    report.low[report.blocks] = lowest;
    report.high[report.blocks] = highest;
    report.flies[report.blocks++] = flies;
    const rests = this.travel.rests(STILL) && !(source.state.height > 0);
    this.still = samples[BLOCK - 1];
    this.idle = rests && samples.every((value) => Math.abs(value - this.still) < UNHEARD) ? this.idle + 1 : 0;
    if (report.blocks < BLOCKS) return null;
    this.clear();
    const { position, speed } = this.travel, { shift, length } = this;
    return { ...report, asleep: this.idle >= ASLEEP, state: { ...source.state, position: position + shift, speed, shift, length } };
  }
}

/** Register the processor, which obeys messages of the page and reports to it. */
function registerInstrument() {
  registerProcessor("instrument", class extends AudioWorkletProcessor {
    constructor({ processorOptions }) {
      super();
      const [instrument, pace] = [new Instrument(processorOptions), new Pace(sampleRate)];
      Object.assign(this, { instrument, pace });
      this.port.onmessage = ({ data }) => instrument.obey(data);
    }

    process(_, [[samples]]) {
      const { instrument, pace, port } = this;
      pace.begin();
      const report = instrument.fill(samples);
      pace.end();
      if (report) port.postMessage({ ...report, load: pace.load, lost: pace.lost });
      return instrument.plays;
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
