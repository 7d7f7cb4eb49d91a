// ---- the record that is heard: its waveform and its spectrogram, on which a pointer or a key seeks ----

import { $, lengthOf, soundOf, state } from "./core.js";
import { RATE } from "../engine/rate.js";
import { roundOf } from "./records.js";
import { linesOfRecord } from "../engine/complex.js";
import { aWeight } from "../engine/radiation.js";

const ACROSS = 800; // of both pictures
const LOW_HZ = 20;
const ROWS_PER_OCTAVE = 12;
const ROWS = 120; // twelfths of an octave from 20 Hz to 20.5 kHz
const RANGE_DB = 60; // that the colours span below the maximum
const LABELS_HZ = [20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000];
const LABELS_APART = 0.09; // of the height of the spectrogram
const SLICE_MS = 8; // of work at once, so that the page answers meanwhile

// Sizes of the windows, long ones for low frequencies and short ones for high ones, as the ear resolves them, with the frequency up to which each is taken.
const WINDOWS = [{ size: 8192, below: 250 }, { size: 2048, below: 2000 }, { size: 512, below: Infinity }];

const outlines = new Map(); // waveforms by sound of a run
const spectrograms = new Map(); // and promises of levels

const middleOf = (row) => LOW_HZ * 2 ** ((row + 0.5) / ROWS_PER_OCTAVE);
const heightOf = (hertz) => (ROWS_PER_OCTAVE * Math.log2(hertz / LOW_HZ)) / ROWS; // 0 at the bottom, 1 at the top
const hertzText = (hertz) => (hertz < 1000 ? `${hertz} Hz` : `${hertz / 1000} kHz`);

/** Show the chosen run's record: the waveform once it is decoded, the spectrogram once it is analysed. */
export async function showHeard() {
  const number = state.run, sound = soundOf(number), channels = await channelsOf(number);
  if (!outlines.has(sound)) outlines.set(sound, outlineOf(channels));
  if (sound !== soundOf(state.run)) return;
  const canvas = $("#heard-bands"), lowest = lowestOf(channels[0].length);
  $("#heard-wave path").setAttribute("d", outlines.get(sound));
  showLoudness();
  showAxes(lowest);
  showSolved();
  canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
  if (!spectrograms.has(sound)) spectrograms.set(sound, spectrogramOf(channels[0]));
  const levels = await spectrograms.get(sound);
  if (sound === soundOf(state.run)) paint(levels, lowest);
}

/** Return the samples of a run's record by channel, without those behind its last lap. */
async function channelsOf(number) {
  const { lap } = soundOf(number), record = await roundOf(number), length = Math.min(record.length, lap.end);
  return Array.from({ length: record.numberOfChannels }, (_, c) => record.getChannelData(c).subarray(0, length));
}

/** Let the waveform be as high as the record is loud at the present gain. */
export function showLoudness() {
  const gain = soundOf(state.run).playback[$("#equal")?.checked ? "equal" : "calibrated"];
  $("#heard-wave path").style.transform = `scaleY(${gain})`;
}

/** Return the outline of channels as a path, from the least and the largest sample of each column. */
function outlineOf(channels) {
  const { length } = channels[0], above = [], below = [];
  for (let column = 0; column < ACROSS; column++) {
    const begin = Math.floor((column * length) / ACROSS), end = Math.max(begin + 1, Math.floor(((column + 1) * length) / ACROSS));
    let [least, most] = [Infinity, -Infinity];
    for (const channel of channels) {
      for (let i = begin; i < end; i++) {
        least = Math.min(least, channel[i]);
        most = Math.max(most, channel[i]);
      }
    }
    above.push(`${column} ${-most.toFixed(4)}`);
    below.push(`${column} ${-least.toFixed(4)}`);
  }
  return `M${above.join("L")}L${below.reverse().join("L")}Z`;
}

// ---- spectrogram ----

/** Return the longest window for a record of so many samples, of which it holds four at least. */
const longestOf = (length) => Math.min(WINDOWS[0].size, 2 ** Math.floor(Math.log2(Math.max(length / 4, 64))));

/** Return the lowest frequency [Hz] that a record of so many samples resolves. */
const lowestOf = (length) => Math.max(LOW_HZ, (2 * RATE) / longestOf(length));

/** Return levels from 0 (quiet) to 255 (the maximum) by column and row. */
async function spectrogramOf(samples) {
  const powers = new Float64Array(ACROSS * ROWS), longest = longestOf(samples.length);
  let from = 0;
  for (const { size, below } of WINDOWS) {
    const rows = Array.from({ length: ROWS }, (_, row) => row).filter((row) => middleOf(row) >= from && middleOf(row) < below);
    await addRows(powers, samples, Math.min(size, longest), rows);
    from = below;
  }
  const most = powers.reduce((a, b) => Math.max(a, b), 0);
  return Uint8Array.from(powers, (power) => Math.round(255 * Math.max(0, 1 + (10 * Math.log10(power / most)) / RANGE_DB)) || 0);
}

/** Add the A-weighted power of rows to a spectrogram, from windows of one size. */
async function addRows(powers, samples, size, rows) {
  const hop = size / 4, frames = Math.ceil(samples.length / hop) + 1, byFrame = [];
  const shape = Float64Array.from({ length: size }, (_, i) => Math.sin((Math.PI * (i + 0.5)) / size) ** 2);
  let begun = performance.now();
  for (let frame = 0; frame < frames; frame++) {
    byFrame.push(rowsOfFrame(samples, frame * hop - size / 2, shape, rows));
    if (performance.now() - begun > SLICE_MS) {
      await new Promise((soon) => { setTimeout(soon); });
      begun = performance.now();
    }
  }
  for (let column = 0; column < ACROSS; column++) {
    const [begin, end] = [column, column + 1].map((edge) => (edge * samples.length) / ACROSS / hop);
    const first = Math.floor(begin), last = Math.min(frames - 1, Math.ceil(end));
    rows.forEach((row, k) => {
      let sum = 0;
      for (let frame = first; frame <= last; frame++) sum += byFrame[frame][k];
      powers[column * ROWS + row] = sum / (last - first + 1);
    });
  }
}

