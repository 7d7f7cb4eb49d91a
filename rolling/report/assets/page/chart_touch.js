// ---- charts: reading by pointer and keyboard, zoom, time ----

import { nearest, quantity, zoomed } from "./chart_scale.js";
import { drawn, make } from "./chart_draw.js";
import { nameOf, placeText, redraw, valueText } from "./chart.js";

const READ_WITHIN = 30; // pixels along x within which a curve is read
const MOST_READ = 8; // curves in a reading
const DRAGGED = 6; // pixels after which a press is no click

const pointerOf = (plot, event) => {
  const { left, top, width } = plot.svg.getBoundingClientRect(), factor = plot.places.width / width;
  return { x: (event.clientX - left) * factor, y: (event.clientY - top) * factor };
};

const middleOf = (point) => point.y ?? (point.low + point.high) / 2;

// ---- reading ----

/** Read all curves at a pixel along x; the one nearest to a pixel along y comes to the front. */
export function readAt(plot, pixel) {
  const { chart, points, places, view } = plot, { box } = places;
  if (!chart.curves.length || pixel.x < box.left - 4 || pixel.x > box.right + 4) return (plot.reading = places.image ? { pixel } : null);
  const inside = ({ x }) => places.x.pixel(x) >= box.left - 1 && places.x.pixel(x) <= box.right + 1;
  const read = chart.curves.flatMap(({ name }, curve) => {
    const { point, distance } = nearest(view.hidden.has(name) ? [] : points[curve].filter(inside), places.x.pixel, pixel.x);
    return point ? [{ curve, point, distance, y: places.y[point.right ? 1 : 0].pixel(middleOf(point)) }] : [];
  });
  const least = Math.min(...read.map((entry) => entry.distance)), near = read.filter((entry) => entry.distance <= Math.max(least + 1, 2) && least < READ_WITHIN);
  if (!near.length) return (plot.reading = null);
  near.sort((a, b) => Math.abs(a.y - pixel.y) - Math.abs(b.y - pixel.y));
  return (plot.reading = { near, pixel });
}

/** Show the values that are read beside a line at their place. */
export function showReading(plot) {
  const { svg, output, reading, places, chart } = plot, over = svg.querySelector(".over"), first = reading?.near?.[0].curve;
  for (const group of svg.querySelectorAll("[data-curve]")) group.classList.toggle("top", Number(group.dataset.curve) === first);
  svg.querySelector(".parts").append(...svg.querySelectorAll(".top")); // no other curve hides the one that is read
  over.replaceChildren(...(plot.playhead ? [plot.playhead] : []));
  output.hidden = !reading;
  if (!reading) return;
  if (!reading.near) return showPixel(plot);
  const { box } = places, [{ point }] = reading.near, x = places.x.pixel(point.x);
  over.append(drawn("path", { d: `M${x} ${box.top}V${box.bottom}`, class: "hair-line" }));
  const shown = reading.near.slice(0, MOST_READ).sort((a, b) => a.curve - b.curve);
  const lines = shown.map((entry) => {
    const dot = drawn("circle", { cx: places.x.pixel(entry.point.x) + places.step * chart.offsets[entry.curve], cy: entry.y, r: 4, class: "dot" }), swatch = make("i");
    for (const element of [dot, swatch]) element.style.setProperty("--c", chart.paints[entry.curve]);
    over.append(dot);
    return make("div", entry === reading.near[0] ? { class: "first" } : {}, swatch, make("span", {}, nameOf(chart, entry.curve)), make("b", {}, valueText(plot, entry.point)));
  });
  placeOutput(plot, x, [make("strong", {}, placeText(plot, point)), ...lines]);
}

function placeOutput({ output, places }, x, content) {
  output.replaceChildren(...content);
  if (places.width < 520) { // on a small screen the values stand over the legend, not over the curves
    output.style.cssText = `top: ${places.height}px; left: 0; right: 0`;
    return;
  }
  const right = x > (places.box.left + places.box.right) / 2;
  output.style.cssText = `top: ${places.box.top + 6}px; ${right ? "right" : "left"}: ${right ? places.width - x + 12 : x + 12}px; max-width: ${(right ? x : places.width - x) - 20}px`;
}

