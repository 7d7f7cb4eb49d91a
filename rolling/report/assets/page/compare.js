// ---- two runs compared: the difference of their spectra ----

import { $, data, runs } from "./core.js";
import { signed } from "./choices.js";

export const pair = () => ["#compare-a", "#compare-b"].map((selector) => Number($(selector).value));

/** Differences of the band levels of two runs in dB with their standard uncertainty; null where a level is missing. */
export function differences(a, b) {
  return data.bands.map((_, band) => {
    const [one, other] = [runs[a], runs[b]].map(({ bands, spreads }) => [bands[band], spreads[band]]);
    if (one[0] === null || other[0] === null) return null;
    return [other[0] - one[0], Math.hypot(one[1] ?? 0, other[1] ?? 0)];
  });
}

export function showDifference() {
  if (!$("#difference")) return;
  const [a, b] = pair();
  const found = differences(a, b);
  $("#difference").setAttribute("aria-label", `Third octaves of ${runs[b].label} minus third octaves of ${runs[a].label}; numbers below`);
  drawDifference(found);
  const rows = found.map((each, band) => {
    const row = document.createElement("tr");
    const head = Object.assign(document.createElement("th"), { scope: "row", textContent: data.bands[band] });
    const text = each ? `${signed(each[0])} ± ${each[1].toFixed(1)}` : "-";
    row.append(head, Object.assign(document.createElement("td"), { textContent: text }));
    return row;
  });
  $("#difference-numbers tbody").replaceChildren(...rows);
}

export function drawDifference(found) {
  const canvas = $("#difference");
  canvas.width = Math.min(1200, 2 * canvas.clientWidth || 1200);
  const pen = canvas.getContext("2d"), { width, height } = canvas;
  const style = getComputedStyle(canvas);
  const known = found.filter(Boolean);
  const most = Math.max(1, ...known.map(([value, spread]) => Math.abs(value) + Math.min(spread, 6)));
  const left = 64, right = 16, top = 34, bottom = 44, step = (width - left - right) / found.length;
  const middle = top + (height - top - bottom) / 2;
  const y = (decibel) => middle - (Math.max(-1, Math.min(1, decibel / (1.05 * most))) * (height - top - bottom)) / 2;
  pen.clearRect(0, 0, width, height);
  pen.font = "20px system-ui, sans-serif";
  pen.strokeStyle = pen.fillStyle = style.borderTopColor;
  const tick = [1, 2, 5, 10, 20, 50].find((size) => most / size <= 3) ?? 100;
  for (let at = -tick * Math.floor(most / tick); at <= most; at += tick) {
    pen.fillStyle = style.borderTopColor;
    pen.fillRect(left, y(at), width - left - right, at ? 1 : 2);
    pen.fillStyle = style.color;
    pen.textAlign = "right";
    pen.fillText(at > 0 ? `+${at}` : `${at}`.replace("-", "−"), left - 8, y(at) + 7);
  }
  pen.textAlign = "center";
  found.forEach((each, band) => {
    const x = left + (band + 0.5) * step;
    pen.fillStyle = style.color;
    if (band % (width > 800 ? 3 : 6) === 0) pen.fillText(data.bands[band].replace(/000$/, "k"), x, height - 12);
    if (!each) return;
    const [value, spread] = each;
    pen.fillStyle = style.accentColor;
    pen.fillRect(x - 0.36 * step, Math.min(y(0), y(value)), 0.72 * step, Math.abs(y(value) - y(0)));
    pen.fillStyle = style.color;
    pen.fillRect(x - 1.5, y(value + spread), 3, y(value - spread) - y(value + spread));
  });
  pen.textAlign = "left";
  pen.fillStyle = style.color;
  pen.fillText("dB, by third octave [Hz]", 8, 22);
}
