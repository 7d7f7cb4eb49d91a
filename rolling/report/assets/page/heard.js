// ---- the record that is heard: its waveform and its spectrogram, on which a pointer or a key seeks ----

import { $, lengthOf, soundOf, state } from "./core.js";
import { ACROSS, LOW_HZ, RANGE_DB, ROWS, ROWS_PER_OCTAVE, lowestOf, middleOf } from "../engine/picture_rows.js";
import { roundOf } from "./records.js";

const LABELS_HZ = [20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000];
const LABELS_APART = 0.09; // of the height of the spectrogram

const outlines = new Map(); // waveforms by sound of a run
const spectrograms = new Map(); // and promises of levels

const heightOf = (hertz) => (ROWS_PER_OCTAVE * Math.log2(hertz / LOW_HZ)) / ROWS; // 0 at the bottom, 1 at the top
const hertzText = (hertz) => (hertz < 1000 ? `${hertz} Hz` : `${hertz / 1000} kHz`);

/** Show the chosen run's record: the waveform once it is decoded, the spectrogram once it is analysed. */
export async function showHeard() {
  const number = state.run, sound = soundOf(number), isShown = () => sound === soundOf(state.run);
  const canvas = $("#heard-bands");
  canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
  if (!spectrograms.has(sound)) tellWait("The sound is being decoded.");
  const channels = await channelsOf(number), lowest = lowestOf(channels[0].length);
  if (!outlines.has(sound)) outlines.set(sound, outlineOf(channels));
  if (!isShown()) return;
  $("#heard-wave path").setAttribute("d", outlines.get(sound));
  showLoudness();
  showAxes(lowest);
  showSolved();
  try {
    if (!spectrograms.has(sound)) spectrograms.set(sound, analysed(channels[0], (share) => isShown() && tellWait(`The spectrogram is being computed: ${Math.round(100 * share)} %.`)));
    const levels = await spectrograms.get(sound);
    if (isShown()) paint(levels, lowest);
    if (isShown()) tellWait("");
  } catch {
    if (isShown()) tellWait("This browser does not compute the spectrogram here.");
  }
}

/** Say what is waited for in the box of the spectrogram; an empty sentence ends the wait. */
function tellWait(sentence) {
  $("#heard-wait").hidden = !sentence;
  $("#heard-wait").textContent = sentence;
}

// ---- the worker that analyses records ----

const analyst = { thread: null, asked: [] }; // and who waits for each of its answers

/** Return levels from 0 (quiet) to 255 (the maximum) by column and row; `tell` hears which share is done. */
function analysed(samples, tell) {
  analyst.thread ??= openAnalyst();
  tell(0);
  return new Promise((done, fail) => {
    const number = analyst.asked.push({ tell, done, fail }) - 1, own = samples.slice();
    analyst.thread.postMessage({ number, samples: own }, [own.buffer]);
  });
}

/** Start the worker, whose text stands in the page. */
function openAnalyst() {
  const thread = new Worker(`data:text/javascript;charset=utf-8,${encodeURIComponent($("#analyst").textContent)}`);
  thread.onmessage = ({ data: { number, share, levels } }) => {
    const { tell, done } = analyst.asked[number];
    if (levels) done(levels);
    else tell(share);
  };
  thread.onerror = (event) => {
    event.preventDefault(); // the page says it
    analyst.asked.forEach(({ fail }) => fail(event));
  };
  return thread;
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
