// ---- meters: level, spectrum, and force ----

import { $, data, motionUnwanted, runs, signed } from "./core.js";
import { RATE } from "../engine/rate.js";
import { aWeight } from "../engine/radiation.js";
import { SPECTRUM, live, liveOf } from "./play_live.js";

const COLUMNS = 125; // of the strip, one per report: 4 s
const COLUMN_MS = 32; // of a report
const STRIP_ABOVE = 8; // of the strip above its highest value,
const STRIP_HIGH = 116; // and its whole height
const SHOWN_MS = 120; // between changes of numbers and curves
const SLOW_MS = 1000; // between them where motion is unwanted
const SMOOTHED = 0.5; // weight of the latest spectrum in the shown average
const LEVELS_DB = 70; // that the spectrum shows
const QUIETEST_DB = -20; // level that is shown
const TIGHT_DB = -0.5; // gain below which the page mentions the limiter
const FAST_S = 0.125; // time constant of the level
const WINDOW = 0.3046; // mean square of the window of an AnalyserNode, after Blackman
const BANDS = data.bands.map(Number);

const heard = { strip: [], powers: BANDS.map(() => 0), fast: 0, fastAt: 0, top: 0, shownAt: 0, gain: 0 };

const newtons = (force) => (Math.abs(force) < 1 ? `${Number((1e3 * force).toPrecision(3))} mN` : `${Number(force.toPrecision(3))} N`);
const pascals = (pressure) => `${Number(pressure.toPrecision(2))} Pa`;

/** Show a report of the processor on the meters. */
export function showReport(report) {
  const { low, high, flies } = report, now = performance.now();
  const column = { low: Math.min(...low), high: Math.max(...high), flies: flies.reduce((sum, share) => sum + share, 0) / flies.length };
  heard.strip = [...heard.strip, column].slice(-COLUMNS);
  heard.gain = Math.min(0.95 * heard.gain, 20 * Math.log10(live.limited)); // its note stays for some seconds
  takeLevel(now);
  if (now - heard.shownAt < (motionUnwanted.matches ? SLOW_MS : SHOWN_MS)) return;
  heard.shownAt = now;
  showNumbers(report);
  showSpectrum();
  showStrip();
}

/** Return the mean square pressure in each line of an analyser, over (20 µPa)². */
function linesOf(analyser) {
  const levels = new Float32Array(analyser.frequencyBinCount);
  analyser.getFloatFrequencyData(levels);
  return levels.map((level) => (2 * 10 ** (level / 10)) / WINDOW / 20e-6 ** 2);
}

/** Update the A-weighted mean square with the time constant of the Fast level. */
function takeLevel(now) {
  const [meter] = live.meters;
  const square = linesOf(meter).reduce((sum, power, line) => sum + power * aWeight((line * RATE) / meter.fftSize) ** 2, 0);
  heard.fast += (square - heard.fast) * (1 - Math.exp((heard.fastAt - now) / 1000 / FAST_S));
  heard.fastAt = now;
}

/** Tell whether the latest level is too low to be shown. */
export const isFaint = () => !(10 * Math.log10(heard.fast) >= QUIETEST_DB);

export const digits = (value, count) => Number(value.toPrecision(count));

function showNumbers({ state: { speed, force, height }, asleep }) {
  const level = 10 * Math.log10(heard.fast), own = liveOf().level, isHeard = !asleep && !isFaint();
  $("#play-level").textContent = isHeard ? level.toFixed(1) : "–";
  $("#play-against").textContent = isHeard && own !== null ? `${signed(level - own)} dB against the run` : "";
  $("#play-speed-now").textContent = `${digits(Math.abs(speed) < 1e-5 ? 0 : speed, 2)} m/s`.replace("-", "−");
  const presses = force !== null; // a release has no force
  const flown = Math.round((100 * heard.strip.reduce((sum, { flies }) => sum + flies, 0)) / heard.strip.length);
  $("#play-force-now").parentElement.hidden = !presses;
  $("#play-force-now").textContent = presses ? newtons(force) : "";
  const motion = height > 1e-4 ? `${digits(1e3 * height, 2)} mm high` : flown ? `flies ${flown} % of the time` : "in contact";
  $("#play-flight").textContent = presses ? motion : "";
  $("#play-limit").hidden = heard.gain > TIGHT_DB;
}

/** Write the texts of an axis, each at its share of the height from above. */
function showTicks(selector, ticks) {
  $(selector).replaceChildren(...ticks.map(([text, at]) => {
    const tick = Object.assign(document.createElement("span"), { textContent: text.replace("-", "−") });
    tick.style.setProperty("--at", Math.min(Math.max(at, 0.04), 0.96));
    return tick;
  }));
}

const draw = (selector, steps) => $(selector).setAttribute("d", steps.join(" "));

/** Draw the range of force, or of pressure for a release, of each report, and shade flights. */
export function showStrip() {
  const release = liveOf().kind === "release", middle = release ? 0 : live.settings.load;
  const reach = Math.max(1e-3 * middle, ...heard.strip.flatMap(({ low, high }) => [high - middle, middle - low])) || 1;
  const y = (value) => 50 - (50 * (value - middle)) / reach;
  const at = (k) => COLUMNS - heard.strip.length + k + 0.5;
  draw("#play-range", heard.strip.map(({ low, high }, k) => `M ${at(k)} ${y(high)} V ${y(low) + 1}`));
  draw("#play-flights", heard.strip.map(({ flies }, k) => `M ${at(k)} 100 v ${-100 * flies}`));
  const shown = release ? pascals : newtons, strip = (value) => (STRIP_ABOVE + y(value)) / STRIP_HIGH;
  showTicks("#play-forces", [1, 0, -1].map((side) => middle + side * digits(reach, 2)).map((value) => [shown(value), strip(value)]));
  $("#play-scale").textContent = `${release ? "Pressure" : "Contact force; dashed: the load"}. Each column is the range in ${COLUMN_MS} ms${release ? "" : ", shaded where the ball flies"}.`;
}

/** Sum the lines of the latest samples to third octaves, over (20 µPa)². */
function showSpectrum() {
  const powers = BANDS.map(() => 0);
  linesOf(live.meters[1]).forEach((power, line) => {
    const band = Math.floor(10 * Math.log10((line * RATE) / SPECTRUM) - 12.5); // 0 at 20 Hz
    if (band in powers) powers[band] += power;
  });
  heard.powers = heard.powers.map((before, i) => before + SMOOTHED * (powers[i] - before));
  drawSpectrum();
}

/** Draw the third octaves of the played sound as bars, and of the run's record as steps. */
export function drawSpectrum() {
  const own = runs[live.number].bands, sounding = heard.powers.map((power) => 10 * Math.log10(power));
  const wanted = 10 * Math.ceil((Math.max(...sounding, ...own.map((level) => level ?? -Infinity)) + 3) / 10);
  if (Number.isFinite(wanted) && (wanted > heard.top || wanted < heard.top - 15)) heard.top = wanted;
  showTicks("#play-levels", [0, 20, 40, 60].map((below) => [`${heard.top - below} dB`, below / LEVELS_DB]));
  const isShown = (level) => level !== null && level > heard.top - LEVELS_DB;
  const steps = (levels, step) => levels.flatMap((level, i) => (isShown(level) ? step(i, heard.top - level) : []));
  draw("#play-bars", steps(sounding, (i, y) => `M ${i + 0.5} ${LEVELS_DB} V ${y}`));
  draw("#play-run-bands", steps(own, (i, y) => `M ${i} ${y} h 1`));
}
