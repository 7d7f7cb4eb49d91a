// The instrument that sounds, and the next one, into which it is faded: blocks of sound and their reports.

import { Instrument } from "./instrument.js";
import { Limiter } from "./limiter.js";

const FRAMES = 128; // of a block
const BLOCKS = 12; // of a report: 31 a second
const FADE = 12; // blocks: 32 ms
const BUSY = 0.45; // load above which two instruments at once would be too much
const ASLEEP = 375; // blocks without motion, a second, after which nothing is rendered
const STILL = 1e-7; // speed [m/s] below which a ball is at rest
const UNHEARD = 3e-6; // of full scale, below which a block is silent
const LATE_S = 0.05; // by which the clock has to fall behind at once to be a drop-out
const WARM = 31; // reports in which the code becomes fast
const SMOOTHING = 0.02; // of the load, per report

/** Instruments of one page, rendered block by block with their gain, their limiter and their reports. */
export class Stage {
  constructor(channels, rate, clock = Date.now) {
    Object.assign(this, { rate, clock, runs: [], sounding: null, next: null, faded: 0, gain: 0, target: 0, held: false });
    this.limiter = new Limiter(channels, FRAMES, rate);
    this.other = Array.from({ length: channels }, () => new Float32Array(FRAMES)); // sound of the next instrument
    Object.assign(this, { number: -1, shift: 0, wanted: 0, idle: 0, frames: 0, busy: 0, load: 0, measured: 0, lost: 0, lag: null });
    this.clear();
  }

  /** Begin a new report. */
  clear() {
    this.report = { blocks: 0, pressure: new Float32Array(FRAMES * BLOCKS), forces: new Float32Array(2 * BLOCKS), flights: new Float32Array(BLOCKS), gain: 1 };
  }

  /** Obey a message of the page. */
  obey(message) {
    this.idle = 0;
    const { task } = message;
    if (task === "run") this.runs[message.number] = message.run;
    else if (task === "play") this.play(message);
    else if (task === "gain") this.target = message.gain;
    else if (task === "roll") this.roll(message.speed);
    else if (task === "drag") this.drag(message.position);
    else if (this.current) this.current[task](message.height); // lift and drop
  }

  get current() {
    return this.next ?? this.sounding;
  }

  /** Roll at a speed [m/s], now and after a change of the run. */
  roll(speed) {
    Object.assign(this, { wanted: speed, held: false });
    this.current?.roll(speed);
  }

  /** Follow a hand to a position [m], counted on through all runs. */
  drag(position) {
    this.held = true;
    this.current?.dragTo(position - this.shift);
  }

  /** Play a run at settings: the same run takes them, another run is faded in where the ball is. */
  play({ number, settings, prepared }) {
    const before = this.current;
    if (before && this.number === number) return before.take(settings, prepared);
    const begun = { ...settings, speed: this.wanted, dropHeight: null }; // it rolls on, and is not lifted
    const instrument = new Instrument(this.runs[number], begun, prepared);
    if (before) {
      this.shift += before.state.position - instrument.state.position;
      instrument.travel.speed = before.travel.speed;
      instrument.roll(this.wanted);
    }
    if (this.next) this.sounding = this.next;
    return Object.assign(this, { number, next: instrument, faded: 0 });
  }

  /** Fill a block of each channel with sound in parts of full scale; return a report when it is due. */
  fill(channels) {
    const begun = this.clock();
    this.render(channels);
    this.note(channels[0]);
    const rise = (this.target - this.gain) / FRAMES;
    for (const samples of channels) for (let i = 0; i < FRAMES; i++) samples[i] *= this.gain + rise * i;
    this.gain = this.target;
    this.limiter.process(channels);
    this.report.gain = Math.min(this.report.gain, this.limiter.gain);
    this.frames += FRAMES;
    const ended = this.clock();
    this.busy += ended - begun; // whole milliseconds: right in the mean over many blocks
    return this.report.blocks === BLOCKS ? this.finish(ended) : null;
  }

  /** Render the pressure [Pa] of one instrument, or of two while one is faded into the other. */
  render(channels) {
    for (const samples of channels) samples.fill(0);
    if (this.idle > ASLEEP) return;
    if (!this.sounding) [this.sounding, this.next] = [this.next, null];
    if (!this.sounding) return;
    this.sounding.render(channels);
    if (this.next) this.fade(channels);
    const { height, speed } = this.current.state;
    const rests = !this.held && !(height > 0) && this.wanted === 0 && Math.abs(speed) < STILL;
    const silent = channels[0].every((pressure) => Math.abs(pressure) * this.target < UNHEARD);
    this.idle = rests && silent ? this.idle + 1 : 0;
  }

  /** Fade into the next instrument: both at once, or one after the other where both are too much. */
  fade(channels) {
    const both = this.load < BUSY;
    const [from, to] = [this.faded / FADE, (this.faded + 1) / FADE];
    const starts = both || this.faded >= FADE / 2;
    if (starts) this.next.render(this.other);
    channels.forEach((samples, number) => {
      for (let i = 0; i < FRAMES; i++) {
        const share = from + ((to - from) * i) / FRAMES;
        const rise = both ? share : Math.max(0, 2 * share - 1);
        const fall = both ? 1 - share : Math.max(0, 1 - 2 * share);
        samples[i] = fall * samples[i] + (starts ? rise * this.other[number][i] : 0);
      }
    });
    if (++this.faded < FADE) return;
    [this.sounding, this.next] = [this.next, null];
  }

  /** Keep pressure, force and flight of a block for the report. */
  note(pressure) {
    const { report } = this;
    report.pressure.set(pressure, report.blocks * FRAMES);
    const instrument = this.current;
    if (instrument) {
      const { lowest, highest, flies } = instrument.extremes;
      report.forces.set([lowest, highest], 2 * report.blocks);
      report.flights[report.blocks] = flies;
    }
    report.blocks++;
  }

  /** Return the report with the load of the processor and the time that its clock has lost. */
  finish(now) {
    const seconds = this.frames / this.rate;
    const share = this.busy / 1000 / ((FRAMES * BLOCKS) / this.rate);
    this.measured++;
    this.load += (share - this.load) * Math.max(SMOOTHING, 1 / this.measured);
    this.busy = 0;
    const lag = now / 1000 - seconds;
    this.lag ??= lag;
    const late = lag - this.lag;
    if (late < 0 || this.measured < WARM) this.lag = lag; // blocks are rendered ahead of time
    else if (late > LATE_S) Object.assign(this, { lost: this.lost + late, lag });
    const { report, load, lost } = this;
    this.clear();
    const { current, shift } = this;
    const state = current && { ...current.state, shift, length: current.length };
    if (state) state.position += shift;
    return { ...report, state, load, lost, seconds, asleep: this.idle > ASLEEP };
  }
}
