// The instrument: ball, track and listener in real time, from a hand's moves to sound pressure.

import { BLOCK, Convolver } from "./convolver.js";
import { SoundMeter } from "./bands.js";
import { RATE } from "./motion.js";
import { ReleaseSource } from "./release.js";
import { Travel } from "./travel.js";
import { ForceSource } from "./vibration.js";

/** A run that is played. */
export class Instrument {
  constructor(run, settings, prepared) {
    const vibrates = prepared.kind === "vibration";
    this.source = new (vibrates ? ForceSource : ReleaseSource)(run, settings, prepared);
    this.convolver = vibrates ? new Convolver(prepared.responses) : null;
    const begin = vibrates ? this.source.law.start : prepared.start;
    this.length = vibrates ? this.source.law.length : prepared.length; // of the closed track [m]
    this.travel = new Travel(begin, 0, run.limits.speed[1]);
    this.roll(settings.speed);
    this.kept = prepared.kept ?? null;
    const channels = vibrates ? prepared.responses.length : 1;
    this.force = new Float64Array(BLOCK);
    this.blocks = Array.from({ length: channels }, () => new Float64Array(BLOCK));
    this.read = BLOCK; // frames of the present block that are rendered
    this.meter = new SoundMeter(RATE);
    if (settings.dropHeight) this.lift(settings.dropHeight);
  }

  /** Take other settings with their slow parts; the sound fades over. */
  take(settings, prepared) {
    this.source.take(settings, prepared);
    if (this.convolver) this.convolver.change(prepared.responses);
    this.kept = prepared.kept ?? null;
  }

  /** Glide to a speed [m/s]. */
  roll(speed) {
    this.travel.roll(speed);
  }

  /** Follow a hand at a position along the track [m]. */
  dragTo(position) {
    this.travel.dragTo(position);
  }

  /** Hold the ball at a height [m] above the plate. */
  lift(height) {
    this.source.lift?.(height);
  }

  /** Let the ball fall. */
  drop() {
    this.source.drop?.();
  }

  /** Set channels (Float32Array or Float64Array) to the next pressures [Pa]; a single listener fills all. */
  render(channels) {
    const frames = channels[0].length;
    for (let done = 0; done < frames; ) {
      if (this.read === BLOCK) this.nextBlock();
      const count = Math.min(frames - done, BLOCK - this.read);
      channels.forEach((channel, i) => {
        const block = this.blocks[Math.min(i, this.blocks.length - 1)];
        channel.set(block.subarray(this.read, this.read + count), done);
      });
      this.read += count;
      done += count;
    }
  }

  /** Compute a block. */
  nextBlock() {
    if (this.convolver) {
      this.source.block(this.travel, this.force);
      this.convolver.process(this.force, this.blocks);
    } else this.source.block(this.travel, this.blocks[0]);
    this.meter.take(this.blocks[0]);
    this.read = 0;
  }

  /** Lowest and highest force [N] of the latest block, and the share of it that the ball flew. */
  get extremes() {
    return this.source.extremes;
  }

  /** Position [m], speed [m/s], force [N], approach [m], height [m], flight, impacts and Fast level [dB(A)]. */
  get state() {
    const { position, speed } = this.travel;
    return { position, speed, ...this.source.state, level: this.meter.fast };
  }
}
