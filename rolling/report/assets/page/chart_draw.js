// ---- drawing of charts: SVG of the size of the screen, coloured by its style ----

import { scaleOf, ticksOf } from "./chart_scale.js";

const DASHES = { "-.": "8 3 1.5 3", ":": "1.5 2.5" };
const BROKEN = ["7 3", "12 3", "5 2 1.5 2 1.5 2", "3 2"]; // of the styles that are written --
const MARKS = {
  o: "M-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0z", s: "M-2.8-2.8h5.6v5.6h-5.6z", "^": "M0-3.5l3.4 6h-6.8z", D: "M0-4l4 4l-4 4l-4-4z",
  v: "M0 3.5l3.4-6h-6.8z", P: "M-1.2-3.6h2.4v2.4h2.4v2.4h-2.4v2.4h-2.4v-2.4h-2.4v-2.4h2.4z", X: "M-3-3l6 6M-3 3l6-6",
};
export const MAX_NAMES = 24; // of a legend
export const LETTER = 6.4; // width of a letter of a label [pixels]
const ROW = 16;
const HAIR = 0.5; // width below which the lines of a dense curve stand behind all curves

/** Return a function that makes elements of a kind of markup with attributes and children. */
const making = (space) => (name, attributes = {}, ...children) => {
  const made = document.createElementNS(`http://www.w3.org/${space}`, name);
  for (const [key, value] of Object.entries(attributes)) if (value !== null && value !== undefined) made.setAttribute(key, value);
  made.append(...children);
  return made;
};
export const drawn = making("2000/svg"), make = making("1999/xhtml");
export const isGrey = (colour) => new Set(colour.slice(1).match(/../g)).size === 1 && colour !== "#000000";

const markOf = (part, chart) => MARKS[part.size > 6 ? "D" : chart.curves[part.of]?.marker] ?? MARKS.o;

/** Return the dashes of a curve, which differ from the curves before it. */
function dashesOf(curves, number) {
  const { dash } = curves[number];
  if (dash !== "--") return DASHES[dash] ?? null;
  return BROKEN[curves.slice(0, number).filter((curve) => curve.dash === "--").length % BROKEN.length];
}

/** Return the names of the curves of a chart, each once. */
export const namesOf = ({ curves }) => [...new Set(curves.map((curve) => curve.name))].filter(Boolean);

/** Draw the key of the curves of a name, 30 by 12 pixels, for a legend. */
export function keyOf(chart, name) {
  const number = chart.curves.findIndex((curve) => curve.name === name), parts = chart.parts.filter((part) => part.of === number);
  const marked = parts.find((part) => part.size), lined = parts.some((part) => part.width || ["rule", "steps"].includes(part.kind));
  const filled = parts.find((part) => ["span", "bar", "band"].includes(part.kind) && !part.hollow), hollow = parts.some((part) => part.hollow), key = drawn("g", { style: `--c: ${chart.paints[number]}` });
  if (!parts.length) key.append(drawn("rect", { x: 9, y: 0, width: 12, height: 12, class: "bar" })); // a colour of an image
  if (hollow) key.append(drawn("rect", { x: 3, y: 1, width: 24, height: 10, class: "hollow" }));
  if (filled) key.append(drawn("rect", { x: 3, y: 1, width: 24, height: 10, class: "bar", opacity: filled.alpha }));
  else if (lined) key.append(drawn("path", { d: "M1 6H29", class: "line", "stroke-dasharray": dashesOf(chart.curves, number) }));
  if (marked) key.append(drawn("path", { d: markOf(marked, chart), transform: "translate(15 6)", class: lined ? "mark" : "mark open" }));
  return key;
}

/** Break a text into rows of at most so many letters, longer words on rows of their own. */
export const rowsOf = (text, letters) => text.match(new RegExp(`\\S.{0,${letters - 1}}(?=\\s|$)|\\S+`, "g")) ?? [""];

