// ---- charts: reading and zoom by pointer and keyboard, time ----

import { nearest, quantity, zoomed } from "./chart_scale.js";
import { drawChart, drawn, make } from "./chart_draw.js";

const READ_WITHIN = 30; // pixels along x within which a curve is read
const MAX_READ = 8; // curves in a reading
const DRAGGED = 6; // pixels after which a press is no click
const STEP = 3; // pixels between places that the arrow keys read

// ---- reading ----

/** Read all curves at a pixel, or the image; the curve that is nearest to it comes to the front. */
export function readAt(plot, pixel) {
  const { svg, output, places, chart } = plot, { box, image } = places, over = svg.querySelector(".over");
  const inside = pixel && pixel.x >= box.left - 4 && pixel.x <= box.right + 4;
  const read = !inside ? [] : image ? imageAt(plot, pixel) : curvesAt(plot, pixel), [first] = read;
  plot.reading = inside ? pixel : null;
  for (const group of svg.querySelectorAll("[data-curve]")) group.classList.toggle("top", Number(group.dataset.curve) === first?.curve);
  svg.querySelector(".parts").append(...svg.querySelectorAll(".top")); // no other curve hides the curve that is read
  over.replaceChildren();
  output.hidden = !first;
  if (!first) return;
  over.append(drawn("path", { d: `M${first.x} ${box.top}V${box.bottom}`, class: "hair-line" }));
  output.replaceChildren(make("strong", {}, first.place), ...read.slice(0, MAX_READ).sort((a, b) => a.curve - b.curve).map((entry) => {
    const { curve, x, y, name, text } = entry, line = make("div", { class: entry === first ? "first" : null });
    const style = `--c: ${chart.paints[curve]}`;
    if (!image) over.append(drawn("circle", { cx: x + places.step * chart.offsets[curve], cy: y, r: 4, class: "dot", style }));
    if (!image) line.append(make("i", { style }), make("span", {}, name));
    line.append(make("b", {}, text));
    return line;
  }));
  output.classList.toggle("left", first.x > (box.left + box.right) / 2);
}

/** Read the curves that have a point near a pixel along x, in the order of their distances along y. */
function curvesAt({ chart, points, places: { box, x, y }, view }, pixel) {
  const away = (entry) => Math.abs(entry.x - pixel.x);
  const read = chart.curves.flatMap(({ name }, curve) => {
    const among = view.hidden.has(name) ? [] : points[curve].filter((point) => x.pixel(point.x) >= box.left - 1 && x.pixel(point.x) <= box.right + 1);
    const point = nearest(among, x.pixel, pixel.x), side = point?.right ? 1 : 0;
    if (!point) return [];
    const height = y[side].pixel(point.y ?? (point.low + point.high) / 2);
    return [{ curve, x: x.pixel(point.x), y: height, place: placeText(chart.x, point), name: nameOf(chart, curve), text: valueText(chart.y[side].unit, point) }];
  });
  const least = Math.min(...read.map(away));
  const near = read.filter((entry) => away(entry) <= Math.max(least + 1, 2) && least < READ_WITHIN);
  return near.sort((a, b) => Math.abs(a.y - pixel.y) - Math.abs(b.y - pixel.y));
}

/** Read the value of an image from its colour. */
function imageAt(plot, pixel) {
  const { chart, places: { image, bar, x, y: [rise] } } = plot, [left, right, low, high] = image.ends, [along, up] = [x.value(pixel.x), rise.value(pixel.y)];
  const sheet = (plot.sheet ??= Object.assign(new Image(), { src: image.png })), pen = new OffscreenCanvas(1, 1).getContext("2d");
  const column = Math.floor(((along - left) / (right - left)) * sheet.naturalWidth), row = Math.floor(((high - up) / (high - low)) * sheet.naturalHeight);
  if (sheet.complete) pen.drawImage(sheet, -column, -row);
  else sheet.onload = () => readAt(plot, plot.reading);
  const parts = [...pen.getImageData(0, 0, 1, 1).data], colour = parts.slice(0, 3).map((part) => part.toString(16).padStart(2, "0")).join("");
  const shade = image.colours.indexOf(`#${colour}`), count = image.colours.length, [first, last] = bar.limits;
  if (shade < 0 || !parts[3]) return [];
  const value = quantity(Math.min(last, first + ((shade + 0.5) / (image.over ? count - 1 : count)) * (last - first)), bar.unit), { names, unit } = chart.y[0];
  const place = `${quantity(along, chart.x.unit)}, ${quantity(names.length && unit === "Hz" ? 10 ** up : up, unit)}`;
  return [{ x: pixel.x, place, text: `${{ 0: "≤ ", [count - 1]: "≥ " }[shade] ?? ""}${value}` }];
}

/** Return the place of a point along x by its tick or band, or as a number with its unit. */
function placeText({ names, unit }, point) {
  const near = names.find(([value]) => [point.from, point.x].some((place) => Math.abs(value - place) <= 2e-3 * Math.abs(value)));
  return near ? `${near[1]} ${unit}`.replace(/^([\d.]+)k Hz$/, "$1 kHz").trim() : quantity(point.x, unit);
}

function valueText(unit, { y, low, high, spread }) {
  if (low !== undefined) return `${quantity(low, unit)} to ${quantity(high, unit)}`;
  return spread === undefined ? quantity(y, unit) : quantity(y, unit).replace(/^\S+/, `$& ± ${quantity(spread, unit).split(" ")[0]}`);
}

/** Return the name of a curve, with the first name of its colour if others share it. */
function nameOf({ curves, y }, number) {
  const { name, colour } = curves[number], first = curves.find((curve) => curve.colour === colour);
  return curves.filter((curve) => curve.name === name).length > 1 ? `${first.name}, ${name}` : name || y[0].label;
}

