// ---- what the ear hears, in numbers and curves ----

import { $, RATE, data, motionUnwanted, runs, signed } from "./core.js";
import { aWeight } from "../engine/radiation.js";
import { SPECTRUM, live, liveOf } from "./play_sound.js";

const STRIP_S = 4;
const COLUMNS = Math.round((STRIP_S * RATE) / 128); // one per block
const TEXT_MS = 250; // between changes of the numbers
const SLOW_MS = 1000; // between changes of the curves where motion is unwanted
const CURVES_MS = 60; // between changes of the curves
const SMOOTHED = 0.3; // share of the latest spectrum in the one that is shown
const LEVELS_DB = 70; // that the spectrum shows
const QUIETEST_DB = -20; // level that is shown
const REMARK_MS = 3000; // that a remark stays
const TIGHT_DB = -0.5; // gain of the limiter from which it is named
const FAST_S = 0.125; // time constant of the level
const WINDOW = 0.3046; // mean square of the window of an AnalyserNode, after Blackman

const strip = { low: new Float32Array(COLUMNS), high: new Float32Array(COLUMNS), flies: new Float32Array(COLUMNS), at: 0, reach: 0 };
const heard = { powers: null, fast: 0, fastAt: 0, top: null, texts: 0, curves: 0, gain: 0, flown: 0, remarked: 0 };

const newtons = (force) => (force < 1 ? `${Number((1e3 * force).toPrecision(3))} mN` : `${Number(force.toPrecision(3))} N`);

/** Takes a report of the processor into the meters. */
export function showReport(report) {
  const { low, high, flies } = report;
  for (let i = 0; i < flies.length; i++, strip.at = (strip.at + 1) % COLUMNS) {
    [strip.low[strip.at], strip.high[strip.at], strip.flies[strip.at]] = [low[i], high[i], flies[i]];
  }
  heard.gain = Math.min(heard.gain, live.limiter.reduction);
  heard.flown += (flies.reduce((sum, share) => sum + share, 0) / flies.length - heard.flown) * 0.1;
  const now = performance.now();
  takeLevel(now);
  if (now - heard.texts > TEXT_MS) showNumbers(report, now);
  if (now - heard.curves > (motionUnwanted.matches ? SLOW_MS : CURVES_MS)) {
    heard.curves = now;
    showSpectrum();
    drawStrip();
  }
}

/** Returns the mean squares of lines that an analyser hears now, in parts of (20 µPa)². */
function linesOf(analyser) {
  const levels = new Float32Array(analyser.frequencyBinCount);
  analyser.getFloatFrequencyData(levels);
  return levels.map((level) => (2 * 10 ** (level / 10)) / WINDOW / 20e-6 ** 2);
}

/** Follows the A-weighted mean square by the time constant of the Fast level. */
function takeLevel(now) {
  const [meter] = live.meters, square = linesOf(meter).reduce((sum, power, line) => sum + power * aWeight((line * RATE) / meter.fftSize) ** 2, 0);
  heard.fast += (square - heard.fast) * (1 - Math.exp((heard.fastAt - now) / 1000 / FAST_S));
  heard.fastAt = now;
}

const digits = (value, count) => Number(value.toPrecision(count));

function showNumbers({ state, asleep }, now) {
  heard.texts = now;
  const fast = 10 * Math.log10(heard.fast), level = asleep || !(fast >= QUIETEST_DB) ? null : fast;
  $("#play-level").textContent = level === null ? "–" : level.toFixed(1);
  $("#play-speed-now").textContent = `${digits(Math.abs(state.speed) < 1e-5 ? 0 : state.speed, 2)} m/s`.replace("-", "−");
  const presses = state.force !== null; // a release has no force
  $("#play-force-now").parentElement.hidden = !presses;
  if (presses) $("#play-force-now").textContent = newtons(state.force);
  const share = Math.round(100 * heard.flown);
  $("#play-flight").textContent = !presses ? "" : state.height > 1e-4 ? `${digits(1e3 * state.height, 2)} mm high` : share ? `flies ${share} % of the time` : "in contact";
  showRemark(now);
}

/** Says for a while that the limiter has lowered the sound. */
function showRemark(now) {
  let remark = "";
  if (heard.gain < TIGHT_DB) remark = `The limiter lowers the loudest sound by ${Math.ceil(-heard.gain)} dB; the level is that without it.`;
  heard.gain = 0;
  if (!remark && now - heard.remarked < REMARK_MS) return;
  if (remark) heard.remarked = now;
  $("#play-limit").textContent = remark;
}

/** Sizes a canvas to its box in device pixels and returns its pen, with width and height in CSS pixels. */
export function penOf(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas, scale = Math.min(window.devicePixelRatio || 1, 2);
  const [wide, high] = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, { width: wide, height: high });
  const pen = canvas.getContext("2d"), style = getComputedStyle(canvas);
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "13px system-ui, sans-serif";
  return { pen, width, height, colour: (name) => style.getPropertyValue(`--${name}`).trim() };
}

export function write(pen, text, x, y, align = "left") {
  pen.textAlign = align;
  pen.fillText(text, x, y);
}

