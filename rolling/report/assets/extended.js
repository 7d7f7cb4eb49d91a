// ---- extended records: the algorithm of acoustics/extension.py ----

const EDGES_HZ = Array.from({ length: 32 }, (_, k) => 10 ** ((25 + 2 * k) / 20)); // of the third octaves

/** Sums over third octaves of lines that lie `width` Hz apart. */
function bandSums(lines, width) {
  return EDGES_HZ.slice(1).map((high, band) => {
    let sum = 0;
    for (let k = Math.ceil(EDGES_HZ[band] / width); k * width < high && k < lines.length; k++) sum += lines[k];
    return sum;
  });
}

/** A phase for each line from a hash of its number (lowbias32). */
function phase(line) {
  let x = line | 0;
  x = Math.imul(x ^ (x >>> 16), 0x7feb352d);
  x = Math.imul(x ^ (x >>> 15), 0x846ca68b);
  return ((x ^ (x >>> 16)) >>> 0) * ((2 * Math.PI) / 2 ** 32);
}

/** Stationary Gaussian noise of `samples`, a power of two, with the spectrum of a record of several laps. */
function extend(record, samples, laps) {
  const lines = lineSpectrum(record);
  const group = (place) => Math.floor(place / laps + 0.5);
  const count = new Float64Array(group(lines.length - 1) + 2), power = new Float64Array(count.length);
  const shared = new Float64Array(samples / 2 + 1);
  const own = (j) => group((j * record.length) / samples);
  lines.forEach((line, k) => { power[group(k)] += line; });
  shared.forEach((_, j) => { count[own(j)]++; });
  shared.forEach((_, j) => { shared[j] = power[own(j)] / count[own(j)]; });
  const [re, im] = [new Float64Array(samples), new Float64Array(samples)];
  const wanted = bandSums(lines, RATE / record.length), present = bandSums(shared, RATE / samples);
  const width = RATE / samples;
  wanted.forEach((sum, band) => {
    const factor = present[band] > 0 ? sum / present[band] : 0;
    for (let j = Math.ceil(EDGES_HZ[band] / width); j * width < EDGES_HZ[band + 1] && j < samples / 2; j++) {
      const amplitude = Math.sqrt((shared[j] * factor) / 2), angle = phase(j);
      re[j] = re[samples - j] = amplitude * Math.cos(angle);
      im[j] = amplitude * Math.sin(angle);
      im[samples - j] = -im[j];
    }
  });
  transform(re, im, 1);
  return Float32Array.from(re);
}

/** A record of changing speed, again and again with half a second of silence between. */
function gesture(record, samples) {
  const all = new Float32Array(samples), period = record.length + RATE / 2;
  for (let at = 0; at < samples; at += period) all.set(record.subarray(0, samples - at), at);
  return all;
}

function kurtosis(samples) {
  let [second, fourth] = [0, 0];
  for (const x of samples) {
    second += x * x;
    fourth += x ** 4;
  }
  return (fourth * samples.length) / second ** 2;
}

const peakOf = (samples) => samples.reduce((most, x) => Math.max(most, Math.abs(x)), 0);

/** Extends all records, with a pause after each in which the page can be used. */
async function makeExtended(samples) {
  await decode().then((buffers) => { state.buffers = buffers; });
  const made = [];
  for (const [number, run] of runs.entries()) {
    $("#extending").textContent = `making record ${number + 1} of ${runs.length}`;
    await new Promise((done) => setTimeout(done));
    const record = state.buffers[number].record.getChannelData(0);
    const content = run.extendable ? extend(record, samples, run.laps) : gesture(record, samples);
    const buffer = new AudioBuffer({ length: samples, sampleRate: RATE });
    buffer.copyToChannel(content, 0);
    made.push(buffer);
  }
  return made;
}

/** The factors that bring the highest peak of all extended records to that of the records. */
function trims(buffers) {
  const peaks = buffers.map((buffer) => peakOf(buffer.getChannelData(0)));
  const loudest = (mode) => Math.max(...runs.map(({ playback }, k) => peaks[k] * playback[mode]));
  const limit = 10 ** (-1 / 20);
  return Object.fromEntries(["calibrated", "equal"].map((mode) => [mode, Math.min(1, limit / loudest(mode) || 1)]));
}

const MAKERS = { record: () => [], extended: makeExtended, row: async () => [await makeRow()] };

const choice = (source) => $(`input[name=source][value=${source}]`);

/** Goes back to the records as they are, one of which is heard at a time. */
async function toRecords() {
  if (!choice("record") || choice("record").checked) return;
  choice("record").checked = true;
  await setSource("record");
}

async function setSource(source) {
  let goesOn = state.wanted;
  pause();
  if (source === "row") endTest(); // which needs one run at a time
  $("#length").disabled = $("#save-extended").disabled = source !== "extended";
  const samples = 2 ** Number($("#length").value);
  const made = await MAKERS[source](samples);
  $("#extending").textContent = "";
  if ($("input[name=source]:checked").value !== source || (made.length && 2 ** Number($("#length").value) !== samples)) return;
  goesOn ||= state.wanted; // begun while they were made
  pause();
  Object.assign(state, { source, extended: made, trim: source === "extended" ? trims(made) : { calibrated: 1, equal: 1 }, drawn: "" });
  Object.assign(state, { at: 0, from: 0, end: total() });
  $("#seek").max = total();
  setLoop(made.length > 0 || runs.every((run) => run.loops && !run.buzzes));
  showMode();
  showExtension();
  say({ record: "the records", extended: `extended records of ${total().toFixed(1)} s`, row: "all seeds in a row" }[source]);
  if (goesOn) play();
  else render();
}

/** What the extended record of the chosen run is. */
function showExtension() {
  const note = $("#extension");
  if (!note) return;
  note.hidden = state.source !== "extended";
  if ($("#row")) $("#row").hidden = state.source !== "row";
  if (note.hidden) return;
  const { label, extendable, kurtosis: own } = runs[state.run];
  const quieter = -20 * Math.log10(state.trim[state.mode]);
  const text = extendable
    ? `${label}: kurtosis of the record ${own.toFixed(1)}, extended ${kurtosis(state.extended[state.run].getChannelData(0)).toFixed(1)} (Gaussian noise: 3).`
    : `${label} ${own === null ? "is silent" : "changes its speed: it plays as one gesture, again and again"}.`;
  $("#extension-numbers").textContent = text + (quieter > 0.05 ? ` All play ${quieter.toFixed(1)} dB quieter, so that no peak is clipped.` : "");
}

/** Saves the extended record of the chosen run, its peak at -1 dB; the name says the full scale. */
function saveExtended() {
  if (state.source !== "extended") return;
  const samples = state.extended[state.run].getChannelData(0);
  const gain = 10 ** (-1 / 20) / (peakOf(samples) || 1);
  const pascal = (runs[state.run].playback.full_scale_pa / gain).toPrecision(4);
  download(wavOf(samples.map((x) => gain * x)), "audio/wav", `extended-${runs[state.run].slug}-full-scale-${pascal}-Pa.wav`);
}
