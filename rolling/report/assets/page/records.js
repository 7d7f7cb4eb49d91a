// ---- records: decoded once, the first when the page opens ----

import { $, RATE, goesRound, isLong, runs } from "./core.js";

export const decoded = new Map(); // by kind and number of the run

export function bytesOf(uri) {
  const text = atob(uri.slice(uri.indexOf(",") + 1));
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/** Decodes the samples of a player, without a click of the user. */
export const samplesOf = (player) => new OfflineAudioContext(1, 1, RATE).decodeAudioData(bytesOf(player.src).buffer);

/** Makes the part of a record that goes round: all of one that closes, otherwise cross-faded as in listen.wav. */
export function lapOf(record, { begin, end, overlap, correlation, factor }) {
  const { numberOfChannels } = record;
  const round = new AudioBuffer({ length: end - overlap - begin, sampleRate: RATE, numberOfChannels });
  for (let channel = 0; channel < numberOfChannels; channel++) {
    const samples = record.getChannelData(channel);
    const lap = samples.slice(begin, end - overlap);
    for (let i = 0; i < overlap; i++) {
      const rise = Math.sin((0.5 * Math.PI * (i + 0.5)) / overlap) ** 2;
      const fall = 1 - rise;
      lap[i] = (rise * lap[i] + fall * samples[end - overlap + i]) / Math.sqrt(rise ** 2 + fall ** 2 + 2 * correlation * rise * fall);
    }
    round.copyToChannel(lap.map((sample) => factor * sample), channel);
  }
  return round;
}

/** Returns the computed record of a run and its lap, or the long record of a run, as a promise of { record, round, ready }. */
export function recordOf(number, kind = isLong(number) ? "long" : "run") {
  const key = `${kind} ${number}`;
  if (!decoded.has(key)) {
    const entry = { ready: null };
    entry.promise = samplesOf($(`audio[data-${kind}="${number}"]`)).then((record) => {
      entry.ready = { record, round: kind === "long" ? record : lapOf(record, runs[number].lap) };
      return entry.ready;
    });
    decoded.set(key, entry);
  }
  return decoded.get(key).promise;
}

/** Returns the buffer that a run plays now, round again or not; undefined until it is decoded. */
export function bufferOf(number) {
  const { record, round } = decoded.get(`${isLong(number) ? "long" : "run"} ${number}`)?.ready ?? {};
  return goesRound(number) ? round : record;
}

/** Writes channels of samples within full scale as a WAV of 16 bits with a comment. */
export function wavOf(channels, comment, rate = RATE) {
  const text = new TextEncoder().encode(`${comment}\0`), note = text.length + (text.length % 2);
  const count = channels.length, frames = channels[0].length, size = 2 * count * frames;
  const file = new DataView(new ArrayBuffer(44 + size + 20 + note));
  const word = (at, letters) => [...letters].forEach((letter, i) => file.setUint8(at + i, letter.charCodeAt(0)));
  const numbers = [[4, 4, file.byteLength - 8], [16, 4, 16], [20, 2, 1], [22, 2, count], [24, 4, rate], [28, 4, 2 * count * rate], [32, 2, 2 * count], [34, 2, 16], [40, 4, size]];
  const info = [[44 + size + 4, 4, 12 + note], [44 + size + 16, 4, text.length]];
  for (const [at, letters] of [[0, "RIFF"], [8, "WAVE"], [12, "fmt "], [36, "data"], [44 + size, "LIST"], [52 + size, "INFO"], [56 + size, "ICMT"]]) word(at, letters);
  for (const [at, bytes, value] of [...numbers, ...info]) bytes === 2 ? file.setUint16(at, value, true) : file.setUint32(at, value, true);
  for (let i = 0; i < frames; i++) {
    for (let c = 0; c < count; c++) file.setInt16(44 + 2 * (count * i + c), Math.max(-32768, Math.min(32767, Math.round(32768 * channels[c][i]))), true);
  }
  new Uint8Array(file.buffer).set(text, 64 + size);
  return file.buffer;
}
