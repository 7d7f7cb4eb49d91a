// Loss factor of a plate over the frequency, after acoustics/radiation.py.

/**
 * Return the loss factor of a plate at an angular frequency [rad/s]. `curve` has pairs of frequency [Hz]
 * and loss factor over that at 1 kHz, between which it is a power law; null: it is the same everywhere.
 */
export function lossAt(lossFactor, curve, w) {
  if (!curve) return lossFactor;
  const hz = w / (2 * Math.PI), last = curve.length - 1;
  if (hz <= curve[0][0]) return lossFactor * curve[0][1];
  if (hz >= curve[last][0]) return lossFactor * curve[last][1];
  const k = curve.findIndex(([above]) => above > hz) - 1;
  const [[f0, low], [f1, high]] = [curve[k], curve[k + 1]];
  const share = Math.log(hz / f0) / Math.log(f1 / f0);
  return lossFactor * low * (high / low) ** share;
}