/** Read the value of an image from its colour. */
function showPixel(plot) {
  const { places, chart, reading: { pixel }, output } = plot, { image, bar } = places, [left, right, low, high] = image.ends;
  const sheet = (plot.sheet ??= pixelsOf(image.png, () => showReading(plot))), x = places.x.value(pixel.x), y = places.y[0].value(pixel.y);
  const column = Math.floor(((x - left) / (right - left)) * sheet.width), row = Math.floor(((high - y) / (high - low)) * sheet.height);
  output.hidden = !sheet.pixels || column < 0 || row < 0 || column >= sheet.width || row >= sheet.height || pixel.y > places.box.bottom || pixel.y < places.box.top;
  if (output.hidden) return;
  const shade = image.colours.indexOf(`#${[...sheet.pixels.slice(4 * (row * sheet.width + column)).slice(0, 3)].map((part) => part.toString(16).padStart(2, "0")).join("")}`);
  const [first, last] = bar.limits, value = first + ((shade + 0.5) / image.colours.length) * (last - first);
  const named = chart.y[0].names.length && chart.y[0].unit === "Hz" ? 10 ** y : y;
  const text = shade < 0 ? "-" : `${shade === 0 ? "≤ " : shade === image.colours.length - 1 ? "≥ " : ""}${quantity(value, bar.unit)}`;
  placeOutput(plot, pixel.x, [make("strong", {}, `${quantity(x, chart.x.unit)}, ${quantity(named, chart.y[0].unit)}`), make("div", { class: "first" }, make("b", {}, text))]);
}

/** The pixels of an image in a data URI, and word as soon as they are decoded. */
function pixelsOf(source, ready) {
  const sheet = {}, image = Object.assign(new Image(), { src: source });
  image.decode().then(() => {
    const { naturalWidth: width, naturalHeight: height } = image, canvas = new OffscreenCanvas(width, height), pen = canvas.getContext("2d");
    pen.drawImage(image, 0, 0);
    Object.assign(sheet, { width, height, pixels: pen.getImageData(0, 0, width, height).data });
    ready();
  });
  return sheet;
}

// ---- zoom ----

export function resetZoom(plot) {
  const { view, full } = plot;
  view.x.limits = [...full.x.limits];
  view.y.forEach((axis, side) => { axis.limits = [...full.y[side].limits]; });
  redraw(plot);
}

export function zoomAlong(plot, factor, pixel) {
  const { view, full, places } = plot;
  view.x.limits = zoomed(view.x.limits, full.x.limits, view.x.log, factor, places.x.value(pixel));
  redraw(plot);
}

/** Show the rectangle between two pixels; a low one keeps the whole height. */
function zoomInto(plot, from, to) {
  const { view, places, chart } = plot, { box } = places, clamp = (value, low, high) => Math.min(high, Math.max(low, value));
  const xs = [from.x, to.x].map((x) => clamp(x, box.left, box.right)).sort((a, b) => a - b), ys = [from.y, to.y].map((y) => clamp(y, box.top, box.bottom)).sort((a, b) => b - a);
  view.x.limits = xs.map(places.x.value);
  if (ys[0] - ys[1] > 30 || chart.aspect) view.y.forEach((axis, side) => { axis.limits = ys.map(places.y[side].value); });
  redraw(plot);
}

// ---- pointer and keys ----