/** Return the A-weighted power of rows in a window that begins at a sample, zero outside the record. */
function rowsOfFrame(samples, first, shape, rows) {
  const size = shape.length, windowed = new Float64Array(size);
  for (let i = Math.max(0, -first); i < Math.min(size, samples.length - first); i++) windowed[i] = shape[i] * samples[first + i];
  const { re, im } = linesOfRecord(windowed, size), sums = new Float64Array(size / 2 + 1); // over the lines below each
  for (let line = 0; line < size / 2; line++) sums[line + 1] = sums[line] + re[line] ** 2 + im[line] ** 2;
  const upTo = (hertz) => { // a line reaches half its distance to either side
    const place = Math.min(size / 2 - 1e-9, (hertz * size) / RATE + 0.5), line = Math.floor(place);
    return sums[line] + (place - line) * (sums[line + 1] - sums[line]);
  };
  return rows.map((row) => {
    const [from, to] = [row, row + 1].map((edge) => LOW_HZ * 2 ** (edge / ROWS_PER_OCTAVE));
    return ((upTo(to) - upTo(from)) / size ** 2) * aWeight(middleOf(row)) ** 2;
  });
}

// ---- painting ----

/** Return three numbers from 0 to 255 of a colour of the page. */
function colourOf(name) {
  const pen = new OffscreenCanvas(1, 1).getContext("2d");
  pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue(name);
  pen.fillRect(0, 0, 1, 1);
  return [...pen.getImageData(0, 0, 1, 1).data].slice(0, 3);
}

/** Paint the spectrogram from the ground of the page over its accent to its ink. */
function paint(levels, lowest) {
  const canvas = $("#heard-bands"), pen = canvas.getContext("2d"), image = pen.createImageData(ACROSS, ROWS);
  const stops = ["--ground", "--accent", "--ink"].map(colourOf);
  for (let column = 0; column < ACROSS; column++) {
    for (let row = 0; row < ROWS; row++) {
      if (middleOf(row) < lowest) continue; // which stays empty
      const place = (2 * levels[column * ROWS + row]) / 255, below = Math.min(1, Math.floor(place));
      const colour = stops[below].map((value, i) => value + (place - below) * (stops[below + 1][i] - value));
      image.data.set([...colour, 255], 4 * ((ROWS - 1 - row) * ACROSS + column));
    }
  }
  pen.putImageData(image, 0, 0);
}

/** Label frequencies and times, and say what the picture shows. */
function showAxes(lowest) {
  const label = (text, style) => Object.assign(document.createElement("span"), { textContent: text, style });
  let last = -Infinity;
  const frequencies = LABELS_HZ.filter((hertz) => {
    const isShown = hertz >= 0.999 * lowest && heightOf(hertz) - last > LABELS_APART && hertz < 20000;
    if (isShown) last = heightOf(hertz);
    return isShown;
  });
  $("#heard-frequencies").replaceChildren(...frequencies.map((hertz) => label(hertzText(hertz), `bottom: ${100 * heightOf(hertz)}%`)));
  const length = lengthOf(state.run), decade = 10 ** Math.floor(Math.log10(length)), step = decade * (length / decade < 2 ? 0.25 : length / decade < 5 ? 0.5 : 1) * (innerWidth < 700 ? 2 : 1);
  const times = Array.from({ length: Math.floor(length / step + 1e-9) + 1 }, (_, k) => k * step);
  $("#heard-times").replaceChildren(...times.map((time) => label(`${Number(time.toPrecision(6))} s`, `left: ${(100 * time) / length}%`)));
  const bottom = Math.round(lowest) > LOW_HZ ? `${Number(lowest.toPrecision(2))} Hz, the lowest that a record of ${Number(length.toPrecision(2))} s resolves,` : "20 Hz";
  $("#heard-words").textContent = `Waveform at the gain that you hear, and spectrogram from ${bottom} to 20 kHz: the A-weighted level in each twelfth of an octave, from the maximum of this record to ${RANGE_DB} dB below it.`;
}

/** Mark the solved part of a long record, and the place from which on it is raised. */
function showSolved() {
  const { solved, raised } = soundOf(state.run), length = lengthOf(state.run), isLong = solved < 0.99 * length;
  $("#heard-raised").hidden = raised === null;
  $("#heard-raised").style.left = `${(100 * raised) / length}%`;
  $("#heard-solved").hidden = !isLong;
  $("#heard-solved i").style.width = `${(100 * solved) / length}%`;
  $("#heard-solved span").textContent = isLong ? `The first ${Number(solved.toPrecision(2))} s are solved; the rest goes on at random with the same statistics.` : "";
}

/** Let a pointer on the pictures seek, and paint them again in other colours. */
export function listenToHeard(seek) {
  const plot = $("#heard-plot");
  const seekAt = ({ clientX }) => {
    const { left, width } = plot.getBoundingClientRect();
    seek(Math.min(1, Math.max(0, (clientX - left) / width)) * lengthOf(state.run));
  };
  plot.addEventListener("pointerdown", (event) => {
    if (event.button > 0) return;
    plot.setPointerCapture(event.pointerId);
    $("#seek").focus({ preventScroll: true });
    event.preventDefault(); // or the press would take the focus away again
    seekAt(event);
  });
  plot.addEventListener("pointermove", (event) => plot.hasPointerCapture(event.pointerId) && seekAt(event));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", showHeard);
}
