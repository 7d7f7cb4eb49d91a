// ---- two runs compared: the difference of their spectra ----

import { $, data, runs } from "./core.js";
import { openChart } from "./chart.js";

export const pair = () => ["#compare-a", "#compare-b"].map((selector) => Number($(selector).value));

/** Return the band differences [dB] of two runs with standard uncertainties, null without a level. */
function differences(a, b) {
  return data.bands.map((_, band) => {
    const [one, other] = [runs[a], runs[b]].map(({ bands, spreads }) => [bands[band], spreads[band]]);
    if (one[0] === null || other[0] === null) return null;
    return [other[0] - one[0], Math.hypot(one[1] ?? 0, other[1] ?? 0)];
  });
}

/** Draw the difference B - A of the chosen runs. */
export function showDifference() {
  const figure = $("#difference");
  if (!figure) return;
  const [a, b] = pair(), levels = differences(a, b), middle = data.bands.map(Number), half = 10 ** 0.05;
  const known = levels.flatMap((level, k) => (level ? [{ x: middle[k], value: level[0], spread: level[1] }] : []));
  const ends = known.flatMap(({ value, spread }) => [value - Math.min(spread, 6), value + Math.min(spread, 6)]), room = [Math.min(-1, ...ends), Math.max(1, ...ends)];
  const round = (value) => Number(value.toFixed(3));
  openChart(figure, {
    title: `${runs[b].label} minus ${runs[a].label}`, note: "third octaves, Z-weighted",
    x: { label: "third octave, nominal mid frequency", unit: "Hz", log: true, limits: [middle[0] / half, middle.at(-1) * half], names: data.bands.map((name, k) => [middle[k], shortName(name)]) },
    y: [{ label: "B − A", unit: "dB", log: false, limits: room.map((limit) => 1.05 * limit), names: [] }],
    xs: [known.map(({ x }) => x)], curves: [{ name: "", colour: "#0072b2", dash: "-", marker: "o" }], paints: [`var(--run-${b})`],
    parts: [
      ...known.map(({ x, value }) => ({ kind: "bar", of: 0, alpha: 0.6, ends: [x / half ** 0.8, x * half ** 0.8, 0, round(value)] })),
      { kind: "errors", of: 0, x: 0, low: known.map(({ value, spread }) => round(value - spread)), high: known.map(({ value, spread }) => round(value + spread)) },
      { kind: "rule", along: false, at: 0 },
    ],
  });
}

const shortName = (name) => (Number(name) >= 1000 ? `${Number(name) / 1000}k` : name);
