// ---- drawing of charts: SVG of the size of the screen, coloured by its style ----

import { scaleOf, ticksOf } from "./chart_scale.js";

const DASHES = { "-.": "8 3 1.5 3", ":": "1.5 2.5" };
const BROKEN = ["7 3", "12 3", "5 2 1.5 2 1.5 2", "3 2"]; // of the styles that are written --
const MARKS = {
  o: "M-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0z", s: "M-2.8-2.8h5.6v5.6h-5.6z", "^": "M0-3.5l3.4 6h-6.8z", D: "M0-4l4 4l-4 4l-4-4z",
  v: "M0 3.5l3.4-6h-6.8z", P: "M-1.2-3.6h2.4v2.4h2.4v2.4h-2.4v2.4h-2.4v-2.4h-2.4v-2.4h2.4z", X: "M-3-3l6 6M-3 3l6-6",
};
const LETTER = 6.4; // width of a letter of a label [pixels]
const ROW = 16;

/** Return a function that makes elements of a kind of markup with attributes and children. */
const making = (space) => (name, attributes = {}, ...children) => {
  const made = document.createElementNS(`http://www.w3.org/${space}`, name);
  for (const [key, value] of Object.entries(attributes)) if (value !== null && value !== undefined) made.setAttribute(key, value);
  made.append(...children);
  return made;
};
export const drawn = making("2000/svg"), make = making("1999/xhtml");
export const isGrey = (colour) => new Set(colour.slice(1).match(/../g)).size === 1 && colour !== "#000000";

export const markOf = (part, chart) => MARKS[part.size > 6 ? "D" : chart.curves[part.of]?.marker] ?? MARKS.o;

/** Dashes of a curve, different from those of the curves before it. */
export function dashesOf(curves, number) {
  const { dash } = curves[number];
  if (dash !== "--") return DASHES[dash] ?? null;
  return BROKEN[curves.slice(0, number).filter((curve) => curve.dash === "--").length % BROKEN.length];
}

/** Break a text into rows of at most so many letters. */
export function rowsOf(text, letters) {
  const rows = [""];
  for (const word of text.split(" ")) {
    const longer = `${rows.at(-1)} ${word}`.trim();
    if (longer.length > letters && rows.at(-1)) rows.push(word);
    else rows[rows.length - 1] = longer;
  }
  return rows;
}

export const labelOf = ({ label, unit }) => (unit ? `${label} [${unit}]` : label);

/** Places of axes, plot and labels for a width in pixels. */
export function layoutOf(chart, view, width) {
  const image = chart.parts.find((part) => part.kind === "image"), bar = image?.scale;
  const sides = view.y.map((axis) => ticksOf(axis, 7)), scaleTicks = bar ? ticksOf(bar, 5) : [];
  const widest = (ticks) => Math.max(2, ...ticks.map(([, text]) => text.length)) * LETTER + 12;
  const left = widest(sides[0]), right = bar ? widest(scaleTicks) + 26 : sides[1] ? widest(sides[1]) : 14;
  const bottom = rowsOf(labelOf(chart.x), Math.floor((width - 16) / LETTER));
  const heads = [labelOf(view.y[0]), bar ? labelOf(bar) : view.y[1] ? labelOf(view.y[1]) : ""];
  const crowded = heads[1] && (heads[0].length + heads[1].length + 3) * LETTER > width;
  const top = (crowded ? 2 : 1) * ROW + 10, below = 24 + ROW * bottom.length;
  let across = width - left - right, high = chart.high ?? Math.min(400, Math.max(210, 0.46 * width));
  if (chart.aspect) {
    const share = (chart.aspect * Math.abs(view.y[0].limits[1] - view.y[0].limits[0])) / Math.abs(view.x.limits[1] - view.x.limits[0]);
    [across, high] = across * share > 420 ? [420 / share, 420] : [across, across * share];
    if (high < 60) high = 60;
  }
  const box = { left, top, right: left + across, bottom: top + high };
  const x = scaleOf(view.x.limits, view.x.log, box.left, box.right), barred = chart.xs[chart.parts.find((part) => part.kind === "errors")?.x] ?? [];
  const gaps = barred.slice(1).map((place, k) => x.pixel(place) - x.pixel(barred[k])).filter((gap) => gap > 0);
  return {
    x, step: Math.min(4, Math.min(...gaps, 99) / (1 + chart.offsets.filter(Boolean).length)), width, height: box.bottom + below, box, sides, bar, scaleTicks, image, bottom, heads, crowded,
    y: view.y.map(({ limits, log }) => scaleOf(limits, log, box.bottom, box.top)),
  };
}