const labelOf = ({ label, unit }) => (unit ? `${label} [${unit}]` : label);

/** Return the rows of the labels of the axes on both sides, beside each other where they have room. */
function headRows(heads, width) {
  const letters = Math.floor((width - 4) / LETTER), beside = heads.join("  ").length <= letters;
  const rows = heads.map((text) => rowsOf(text, letters));
  return rows.flatMap((texts, side) => texts.map((text, k) => ({ text, side, row: k + (side && !beside ? rows[0].length : 0) })));
}

/** Return the places of axes, plot and labels for a width in pixels. */
export function layoutOf(chart, view, width) {
  const image = chart.parts.find((part) => part.kind === "image"), bar = image?.scale, second = bar ?? view.y[1];
  const sides = [view.y[0], second].map((axis) => (axis ? ticksOf(axis, axis === bar ? 5 : 7) : []));
  const [left, right] = sides.map((ticks) => Math.max(2, ...ticks.map(([, text]) => text.length)) * LETTER + 12);
  const bottom = rowsOf(labelOf(chart.x), Math.floor((width - 16) / LETTER)), heads = [view.y[0], second].filter(Boolean).map(labelOf);
  const headed = headRows(heads, width), top = (Math.max(...headed.map(({ row }) => row)) + 1) * ROW + 10;
  let across = width - left - (second ? right + (bar ? 26 : 0) : 14), high = chart.high ?? Math.min(400, Math.max(210, 0.46 * width));
  if (chart.aspect) {
    const [wide, tall] = [chart.x, chart.y[0]].map(({ limits }) => Math.abs(limits[1] - limits[0])), share = (chart.aspect * tall) / wide;
    across = Math.min(across, 420 / share);
    high = Math.max(60, across * share);
  }
  const box = { left, top, right: left + across, bottom: top + high }, x = scaleOf(view.x.limits, view.x.log, box.left, box.right);
  const barred = chart.xs[chart.parts.find((part) => part.kind === "errors")?.x]?.map(x.pixel) ?? [];
  const gaps = barred.slice(1).map((pixel, k) => pixel - barred[k]).filter((gap) => gap > 0);
  return {
    box, x, y: view.y.map(({ limits, log }) => scaleOf(limits, log, box.bottom, box.top)), width, height: box.bottom + 24 + ROW * bottom.length,
    image, bar, sides, bottom, headed, step: Math.min(4, Math.min(...gaps, 99) / (1 + chart.offsets.filter(Boolean).length)),
  };
}

/** Give an element the shape of a chart. */
export const sizeChart = (svg, { width, height }) => svg.setAttribute("viewBox", `0 0 ${width} ${Math.ceil(height)}`);

/** Draw a chart into an element and return its places. */
export function drawChart(svg, chart, view, width) {
  const places = layoutOf(chart, view, width), { box } = places, whole = rectOf(box.left, box.top - 1, box.right, box.bottom + 1);
  sizeChart(svg, places);
  const plot = drawn("svg", { class: "parts", ...whole, viewBox: Object.values(whole).join(" ") }); // clips what is outside
  if (chart.ground) plot.append(drawn("rect", { ...whole, fill: chart.ground }));
  else if (places.image) plot.append(drawn("rect", { ...whole, class: "missing" }));
  const groups = chart.curves.map((_, number) => drawn("g", { "data-curve": number }));
  for (const part of chart.parts) {
    if (view.hidden.has(chart.curves[part.of]?.name)) continue;
    const shape = shapeOf(part, chart, places), behind = ["span", "image", "band"].includes(part.kind) || part.width < HAIR;
    shape.style.setProperty("--c", chart.paints[part.of] ?? "");
    ((!behind && groups[part.of]) || plot).append(shape);
  }
  plot.append(...groups);
  const middle = { x: (box.left + box.right) / 2, y: (box.top + box.bottom) / 2, class: "silent" };
  const texts = chart.texts?.map((text) => drawn("text", middle, text));
  svg.replaceChildren(drawAxes(view, places), plot, ...(texts ?? []), ...drawNames(chart, places), drawn("path", { class: "playhead" }), drawn("g", { class: "over" }));
  return places;
}

