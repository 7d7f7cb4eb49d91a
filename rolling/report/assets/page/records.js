// ---- records: decoding, looping, and saving ----

import { $, runs, soundOf } from "./core.js";
import { RATE } from "../engine/rate.js";
import { download } from "./chart_save.js";

const rounds = new Map(); // promises of buffers by sound of a run

/** Decode the samples of a player, without a click of the user. */
export function samplesOf(player) {
  const bytes = Uint8Array.from(atob(player.src.slice(player.src.indexOf(",") + 1)), (letter) => letter.charCodeAt(0));
  return new OfflineAudioContext(1, 1, RATE).decodeAudioData(bytes.buffer);
}

/** Return a promise of the looping record of a run, of the sound that is heard. */
export function roundOf(number) {
  const sound = soundOf(number), name = sound === runs[number] ? "heard" : "heard-release";
  if (!rounds.has(sound)) rounds.set(sound, samplesOf($(`audio[data-${name}="${number}"]`)).then((record) => crossFade(record, sound.lap)));
  return rounds.get(sound);
}

/** Cross-fade the end of a record with the beginning of its lap as in listen.wav. */
function crossFade(record, { begin, end, overlap, correlation }) {
  for (let channel = 0; channel < record.numberOfChannels; channel++) {
    const samples = record.getChannelData(channel);
    for (let i = 0; i < overlap; i++) {
      const rise = Math.sin((0.5 * Math.PI * (i + 0.5)) / overlap) ** 2, fall = 1 - rise, at = end - overlap + i;
      samples[at] = (rise * samples[begin + i] + fall * samples[at]) / Math.sqrt(rise ** 2 + fall ** 2 + 2 * correlation * rise * fall);
    }
  }
  return record;
}

/** Save the record of a player as a WAV, at the gain at which the page plays its run. */
export async function saveRecord({ dataset: { wav, of } }) {
  const player = document.getElementById(of), record = await samplesOf(player), full = Number(player.dataset.full);
  const run = runs[Number(of.split("-").at(-1))], { calibrated, equal, calibrated_pa: common } = ((of.startsWith("released") && run.released) || run).playback;
  const wanted = $("#equal")?.checked ? (common * calibrated) / equal : common;
  const scale = Math.max(full, wanted); // a record with a higher peak than the one that is heard must not clip
  const channels = Array.from({ length: record.numberOfChannels }, (_, c) => record.getChannelData(c).map((sample) => (sample * full) / scale));
  const text = document.getElementById(player.getAttribute("aria-labelledby")).textContent;
  download(wavOf(channels, `${text.split("; full scale is")[0]}; full scale is ${Number(scale.toPrecision(6))} Pa`), "audio/wav", `${wav}.wav`);
}

/** Write channels of samples within full scale as a WAV of 24 bits with a comment. */
export function wavOf(channels, comment, rate = RATE) {
  const text = new TextEncoder().encode(`${comment}\0`), note = text.length + (text.length % 2);
  const count = channels.length, frames = channels[0].length, size = 3 * count * frames, end = 44 + size + (size % 2);
  const file = new DataView(new ArrayBuffer(end + 20 + note));
  const word = (at, letters) => [...letters].forEach((letter, i) => file.setUint8(at + i, letter.charCodeAt(0)));
  const numbers = [[4, 4, file.byteLength - 8], [16, 4, 16], [20, 2, 1], [22, 2, count], [24, 4, rate], [28, 4, 3 * count * rate], [32, 2, 3 * count], [34, 2, 24], [40, 4, size]];
  const info = [[end + 4, 4, 12 + note], [end + 16, 4, text.length]];
  for (const [at, letters] of [[0, "RIFF"], [8, "WAVE"], [12, "fmt "], [36, "data"], [end, "LIST"], [end + 8, "INFO"], [end + 12, "ICMT"]]) word(at, letters);
  for (const [at, bytes, value] of [...numbers, ...info]) bytes === 2 ? file.setUint16(at, value, true) : file.setUint32(at, value, true);
  for (let i = 0; i < frames; i++) {
    for (let c = 0; c < count; c++) {
      const step = Math.max(-8388608, Math.min(8388607, Math.round(8388608 * channels[c][i]))), at = 44 + 3 * (count * i + c);
      file.setUint8(at, step & 255);
      file.setInt16(at + 1, step >> 8, true);
    }
  }
  new Uint8Array(file.buffer).set(text, end + 20);
  return file.buffer;
}