/** Give an element the shape of a chart. */
export const sizeChart = (svg, { width, height }) => svg.setAttribute("viewBox", `0 0 ${width} ${Math.ceil(height)}`);

/** Draw a chart into an element and return its places. */
export function drawChart(svg, chart, view, width) {
  const places = layoutOf(chart, view, width), { box } = places, name = `clip-${chart.number ?? "x"}`;
  sizeChart(svg, places);
  const clip = drawn("clipPath", { id: name }, drawn("rect", rectOf(box.left, box.top - 1, box.right, box.bottom + 1)));
  const plot = drawn("g", { class: "parts", "clip-path": `url(#${name})` });
  if (chart.ground) plot.append(drawn("rect", { ...rectOf(box.left, box.top, box.right, box.bottom), fill: chart.ground }));
  const groups = chart.curves.map((_, number) => drawn("g", { "data-curve": number }));
  const behind = ["span", "image", "band"];
  for (const part of chart.parts) {
    if (view.hidden.has(chart.curves[part.of]?.name)) continue;
    const shape = shapeOf(part, chart, places), group = behind.includes(part.kind) ? plot : groups[part.of] ?? plot;
    shape.style.setProperty("--c", chart.paints[part.of] ?? "");
    group.append(shape);
  }
  plot.append(...groups);
  const middle = { x: (box.left + box.right) / 2, y: (box.top + box.bottom) / 2, class: "silent" };
  const texts = chart.texts.map((text) => drawn("text", middle, text));
  svg.replaceChildren(drawn("defs", {}, clip), drawAxes(chart, view, places), plot, ...texts, drawn("g", { class: "over" }));
  return places;
}

const rectOf = (x0, y0, x1, y1) => ({ x: Math.min(x0, x1), y: Math.min(y0, y1), width: Math.abs(x1 - x0), height: Math.abs(y1 - y0) });

/** Draw grid, ticks, labels and colour bar. */
function drawAxes(chart, view, places) {
  const { box, x, y, sides, bar, scaleTicks, width } = places, axes = drawn("g", { class: "axes" });
  const rows = (texts, attributes, step) => texts.map((text, k) => drawn("text", { ...attributes, y: attributes.y + step * k }, text));
  const room = Math.max(2, Math.floor((box.right - box.left) / (view.x.names.some(([, text]) => text.length > 5) ? 80 : 46)));
  for (const [value, text] of ticksOf(view.x, room)) {
    const at = x.pixel(value).toFixed(1);
    axes.append(drawn("path", { d: `M${at} ${box.top}V${box.bottom}`, class: "grid" }), drawn("text", { x: at, y: box.bottom + ROW, class: "middle" }, text));
  }
  sides.forEach((ticks, side) => {
    for (const [value, text] of ticks) {
      const at = y[side].pixel(value);
      if (!side) axes.append(drawn("path", { d: `M${box.left} ${at.toFixed(1)}H${box.right}`, class: "grid" }));
      axes.append(drawn("text", { x: side ? box.right + 6 : box.left - 6, y: at + 4, class: side ? null : "end" }, text));
    }
  });
  axes.append(drawn("path", { d: `M${box.left} ${box.bottom}H${box.right}`, class: "frame" }));
  axes.append(drawn("text", { x: 2, y: ROW - 2, class: "label" }, places.heads[0]));
  const second = { x: bar ? Math.min(width, box.right + 90) - 2 : width - 2, y: (places.crowded ? 2 : 1) * ROW - 2, class: "label end" };
  if (places.heads[1]) axes.append(drawn("text", second, places.heads[1]));
  axes.append(...rows(places.bottom, { x: (box.left + box.right) / 2, y: box.bottom + 2 * ROW + 3, class: "label middle" }, ROW));
  if (bar) axes.append(...drawBar(places, scaleTicks));
  return axes;
}

function drawBar({ box, image, bar }, ticks) {
  const { colours } = image, left = box.right + 12, step = (box.bottom - box.top) / colours.length;
  const shades = colours.map((fill, k) => drawn("rect", { x: left, y: box.bottom - (k + 1) * step, width: 12, height: step + 0.6, fill }));
  const { pixel } = scaleOf(bar.limits, bar.log, box.bottom, box.top);
  return [...shades, ...ticks.map(([value, text]) => drawn("text", { x: left + 18, y: pixel(value) + 4 }, text))];
}

