// ---- scales of charts: places, ticks, numbers, points and zoom ----

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const THIN = "\u202f"; // narrow no-break space before a unit or a prefix

/** Return the transforms between values within limits and pixels between two ends. */
export function scaleOf(limits, log, from, to) {
  const onto = log ? Math.log10 : Number, back = log ? (value) => 10 ** value : Number;
  const [low, high] = limits.map(onto), span = high - low || 1;
  return {
    pixel: (value) => from + ((onto(value) - low) / span) * (to - from),
    value: (pixel) => back(low + ((pixel - from) / (to - from)) * span),
  };
}

/** Write a number with so many digits, tiny and huge ones as a power of ten. */
export function worded(value, digits = 4) {
  if (!value) return "0";
  const power = Math.floor(Math.log10(Math.abs(value)) + 1e-12);
  if (power >= -3 && power <= 5) {
    const text = String(Number(value.toPrecision(Math.max(digits, power + 1))));
    return text.replace(/^(-?\d{2,3})(\d{3})$/, `$1${THIN}$2`).replace("-", "−");
  }
  const raised = [...String(power)].map((sign) => SUPERSCRIPTS[sign] ?? "⁻").join("");
  return `${Number((value / 10 ** power).toPrecision(digits))}·10${raised}`.replace("-", "−").replace(/^(−?)1·/, "$1");
}

/** Write a value with its unit: levels with one decimal, frequencies in kHz from 1 kHz. */
export function quantity(value, unit) {
  if (value === null || !Number.isFinite(value)) return "-";
  const [short] = unit.split(" re "), size = Math.abs(value);
  if (short.startsWith("dB")) return `${value.toFixed(1).replace("-", "−")} ${short}`;
  if (short === "Hz" && size >= 1000) return `${worded(value / 1000)} kHz`;
  return `${worded(value)}${short === "%" ? THIN : " "}${short}`.trim();
}

/** Return ticks of an axis with room for some labels, as pairs of value and text. */
export function ticksOf({ limits, log, names = [], unit }, room) {
  const [low, high] = [Math.min(...limits), Math.max(...limits)], slack = 1e-9 * (high - low);
  const within = (value) => value >= low - slack && value <= high + slack;
  const named = log && unit === "Hz" ? [] : names.filter(([value]) => within(value)); // decades read better than names of bands
  if (named.length > 1 || (named.length && named.length === names.length)) {
    const stride = [1, 2, 3, 6, 12].find((step) => named.length / step <= room) ?? Math.ceil(names.length / room);
    const anchor = Math.max(0, names.findIndex(([, name]) => name === "1k"));
    const kept = names.filter(([value], number) => within(value) && (number - anchor) % stride === 0);
    return kept.map(([value, name]) => [value, name.replace(/^([\d.]+)k$/, `$1${THIN}k`)]);
  }
  const values = log && high / low >= 10 ? logarithmic(low, high, room) : linear(low, high, unit === "Hz" ? room / 1.6 : room);
  const text = (value) => (unit === "Hz" && value >= 1000 ? `${worded(value / 1000, 12)}${THIN}k` : worded(value, 12));
  return values.filter(within).map((value) => [value, text(value)]);
}

function linear(low, high, room) {
  const rough = (high - low) / Math.max(1, room) || 1, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough * (1 - 1e-9));
  const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
  return Array.from({ length: Math.min(200, Math.max(0, last - first + 1)) }, (_, number) => Number(((first + number) * step).toPrecision(12)));
}

function logarithmic(low, high, room) {
  const decades = Math.log10(high / low), factors = 3 * decades <= room ? [1, 2, 5] : [1], stride = Math.ceil(decades / room);
  const values = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high) + 1e-9; power++) {
    if (power % stride === 0) values.push(...factors.map((factor) => Number(`${factor}e${power}`)));
  }
  return values.filter((value) => value >= low * (1 - 1e-9));
}

/** Return the point of a curve that is nearest to a pixel along x. */
export function nearest(points, pixelOf, pixel) {
  const away = (point) => Math.abs(pixelOf(point.x) - pixel);
  return points.reduce((best, point) => (away(point) < away(best) ? point : best), points[0]);
}

/** Return limits between two pixels of an axis, within its whole and no narrower than 1e-5 of it. */
export function zoomed({ limits, whole }, { pixel, value }, from, to) {
  const [first, last] = whole.map(pixel);
  if (from <= first && to >= last) return whole;
  return to - from < 1e-5 * (last - first) ? limits : [from <= first ? whole[0] : value(from), to >= last ? whole[1] : value(to)];
}

/** Return the readable points of each curve with their uncertainty, for steps and bars their middles. */
export function pointsOf({ xs, parts, curves, x: axis }) {
  const points = curves.map(() => []), middle = (a, b) => (axis.log ? Math.sqrt(a * b) : (a + b) / 2);
  const lined = new Set(parts.filter((part) => part.kind === "line" && part.y.length).map((part) => part.of));
  for (const { kind, of, x, y, low, high, ends, right = false } of parts) {
    const own = points[of], at = xs[x];
    if (!own) continue;
    if (kind === "line") {
      for (let k = 0; k < y.length; k++) {
        if (y[k] === null || at[k] === null) continue;
        const column = at[k + 1] === at[k] && y[k + 1] !== null; // minimum and maximum
        own.push(column ? { x: at[k], low: y[k], high: y[++k], right } : { x: at[k], y: y[k], right });
      }
    }
    if (kind === "band") at.forEach((place, k) => low[k] !== null && own.push({ x: place, low: low[k], high: high[k], right }));
    if (kind === "steps" && !lined.has(of)) y.forEach((value, k) => value !== null && own.push({ x: middle(at[k], at[k + 1]), y: value, right }));
    if (kind === "bar") own.push({ x: middle(ends[0], ends[1]), from: ends[0], y: ends[3], right });
  }
  for (const { kind, of, x, low, high } of parts.filter((part) => part.kind === "errors" && points[part.of])) {
    const key = (place) => place?.toPrecision(5), spreads = new Map(xs[x].map((place, k) => [key(place), (high[k] - low[k]) / 2]));
    for (const point of points[of]) if (spreads.get(key(point.x)) >= 0) point.spread = spreads.get(key(point.x));
  }
  return points.map((own) => own.filter((point, k) => !k || point.x !== own[k - 1].x || point.y !== own[k - 1].y));
}

/** Return the extremes of the positive numbers along x or y, for a logarithmic scale. */
export function positive(points, name) {
  const values = points.flat().map((point) => point[name] ?? point.low).filter((value) => value > 0);
  return values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, 0]);
}
