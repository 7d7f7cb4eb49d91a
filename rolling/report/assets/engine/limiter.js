// A limiter that looks one block ahead: its gain moves linearly within a block and never lets a peak pass.

const CEILING = 0.98; // of full scale
const RECOVERY = 10; // [dB/s]

/** Gain of blocks of `frames` samples, one block late. */
export class Limiter {
  constructor(channels, frames, rate) {
    this.late = Array.from({ length: channels }, () => new Float32Array(frames));
    this.allowed = 1; // gain that the peak of the block in `late` allows
    this.gain = 1;
    this.rise = 10 ** ((RECOVERY * frames) / rate / 20);
  }

  /** Replace a block by the block before it, limited. */
  process(channels) {
    let peak = 0;
    for (const samples of channels) for (const sample of samples) peak = Math.max(peak, Math.abs(sample));
    const allowed = peak > CEILING ? CEILING / peak : 1;
    const next = Math.min(allowed, this.allowed, this.gain * this.rise);
    for (const [number, samples] of channels.entries()) {
      const late = this.late[number];
      for (let i = 0; i < samples.length; i++) {
        const sample = samples[i];
        samples[i] = late[i] * (this.gain + ((next - this.gain) * i) / samples.length);
        late[i] = sample;
      }
    }
    this.allowed = allowed;
    this.gain = next;
  }
}