/** Draw the names of places along x that have room, upright ones beside their lines; those that come last give way. */
function drawNames({ named }, { box, x }) {
  const taken = [], inOrder = [...(named ?? [])].sort((one, other) => one.last - other.last || one.at - other.at);
  return inOrder.flatMap(({ at, text, high, up, begins }) => {
    const pixel = x.pixel(at), top = box.bottom - high * (box.bottom - box.top), half = (LETTER * text.length) / 2 + 3;
    const [from, to] = up ? [pixel - ROW + 4, pixel] : begins ? [pixel, pixel + 2 * half + 4] : [pixel - half, pixel + half];
    if (from < box.left || to > box.right + 1 || taken.some((other) => other.high === high && from < other.to && to > other.from)) return [];
    taken.push({ high, from, to });
    if (up) return drawn("text", { transform: `translate(${pixel - 3} ${top}) rotate(-90)`, class: "name end" }, text);
    return drawn("text", { x: begins ? pixel + 4 : pixel, y: high > 0.5 ? top + 12 : top - 4, class: begins ? "name" : "name middle" }, text);
  });
}

const rectOf = (x0, y0, x1, y1) => ({ x: Math.min(x0, x1), y: Math.min(y0, y1), width: Math.abs(x1 - x0), height: Math.abs(y1 - y0) });

/** Draw grid, ticks, labels and colour bar. */
function drawAxes(view, { box, x, y, sides, bar, image, width, headed, bottom }) {
  const axes = drawn("g", { class: "axes" }), scales = [y[0], bar ? scaleOf(bar.limits, bar.log, box.bottom, box.top) : y[1]];
  const grid = (d) => axes.append(drawn("path", { d, class: "grid" })), middle = (box.left + box.right) / 2, end = box.right + (bar ? 30 : 6);
  const write = (left, top, kind, text) => axes.append(drawn("text", { x: left, y: top, class: kind }, text));
  const room = Math.max(2, Math.floor((box.right - box.left) / (view.x.names.some(([, text]) => text.length > 5) ? 80 : 46)));
  for (const [value, text] of ticksOf(view.x, room)) {
    const at = x.pixel(value).toFixed(1);
    grid(`M${at} ${box.top}V${box.bottom}`);
    write(at, box.bottom + ROW, "middle", text);
  }
  sides.forEach((ticks, side) => ticks.forEach(([value, text]) => {
    const at = scales[side].pixel(value);
    if (!side) grid(`M${box.left} ${at.toFixed(1)}H${box.right}`);
    write(side ? end : box.left - 6, at + 4, side ? "" : "end", text);
  }));
  axes.append(drawn("path", { d: `M${box.left} ${box.bottom}H${box.right}`, class: "frame" }));
  const last = bar ? Math.min(width, box.right + 90) - 2 : width - 2;
  for (const { text, row, side } of headed) write(side ? last : 2, (row + 1) * ROW - 2, side ? "label end" : "label", text);
  bottom.forEach((text, k) => write(middle, box.bottom + (k + 2) * ROW + 3, "label middle", text));
  if (bar) drawColourBar(axes, box, image);
  return axes;
}

/** Draw the colours of an image beside it, that of values beyond the last one as a cap. */
function drawColourBar(axes, box, { colours, over }) {
  const scaled = over ? colours.slice(0, -1) : colours, step = (box.bottom - box.top) / scaled.length, x = box.right + 12, width = 12;
  axes.append(...scaled.map((fill, k) => drawn("rect", { x, y: box.bottom - (k + 1) * step, width, height: step + 0.6, fill })));
  if (over) axes.append(drawn("rect", { x, y: box.top - 9, width, height: 8, fill: colours.at(-1) }));
}