/** Let a chart be read and zoomed by pointer, touch and keyboard. */
export function listenTo(plot) {
  const { svg } = plot, pressed = new Map();
  let start = null, apart = 0;
  const on = (type, act, options) => svg.addEventListener(type, (event) => plot.places && act(event), options);
  on("pointerdown", (event) => {
    pressed.set(event.pointerId, pointerOf(plot, event));
    start = pressed.size === 1 && event.button === 0 ? pointerOf(plot, event) : null;
    apart = 0;
  });
  on("pointermove", (event) => {
    const at = pointerOf(plot, event);
    if (pressed.has(event.pointerId)) pressed.set(event.pointerId, at);
    if (pressed.size === 2) return pinch();
    readAt(plot, at);
    showReading(plot);
    if (start && event.pointerType !== "touch" && Math.abs(at.x - start.x) > DRAGGED) showDragged(plot, start, at);
  });
  const release = (event) => {
    const at = pointerOf(plot, event), dragged = start && Math.abs(at.x - start.x) > DRAGGED;
    pressed.delete(event.pointerId);
    if (event.type === "pointerup" && dragged && event.pointerType !== "touch") zoomInto(plot, start, at);
    else if (event.type === "pointerup" && start && !dragged && plot.chart.second) seekAt(plot, at);
    start = null;
  };
  on("pointerup", release);
  on("pointercancel", release);
  on("pointerleave", (event) => { if (event.pointerType !== "touch") leave(plot); });
  on("blur", () => leave(plot));
  on("dblclick", () => resetZoom(plot));
  on("wheel", (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoomAlong(plot, 1.0015 ** event.deltaY, pointerOf(plot, event).x);
  }, { passive: false });
  on("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !byKey(plot, event.key)) return;
    event.preventDefault();
  });
  function pinch() {
    const [one, other] = [...pressed.values()], distance = Math.hypot(one.x - other.x, one.y - other.y);
    if (apart) zoomAlong(plot, apart / distance, (one.x + other.x) / 2);
    apart = distance;
  }
}

function leave(plot) {
  plot.reading = null;
  showReading(plot);
}

function showDragged({ svg, output, places: { box } }, from, to) {
  output.hidden = true;
  const y = Math.abs(to.y - from.y) > 30 ? [from.y, to.y] : [box.top, box.bottom];
  svg.querySelector(".over").append(drawn("rect", { x: Math.min(from.x, to.x), y: Math.min(...y), width: Math.abs(to.x - from.x), height: Math.abs(y[1] - y[0]), class: "dragged" }));
}

/** Act on a key: arrows read the next place or curve, + and - zoom, Escape resets. */
function byKey(plot, key) {
  const { places, view, chart, points, reading } = plot, { box } = places;
  const entry = reading?.near?.[0], x = entry ? places.x.pixel(entry.point.x) : (box.left + box.right) / 2;
  if (key === "Escape") {
    leave(plot);
    resetZoom(plot);
  } else if (key === "+" || key === "=" || key === "-") zoomAlong(plot, key === "-" ? 2 : 0.5, x);
  else if (["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End"].includes(key) && chart.curves.length) {
    const curves = chart.curves.map((_, k) => k).filter((k) => points[k].length && !view.hidden.has(chart.curves[k].name));
    const step = { ArrowUp: 1, ArrowDown: -1 }[key] ?? 0, curve = curves.at((curves.indexOf(entry?.curve ?? curves[0]) + step) % curves.length);
    const inside = (point) => places.x.pixel(point.x) >= box.left - 1 && places.x.pixel(point.x) <= box.right + 1;
    const row = (points[curve] ?? []).filter(inside).sort((a, b) => a.x - b.x), at = row.findIndex((point) => point.x >= (entry?.point.x ?? -Infinity));
    const next = row.at({ ArrowLeft: Math.max(0, at - 1), ArrowRight: entry ? Math.min(row.length - 1, at + 1) : 0, Home: 0, End: -1 }[key] ?? Math.max(0, at));
    if (!next) return true;
    readAt(plot, { x: places.x.pixel(next.x), y: places.y[next.right ? 1 : 0].pixel(middleOf(next)) });
    showReading(plot);
  } else return false;
  return true;
}

// ---- charts over time ----

function seekAt(plot, { x }) {
  const { run, second } = plot.chart;
  plot.figure.dispatchEvent(new CustomEvent("chart-seek", { bubbles: true, detail: { run, time: plot.places.x.value(x) * second } }));
}

/** Move the playhead of a chart over time to a time in seconds. */
export function setPlayhead(plot, time) {
  plot.moveTo = () => {
    const { box, x } = plot.places, at = x.pixel(time / plot.chart.second);
    plot.playhead ??= drawn("path", { class: "playhead" });
    plot.playhead.setAttribute("d", at >= box.left - 1 && at <= box.right + 1 ? `M${at.toFixed(1)} ${box.top}V${box.bottom}` : "");
    if (!plot.playhead.isConnected) plot.svg.querySelector(".over").prepend(plot.playhead);
  };
  if (plot.places) plot.moveTo();
}
