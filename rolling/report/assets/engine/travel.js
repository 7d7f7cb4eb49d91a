// Way of the ball along the track: a speed that glides to its target, or a place that a hand drags.

export const BLOCK = 128; // samples
const GLIDE_S = 0.06; // time constant of a change of speed, twice in a row
const FOLLOW_S = 0.05; // time constant of the ball that follows a hand

/** Position [m] and speed [m/s] of the ball, step by step. */
export class Travel {
  constructor(position, speed, fastest) {
    Object.assign(this, { position, speed, fastest, target: speed, smooth: speed, hand: null });
  }

  /** Glide to a speed [m/s]. */
  roll(speed) {
    this.hand = null;
    this.smooth = this.speed;
    this.target = Math.min(Math.max(speed, -this.fastest), this.fastest);
  }

  /** Follow a hand at a position [m]. */
  dragTo(position) {
    this.hand = position;
  }

  /** Tell whether the ball is at rest and not to move, by a speed [m/s]. */
  rests(still) {
    return this.hand === null && this.target === 0 && Math.abs(this.speed) < still;
  }

  /** Go on by a time [s] and return the position [m]. */
  advance(step) {
    if (this.hand === null) {
      const share = step / GLIDE_S;
      this.smooth += share * (this.target - this.smooth);
      this.speed += share * (this.smooth - this.speed);
    } else {
      // A critically damped follower, never faster than the track resolves.
      this.speed += (step / FOLLOW_S) * ((this.hand - this.position) / FOLLOW_S - 2 * this.speed);
      this.speed = Math.min(Math.max(this.speed, -this.fastest), this.fastest);
    }
    this.position += step * this.speed;
    return this.position;
  }
}