/** Join places to a path that breaks where a number is missing. */
function pathOf(points) {
  let text = "", pen = "M";
  for (const [x, y] of points) {
    const known = Number.isFinite(x) && Number.isFinite(y);
    if (known) text += `${pen}${x.toFixed(1)} ${Math.max(-9999, Math.min(9999, y)).toFixed(1)}`;
    pen = known ? "L" : "M";
  }
  return text;
}

/** Draw a part of a curve at the places of the axes. */
function shapeOf(part, chart, { box, x, y, step }) {
  const { kind, of, alpha: opacity } = part, at = chart.xs[part.x] ?? [], rise = y[part.right ? 1 : 0];
  const px = (value) => (value === null ? NaN : x.pixel(value)), py = (value) => (value === null ? NaN : rise.pixel(value));
  const dashes = of === undefined ? null : dashesOf(chart.curves, of), shift = step * (chart.offsets[of] ?? 0);
  const stroke = (points, style = {}) => drawn("path", { d: pathOf(points), class: "line", "stroke-dasharray": dashes, ...style });
  if (part.ends) {
    const [low, high] = kind === "span" ? [box.top, box.bottom] : part.ends.slice(2).map(py);
    const rect = rectOf(px(part.ends[0]), low, px(part.ends[1]), high);
    if (kind === "image") return drawn("image", { ...rect, href: part.png, preserveAspectRatio: "none" });
    const look = part.hollow ? "hollow" : of === undefined ? "missing" : "bar";
    return drawn("rect", { ...rect, class: look, opacity: kind === "bar" ? opacity : null });
  }
  if (kind === "rule") {
    const from = box.bottom - (part.high ?? 1) * (box.bottom - box.top);
    const points = part.along ? [[px(part.at), from], [px(part.at), box.bottom]] : [[box.left, py(part.at)], [box.right, py(part.at)]];
    return stroke(points, of === undefined ? { class: "rule" } : {});
  }
  if (kind === "band") {
    const edge = (values) => at.flatMap((place, k) => [[px(place), py(values[k])], ...(part.step ? [[px(at[k + 1] ?? place), py(values[k])]] : [])]);
    return drawn("path", { d: `${pathOf([...edge(part.low), ...edge(part.high).reverse()])}Z`, class: opacity ? "band" : "band full" });
  }
  if (kind === "errors") {
    const bars = at.map((place, k) => [px(place) + shift, py(part.low[k]), py(part.high[k])]).filter((bar) => bar.every(Number.isFinite));
    return drawn("path", { d: bars.map(([middle, low, high]) => `M${middle} ${low}V${high}m-3 0h6M${middle - 3} ${low}h6`).join(""), class: "errors" });
  }
  if (kind === "steps") {
    const points = part.y.flatMap((value, k) => [[px(at[k]), py(value)], [px(at[k + 1]), py(value)]]);
    return stroke(part.base === undefined ? points : [[px(at[0]), py(part.base)], ...points, [px(at.at(-1)), py(part.base)]]);
  }
  const group = drawn("g", { class: part.pale ? "pale" : null }), points = at.map((place, k) => [px(place), py(part.y[k])]), { width } = part;
  const thin = width < HAIR ? { class: "line hair" } : { class: "line thin" };
  if (width !== undefined) group.append(stroke(points, { opacity, ...(width < 0.8 ? { ...thin, "stroke-dasharray": null } : {}) }));
  if (part.size === undefined && (points.length > 1 || width === undefined)) return group;
  for (const [left, top] of points.filter((point) => point.every(Number.isFinite))) {
    const place = `translate(${(left + (width === undefined ? shift : 0)).toFixed(1)} ${top.toFixed(1)})`;
    group.append(drawn("path", { d: markOf(part, chart), transform: place, class: part.open ? "mark open" : "mark" }));
  }
  return group;
}
