// Convolution in blocks without latency: short parts of a response at once, long parts a block ahead
// with their work spread evenly over time. A new response takes over the input heard so far.

import { RealTransform } from "./fft.js";

export const BLOCK = 128; // frames
export const LONG = 4096; // frames of a long part
const PER_LONG = LONG / BLOCK;
const AHEAD = 2 * LONG; // frames of the response that short parts hold

/** Return the lines of parts of a response, each of a size and padded to twice as much. */
function partLines(samples, size, begin, end) {
  const transform = new RealTransform(2 * size);
  const parts = [];
  for (let first = begin; first < Math.min(samples.length, end); first += size) {
    const part = new Float64Array(2 * size);
    part.set(samples.subarray(first, Math.min(first + size, samples.length, end)));
    const lines = { re: new Float32Array(size + 1), im: new Float32Array(size + 1) };
    transform.forward(part, lines.re, lines.im);
    parts.push(lines);
  }
  return parts;
}

/** Return a response as a convolver takes it, made of arrays that a worker can transfer. */
export function parted(samples) {
  return { short: partLines(samples, BLOCK, 0, AHEAD), long: partLines(samples, LONG, AHEAD, samples.length) };
}

/** Add to sums the products of lines. */
function addProducts(sum, a, b) {
  const { re, im } = sum;
  const [ar, ai, br, bi] = [a.re, a.im, b.re, b.im];
  for (let i = 0; i < re.length; i++) {
    re[i] += ar[i] * br[i] - ai[i] * bi[i];
    im[i] += ar[i] * bi[i] + ai[i] * br[i];
  }
}

/** Lines of the latest blocks of an input, each with the block before it. */
class LineHistory {
  constructor(size) {
    this.size = size;
    this.transform = new RealTransform(2 * size);
    this.frames = new Float64Array(2 * size);
    this.lines = [];
    this.next = 0;
  }

  /** Make room for a number of blocks. */
  hold(count) {
    if (count <= this.lines.length) return;
    const kept = this.lines.map((_, age) => this.at(age));
    const lines = () => ({ re: new Float32Array(this.size + 1), im: new Float32Array(this.size + 1) });
    this.lines = Array.from({ length: count }, (_, i) => kept[count - 1 - i] ?? lines());
    this.next = 0;
  }

  /** Return the lines of a block by its age in blocks, 0 for the latest. */
  at(age) {
    return this.lines[(this.next + this.lines.length - 1 - age) % this.lines.length];
  }

  /** Take the block that fills the second half of `frames`. */
  push() {
    if (!this.lines.length) return;
    const lines = this.lines[this.next];
    this.transform.forward(this.frames, lines.re, lines.im);
    this.next = (this.next + 1) % this.lines.length;
    this.frames.copyWithin(0, this.size);
  }
}

/** Output of one response to the input of a convolver. */
class ResponseOutput {
  constructor(response) {
    this.response = response;
    this.short = { re: new Float64Array(BLOCK + 1), im: new Float64Array(BLOCK + 1) };
    this.long = { re: new Float64Array(LONG + 1), im: new Float64Array(LONG + 1) };
    this.done = 0; // long parts summed for the next long block
    this.ahead = new Float64Array(2 * LONG); // its second half is the present long block
    this.frames = new Float64Array(2 * BLOCK);
  }

  /** Sum long parts until a share of all is done. */
  work(history, share) {
    const { long } = this.response;
    const end = Math.min(Math.ceil(share * long.length), history.lines.length);
    for (; this.done < end; this.done++) addProducts(this.long, history.at(this.done), long[this.done]);
  }

  /** Begin a long block with the sums of the one that ends. */
  turn(transform) {
    transform.inverse(this.long.re, this.long.im, this.ahead);
    this.long.re.fill(0);
    this.long.im.fill(0);
    this.done = 0;
  }

  /** Set a block to the output at a place in the present long block. */
  block(history, place, output) {
    const { short } = this.response;
    this.short.re.fill(0);
    this.short.im.fill(0);
    for (let age = 0; age < short.length; age++) addProducts(this.short, history.at(age), short[age]);
    history.transform.inverse(this.short.re, this.short.im, this.frames);
    for (let i = 0; i < BLOCK; i++) output[i] = this.frames[BLOCK + i] + this.ahead[LONG + place * BLOCK + i];
  }
}

/** Convolution of an input with a response for each channel. */
export class Convolver {
  constructor(responses) {
    this.short = new LineHistory(BLOCK);
    this.long = new LineHistory(LONG);
    this.place = 0; // blocks since the long block began
    this.held = new Float64Array(LONG); // input of the present long block
    this.mixed = new Float64Array(BLOCK);
    this.outputs = this.prepared(responses);
    this.coming = this.waiting = null;
  }

  /** Return outputs of responses, with room for their input. */
  prepared(responses) {
    this.short.hold(Math.max(...responses.map(({ short }) => short.length)));
    this.long.hold(Math.max(...responses.map(({ long }) => long.length)));
    return responses.map((response) => new ResponseOutput(response));
  }

  /** Change to other responses of the same lead, faded over the second long block from now. */
  change(responses) {
    this.waiting = responses;
  }

  /** Convolve a block of input; set a block for each channel. */
  process(input, channels) {
    if (this.place === 0) {
      this.long.frames.set(this.held, LONG);
      this.long.push();
    }
    this.short.frames.set(input, BLOCK);
    this.short.push();
    this.held.set(input, this.place * BLOCK);
    channels.forEach((channel, i) => {
      this.outputs[i].block(this.short, this.place, channel);
      if (!this.fading) return;
      this.coming[i].block(this.short, this.place, this.mixed);
      for (let k = 0; k < BLOCK; k++) {
        const share = Math.sin((Math.PI / 2) * ((this.place * BLOCK + k) / LONG)) ** 2;
        channel[k] += share * (this.mixed[k] - channel[k]);
      }
    });
    this.place++;
    for (const output of [...this.outputs, ...(this.coming ?? [])]) output.work(this.long, this.place / PER_LONG);
    if (this.place === PER_LONG) this.turn();
  }

  /** End a long block: responses that were faded in stay, and those that wait are fed for a block. */
  turn() {
    this.place = 0;
    if (this.fading) [this.outputs, this.coming] = [this.coming, null];
    this.fading = this.coming !== null;
    for (const output of [...this.outputs, ...(this.coming ?? [])]) output.turn(this.long.transform);
    if (!this.coming && this.waiting) [this.coming, this.waiting] = [this.prepared(this.waiting), null];
  }
}