// ---- drawing at the present width ----

export const widthOf = ({ figure }) => Math.round(figure.querySelector(".plot").clientWidth) || 640;

/** Draw a chart at its present width, with its reading and its playhead. */
export function redraw(plot) {
  const { view, chart } = plot;
  plot.places = drawChart(plot.svg, chart, view, widthOf(plot));
  plot.figure.querySelector(".whole").hidden = view.x.limits === view.x.whole;
  readAt(plot, plot.reading);
  setPlayhead(plot, plot.time);
}

// ---- zoom: a drag along x, or a key ----

export function resetZoom(plot) {
  plot.view.x.limits = plot.view.x.whole;
  redraw(plot);
}

function zoomTo(plot, from, to) {
  plot.view.x.limits = zoomed(plot.view.x, plot.places.x, from, to);
  redraw(plot);
}

/** Let a chart be read and zoomed by pointer, touch and keyboard; a click on one over time seeks. */
export function listenTo(plot) {
  const { svg, chart } = plot;
  let start = null; // pixel along x at which the pointer was pressed
  const on = (type, act) => svg.addEventListener(type, (event) => plot.places && act(event, pixelOf(plot, event)));
  on("pointerdown", ({ button, pointerId }, { x }) => {
    start = button === 0 ? x : null;
    svg.setPointerCapture(pointerId);
  });
  on("pointermove", (_, pixel) => {
    readAt(plot, pixel);
    if (start !== null && Math.abs(pixel.x - start) > DRAGGED) showDragged(plot, start, pixel.x);
  });
  on("pointerup", (_, { x, y }) => {
    const dragged = Math.abs(x - start) > DRAGGED, ends = [start, x].sort((a, b) => a - b), wasPressed = start !== null;
    start = null;
    if (wasPressed && dragged) zoomTo(plot, ...ends);
    else if (wasPressed && chart.second) seekAt(plot, x);
    else if (wasPressed && chart.patches) {
      readAt(plot, { x, y });
      hearAt(plot, x);
    }
    else readAt(plot, { x, y });
  });
  on("pointercancel", () => { start = null; });
  on("pointerleave", ({ pointerType }) => pointerType !== "touch" && readAt(plot, null));
  on("blur", () => readAt(plot, null));
  on("dblclick", () => resetZoom(plot));
  on("keydown", (event) => {
    if (!event.ctrlKey && !event.altKey && !event.metaKey && byKey(plot, event.key)) event.preventDefault();
  });
}

/** Return the pixel of a chart at a pointer. */
function pixelOf({ svg, places: { width } }, { clientX, clientY }) {
  const rect = svg.getBoundingClientRect(), factor = width / rect.width;
  return { x: (clientX - rect.left) * factor, y: (clientY - rect.top) * factor };
}

function showDragged({ svg, output, places: { box } }, from, to) {
  output.hidden = true;
  svg.querySelector(".over").append(drawn("rect", { x: Math.min(from, to), y: box.top, width: Math.abs(to - from), height: box.bottom - box.top, class: "dragged" }));
}

/** Act on a key and tell whether it acts: arrows read, + and - zoom, Escape shows the whole, Space and Enter play a patch. */
function byKey(plot, key) {
  const { places: { box, x }, points, view, chart, reading } = plot, { x: at, y } = reading ?? { x: (box.left + box.right) / 2, y: box.top };
  const factor = { "+": 0.5, "=": 0.5, "-": 2 }[key];
  if (key === "Escape") {
    plot.reading = null;
    resetZoom(plot);
  } else if (factor) zoomTo(plot, at - factor * (at - box.left), at + factor * (box.right - at));
  else if (["ArrowLeft", "ArrowRight", "Home", "End"].includes(key)) {
    const shown = points.filter((_, k) => !view.hidden.has(chart.curves[k].name)).flat().map((point) => x.pixel(point.x));
    const pixels = shown.filter((pixel) => pixel >= box.left - 1 && pixel <= box.right + 1).sort((a, b) => a - b), [first] = pixels, last = pixels.at(-1);
    const after = reading ? pixels.find((pixel) => pixel > at + STEP) ?? last : first, before = pixels.findLast((pixel) => pixel < at - STEP) ?? first;
    const next = { ArrowLeft: before, ArrowRight: after, Home: first, End: last }[key];
    if (next !== undefined) readAt(plot, { x: next, y });
  } else if (chart.patches && [" ", "Enter"].includes(key)) hearAt(plot, at);
  else return false;
  return true;
}

// ---- charts over time ----

function seekAt({ chart: { run, second }, figure, places }, pixel) {
  figure.dispatchEvent(new CustomEvent("chart-seek", { bubbles: true, detail: { run, time: places.x.value(pixel) * second } }));
}

// ---- charts over places ----

/** Ask for the sound of the patch at a pixel. */
function hearAt({ chart: { run, patches, x }, figure, places }, pixel) {
  const along = places.x.value(pixel), patch = patches.find(({ from, to }) => along >= from && along < to);
  if (patch) figure.dispatchEvent(new CustomEvent("chart-place", { bubbles: true, detail: { run, patch, place: quantity((patch.from + patch.to) / 2, x.unit) } }));
}

/** Move the playhead of a chart over time to a time in seconds. */
export function setPlayhead(plot, time) {
  plot.time = time;
  if (!plot.places || time === undefined) return;
  const { box, x } = plot.places, at = x.pixel(time / plot.chart.second), inside = at >= box.left - 1 && at <= box.right + 1;
  plot.svg.querySelector(".playhead").setAttribute("d", inside ? `M${at.toFixed(1)} ${box.top}V${box.bottom}` : "");
}
