// Limiter behind the volume. It looks ahead: its gain has fallen before a peak comes, so that no
// sample exceeds the ceiling and none is clipped.

export const CEILING = 10 ** (-1 / 20); // of full scale
const AHEAD = 144; // samples, 3 ms, in which the gain falls; the sound is later by one less
const RELEASE = 1 / (0.25 * 48000); // share of the way back to 1 in a sample
const UNITY = 1 - 1e-9; // gain above which it is 1 again

export class Limiter {
  constructor(channels) {
    this.delayed = Array.from({ length: channels }, () => new Float64Array(AHEAD));
    this.needed = new Float64Array(AHEAD).fill(1); // gains that the latest samples need
    this.released = new Float64Array(AHEAD).fill(1); // gains that are at most all of them, and rise slowly
    Object.assign(this, { at: 0, least: 1, latest: 1, limits: 0 });
  }

  /** Set output channels to the limited samples of input channels; return the least gain. */
  process(inputs, outputs) {
    let lowest = 1;
    for (let i = 0; i < outputs[0].length; i++) {
      const gain = this.gainOf(inputs, i);
      lowest = Math.min(lowest, gain);
      this.delayed.forEach((delayed, channel) => {
        const sample = inputs[channel]?.[i] ?? 0;
        delayed[this.at] = Number.isFinite(sample) ? sample : 0;
        outputs[channel][i] = gain * delayed[(this.at + 1) % AHEAD];
      });
      this.at = (this.at + 1) % AHEAD;
    }
    return lowest;
  }

  /** Take a sample of all channels, and return the gain of the sample that comes out. */
  gainOf(inputs, i) {
    const { needed, released, at } = this;
    const level = inputs.reduce((most, channel) => (Number.isFinite(channel[i]) ? Math.max(most, Math.abs(channel[i])) : most), 0);
    const gone = needed[at];
    needed[at] = level > CEILING ? CEILING / level : 1;
    if (needed[at] <= this.least) this.least = needed[at];
    else if (gone <= this.least) this.least = needed.reduce((least, gain) => Math.min(least, gain), 1);
    const risen = this.latest + RELEASE * (1 - this.latest);
    this.latest = Math.min(this.least, risen > UNITY ? 1 : risen);
    released[at] = this.latest;
    this.limits = this.latest < 1 ? AHEAD : Math.max(this.limits - 1, 0);
    if (this.limits === 0) return 1;
    // The mean of gains, each of which is low enough for the sample that comes out.
    return released.reduce((sum, gain) => sum + gain, 0) / AHEAD;
  }
}