/** Draws force, or pressure of the release, over the last seconds: its range in each block, and flights as shades. */
export function drawStrip() {
  const { pen, width, height, colour } = penOf($("#play-strip"));
  const release = liveOf().kind === "release", middle = release ? 0 : live.settings.load;
  const reach = Math.max(1e-3 * middle, ...strip.high.map((high, i) => (high ? Math.max(high - middle, middle - strip.low[i]) : 0)));
  strip.reach = reach > strip.reach ? reach : strip.reach + 0.05 * (reach - strip.reach);
  const bottom = release ? -strip.reach : Math.max(middle - strip.reach, 0), range = middle + strip.reach - bottom || 1;
  const y = (value) => height - 6 - ((value - bottom) / range) * (height - 32);
  const step = width / COLUMNS, columns = Array.from(strip.high, (_, i) => [i * step, (strip.at + i) % COLUMNS]);
  pen.fillStyle = colour("pale");
  for (const [x, k] of columns) {
    pen.globalAlpha = 0.3 * strip.flies[k];
    if (strip.flies[k]) pen.fillRect(x, 24, step + 0.5, height - 24);
  }
  pen.globalAlpha = 1;
  pen.fillStyle = colour("accent");
  for (const [x, k] of columns) {
    if (strip.high[k] || strip.low[k]) pen.fillRect(x, y(strip.high[k]), step + 0.3, Math.max(1.5, y(strip.low[k]) - y(strip.high[k])));
  }
  pen.strokeStyle = pen.fillStyle = colour("ink");
  pen.setLineDash([5, 5]);
  pen.stroke(new Path2D(`M 0 ${y(middle)} H ${width}`));
  pen.setLineDash([]);
  const force = bottom > 0 ? `force, load ± ${newtons(digits(strip.reach, 2))}` : `force, 0 to ${newtons(digits(middle + strip.reach, 2))}; dashed: load`;
  write(pen, release ? `pressure, ± ${digits(strip.reach, 2)} Pa` : force, 0, 14);
  write(pen, `${STRIP_S} s`, width, 14, "right");
}

const bandOf = (frequency) => Math.floor(10 * Math.log10(frequency) - 12.5); // 0 for the third octave at 20 Hz

/** Sums the spectrum of the latest samples in third octaves, in parts of (20 µPa)². */
function showSpectrum() {
  const powers = new Array(CENTRES.length).fill(0);
  linesOf(live.meters[1]).forEach((power, line) => {
    const band = bandOf((line * RATE) / SPECTRUM);
    if (band in powers) powers[band] += power;
  });
  heard.powers = heard.powers ? heard.powers.map((before, i) => before + SMOOTHED * (powers[i] - before)) : powers;
  drawSpectrum();
}

const BAND_MARKS = [[2, "31"], [7, "100"], [12, "315"], [17, "1k"], [22, "3.15k"], [27, "10k"]];
const CENTRES = data.bands.map(Number);
const levels = (powers) => powers.map((power) => (power > 0 ? 10 * Math.log10(power) : null));
const highest = (values) => Math.max(...values.map((value) => value ?? -Infinity));

/** Draws third octaves of what sounds as bars, and those of the run's record as a line of steps. */
export function drawSpectrum() {
  const { pen, width, height, colour } = penOf($("#play-spectrum"));
  const own = runs[live.number].bands, now = heard.powers ? levels(heard.powers) : own.map(() => null);
  const wanted = 10 * Math.ceil((Math.max(highest(now), highest(own)) + 3) / 10);
  if (!Number.isFinite(wanted)) return;
  heard.top = heard.top === null || wanted > heard.top || wanted < heard.top - 15 ? wanted : heard.top;
  const base = height - 22, step = (width - 34) / own.length;
  const y = (level) => base - (Math.max(level - heard.top + LEVELS_DB, 0) / LEVELS_DB) * (base - 22);
  pen.fillStyle = colour("pale");
  for (let level = heard.top; level > heard.top - LEVELS_DB; level -= 20) {
    pen.fillRect(34, Math.round(y(level)), width - 34, 0.5);
    write(pen, `${level}`.replace("-", "−"), 28, y(level) + 4, "right");
  }
  for (const [i, text] of BAND_MARKS) write(pen, text, 34 + (i + 0.5) * step, height - 4, "center");
  pen.fillStyle = colour("accent");
  const isShown = (level) => level !== null && level > heard.top - LEVELS_DB;
  now.forEach((level, i) => isShown(level) && pen.fillRect(34 + i * step + 1, y(level), step - 2, base - y(level)));
  pen.fillStyle = colour("ink");
  own.forEach((level, i) => isShown(level) && pen.fillRect(34 + i * step, y(level) - 0.75, step, 1.5));
  write(pen, "third octaves, dB; lines: the run", 34, 14);
  $("#play-against").textContent = live.report?.asleep ? "" : against(now, own);
}

/** Returns the difference of the A-weighted sum of bands to that of the run, in words. */
function against(now, own) {
  const total = (values) => values.reduce((sum, level, i) => sum + (level === null ? 0 : 10 ** (level / 10) * aWeight(CENTRES[i]) ** 2), 0);
  const [sounds, run] = [total(now), total(own)];
  return sounds > 10 ** (QUIETEST_DB / 10) && run > 0 ? `${signed(10 * Math.log10(sounds / run))} dB against the run` : "";
}
