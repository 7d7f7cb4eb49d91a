// Sound as a file of 16 bits, and data as what a worker hands over.

const WAVE_RATE = 48000;
const PEAK = 10 ** (-1 / 20);

/** Return the buffers of all arrays in prepared data, for a transfer. */
export function arraysOf(value, buffers = new Set()) {
  if (ArrayBuffer.isView(value)) buffers.add(value.buffer);
  else if (value && typeof value === "object") for (const part of Object.values(value)) arraysOf(part, buffers);
  return [...buffers];
}

/** Return channels of pressure [Pa] as a file with its peak at -1 dB: wav, and full scale [Pa]. */
export function waveFile(channels) {
  let peak = 0;
  for (const channel of channels) for (const sample of channel) peak = Math.max(peak, Math.abs(sample));
  const fullScale = Number((peak / PEAK || 1).toPrecision(4));
  return { wav: wavOf(channels, fullScale, `full scale = ${fullScale} Pa`), fullScale };
}

/** Return the bytes of a WAV file of pressures [Pa], with a comment. */
export function wavOf(channels, fullScale, comment) {
  const count = channels.length, { length } = channels[0];
  const text = comment.length % 2 ? `${comment}\0` : `${comment}\0\0`;
  const info = 12 + text.length, bytes = 2 * count * length;
  const wav = new Uint8Array(52 + info + bytes);
  const view = new DataView(wav.buffer);
  let at = 0;
  const letters = (word) => { for (const letter of word) wav[at++] = letter.charCodeAt(0); };
  const number = (value, wide) => {
    if (wide === 2) view.setUint16(at, value, true);
    else view.setUint32(at, value, true);
    at += wide;
  };
  letters("RIFF"); number(wav.length - 8, 4); letters("WAVEfmt "); number(16, 4);
  number(1, 2); number(count, 2); number(WAVE_RATE, 4); number(2 * count * WAVE_RATE, 4); number(2 * count, 2); number(16, 2);
  letters("LIST"); number(info, 4); letters("INFOICMT"); number(text.length, 4); letters(text);
  letters("data"); number(bytes, 4);
  const scale = 32768 / fullScale;
  for (let i = 0; i < length; i++) {
    for (let c = 0; c < count; c++, at += 2) view.setInt16(at, Math.max(-32768, Math.min(32767, Math.round(channels[c][i] * scale))), true);
  }
  return wav;
}