/** Join places to a path that breaks where a number is missing. */
function pathOf(points) {
  let text = "", pen = "M";
  for (const [x, y] of points) {
    if (Number.isFinite(x) && Number.isFinite(y)) {
      text += `${pen}${x.toFixed(1)} ${Math.max(-9999, Math.min(9999, y)).toFixed(1)}`;
      pen = "L";
    } else pen = "M";
  }
  return text;
}

/** Draw a part of a curve at the places of the axes. */
function shapeOf(part, chart, { box, x, y, step }) {
  const { kind, of, ends } = part, at = chart.xs[part.x] ?? [], rise = y[part.right ? 1 : 0];
  const put = (value, scale) => (value === null ? NaN : scale.pixel(value)), px = (value) => put(value, x), py = (value) => put(value, rise);
  const dashes = of === undefined ? null : dashesOf(chart.curves, of), shift = step * (chart.offsets[of] ?? 0);
  if (kind === "rule") {
    const d = part.along ? `M${px(part.at)} ${box.top}V${box.bottom}` : `M${box.left} ${py(part.at)}H${box.right}`;
    return drawn("path", { d, class: of === undefined ? "rule" : "line", "stroke-dasharray": dashes });
  }
  if (kind === "span") {
    const low = box.bottom - 2 - 6 * chart.hatched.indexOf(of); // marks of bands stand one above the other
    return drawn("rect", { ...rectOf(px(ends[0]), part.hatch ? low - 5 : box.top, px(ends[1]), part.hatch ? low : box.bottom), class: "shade" });
  }
  if (kind === "bar") return drawn("rect", { ...rectOf(px(ends[0]), py(ends[2]), px(ends[1]), py(ends[3])), class: "bar", opacity: part.alpha });
  if (kind === "image") return drawn("image", { ...rectOf(px(ends[0]), py(ends[2]), px(ends[1]), py(ends[3])), href: part.png, preserveAspectRatio: "none" });
  if (kind === "band") {
    const rows = part.step ? (k) => [k, k + 1 < at.length ? k + 1 : k] : (k) => [k];
    const edge = (values) => at.flatMap((_, k) => rows(k).map((next) => [px(at[next]), py(values[k])]));
    return drawn("path", { d: `${pathOf([...edge(part.low), ...edge(part.high).reverse()])}Z`, class: part.alpha ? "band" : "band full" });
  }
  if (kind === "errors") {
    const d = at.map((place, k) => [px(place) + shift, py(part.low[k]), py(part.high[k])]).filter((bar) => bar.every(Number.isFinite));
    return drawn("path", { d: d.map(([a, low, high]) => `M${a} ${low}V${high}m-3 0h6M${a - 3} ${low}h6`).join(""), class: "errors" });
  }
  const group = drawn("g", { class: part.pale ? "pale" : null });
  if (kind === "steps") {
    const floor = part.base === undefined ? [] : [part.base], points = part.y.flatMap((value, k) => [[px(at[k]), py(value)], [px(at[k + 1]), py(value)]]);
    const down = (k) => floor.map((value) => [px(at[k]), py(value)]);
    group.append(drawn("path", { d: pathOf([...down(0), ...points, ...down(at.length - 1)]), class: "line", "stroke-dasharray": dashes }));
    return group;
  }
  const points = at.map((place, k) => [px(place), py(part.y[k])]);
  if (part.width !== undefined) {
    const style = { class: part.width < 0.5 ? "line hair" : part.width < 0.8 ? "line thin" : "line", opacity: part.alpha, "stroke-dasharray": part.width < 0.8 ? null : dashes };
    group.append(drawn("path", { d: pathOf(points), ...style }));
  }
  if (part.size !== undefined || (points.length === 1 && part.width !== undefined)) {
    const shape = markOf(part, chart), bare = part.width === undefined ? shift : 0;
    for (const [left, top] of points.filter((point) => point.every(Number.isFinite))) {
      group.append(drawn("path", { d: shape, transform: `translate(${(left + bare).toFixed(1)} ${top.toFixed(1)})`, class: part.open ? "mark open" : "mark" }));
    }
  }
  return group;
}

