// ---- charts: opening, reading by pointer and keyboard, zoom, curves on and off ----

import { pointsOf, positive, quantity } from "./chart_scale.js";
import { dashesOf, drawChart, drawn, isGrey, layoutOf, make, markOf, sizeChart } from "./chart_draw.js";
import { saveChart } from "./chart_save.js";
import { listenTo, resetZoom, showReading } from "./chart_touch.js";

const MOST_ROWS = 500; // of a table of values
const PALETTE = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];

/** A colour for light ground, and as much lighter as it is dark for dark ground. */
export const shadesOf = (colour) => `light-dark(${colour}, oklch(from ${colour} calc(1 - 0.45 * l) c h))`;

/** Give every run of the page its colour, the one of its curve where runs are compared. */
export function colourRuns(charts, labels) {
  const compared = charts.find((chart) => chart.run === undefined && labels.every((label) => chart.curves.some((curve) => curve.name === label)));
  const colours = labels.map((label, k) => compared?.curves.find((curve) => curve.name === label).colour ?? PALETTE[k % PALETTE.length]);
  colours.forEach((colour, k) => document.documentElement.style.setProperty(`--run-${k}`, shadesOf(colour)));
  for (const chart of charts) chart.paints = paintsOf(chart, labels, colours);
}

/** Colours of the curves of a chart: those of runs, and in a chart of one run the first is its colour. */
function paintsOf({ curves, run }, labels, colours) {
  const spare = PALETTE.filter((colour) => !colours.includes(colour) && !curves.some((curve) => curve.colour === colour));
  const compared = run === undefined && curves.some((curve) => labels.includes(curve.name));
  return curves.map(({ colour }) => {
    const same = colours.indexOf(colour);
    if (isGrey(colour)) return "var(--chart-shade)";
    if (compared && same >= 0) return `var(--run-${same})`;
    if (run !== undefined && colour === curves[0].colour) return `var(--run-${run})`;
    return shadesOf(run !== undefined && same >= 0 ? spare.shift() ?? colour : colour);
  });
}

/** Open all charts of the page in their figures; runs have their labels. */
export function openCharts(charts, labels) {
  charts.forEach((chart, number) => { chart.number = number; });
  colourRuns(charts, labels);
  for (const figure of document.querySelectorAll("figure[data-chart]")) openChart(figure, charts[Number(figure.dataset.chart)]);
}

/** Make a chart in its figure; it is drawn when it comes near the screen. */
export function openChart(figure, chart) {
  const copyOf = (axis) => ({ ...axis, limits: [...axis.limits] });
  const plot = { figure, chart, points: pointsOf(chart), places: null, reading: null };
  plot.full = { x: copyOf(chart.x), y: chart.y.map(copyOf), hidden: new Set() };
  plot.view = { ...plot.full, x: copyOf(chart.x), y: chart.y.map(copyOf) };
  chart.offsets = offsetsOf(chart);
  chart.hatched = [...new Set(chart.parts.filter((part) => part.hatch).map((part) => part.of))];
  plot.svg = drawn("svg", { role: "img", tabindex: 0, "aria-label": `${chart.title}: ${chart.note}. Arrow keys read values, + and - zoom.` });
  plot.output = make("output", { class: "reading", hidden: "" });
  figure.querySelector(".plot").replaceChildren(plot.svg, plot.output);
  figure.plot = plot;
  plot.legend = makeLegend(plot);
  makeTools(plot);
  listenTo(plot);
  sizeChart(plot.svg, layoutOf(chart, plot.view, widthOf(plot))); // so that nothing moves when it is drawn
  comingNear.observe(figure);
  return plot;
}

/** Offsets along x of the marks of curves with error bars, so that none hides another. */
function offsetsOf({ parts, curves }) {
  const barred = [...new Set(parts.filter((part) => part.kind === "errors").map((part) => part.of))];
  const wide = barred.length > 1 && parts.some((part) => part.kind === "steps" || part.kind === "bar");
  return curves.map((_, k) => (wide && barred.includes(k) ? barred.indexOf(k) - (barred.length - 1) / 2 : 0));
}

const resized = new ResizeObserver((entries) => entries.forEach(({ target }) => target.plot && redraw(target.plot)));
const comingNear = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    if (!isIntersecting) continue;
    comingNear.unobserve(target);
    redraw(target.plot);
    resized.observe(target);
  }
}, { rootMargin: "600px" });
addEventListener("beforeprint", () => document.querySelectorAll("figure.chart").forEach((figure) => figure.plot?.places ?? (figure.plot && redraw(figure.plot))));

const widthOf = ({ figure }) => Math.round(figure.querySelector(".plot").clientWidth) || 640;

/** Draw a chart at the present width. */
export function redraw(plot) {
  plot.places = drawChart(plot.svg, plot.chart, plot.view, widthOf(plot));
  plot.reset.hidden = !isZoomed(plot);
  showReading(plot);
  plot.moveTo?.();
}

export const isZoomed = ({ view, full }) => String([view.x.limits, ...view.y.map((y) => y.limits)]) !== String([full.x.limits, ...full.y.map((y) => y.limits)]);

// ---- curves on and off, scales ----

/** Make a button for each name of curves, which shows and hides them. */
function makeLegend(plot) {
  const { chart, view, figure } = plot, names = [...new Set(chart.curves.map((curve) => curve.name))].filter(Boolean);
  if (names.length > 24) return;
  figure.querySelector(".legend").replaceChildren(...names.map((name) => {
    const number = chart.curves.findIndex((curve) => curve.name === name), button = make("button", { type: "button", "aria-pressed": "true" });
    const key = drawn("svg", { width: 30, height: 12, "aria-hidden": "true" }), filled = chart.parts.find((part) => part.of === number && ["span", "bar", "band"].includes(part.kind));
    const marked = chart.parts.find((part) => part.of === number && part.size), lined = chart.parts.some((part) => part.of === number && (part.width || ["rule", "steps"].includes(part.kind)));
    key.append(filled ? drawn("rect", { x: 3, y: 1, width: 24, height: 10, class: "key", opacity: filled.alpha }) : drawn("path", { d: lined ? "M1 6H29" : "", class: "line", "stroke-dasharray": dashesOf(chart.curves, number) }));
    if (marked) key.append(drawn("path", { d: markOf(marked, chart), transform: "translate(15 6)", class: lined ? "mark" : "mark open" }));
    key.style.setProperty("--c", chart.paints[number]);
    button.append(key, name);
    button.addEventListener("click", () => {
      if (!view.hidden.delete(name)) view.hidden.add(name);
      button.setAttribute("aria-pressed", String(!view.hidden.has(name)));
      redraw(plot);
    });
    return button;
  }));
}

/** Make the buttons for scales and for the whole chart, and the table of values on demand. */
function makeTools(plot) {
  const { chart, view, full, figure } = plot, tools = figure.querySelector(".scales");
  const image = chart.parts.some((part) => part.kind === "image");
  plot.reset = make("button", { type: "button", hidden: "" }, "Whole chart");
  plot.reset.addEventListener("click", () => resetZoom(plot));
  const buttons = [["x", [view.x, full.x], true], ["y", [view.y[0], full.y[0]], false]].flatMap(([name, axes, along]) => {
    const { log, unit, names } = axes[0], [least, most] = positive(chart, along);
    if (image || !(log || /^(Hz|.?[WJ])$/.test(unit)) || !(most > least)) return [];
    const button = make("button", { type: "button", "aria-pressed": String(log) }, `log ${name}`), before = [...axes[1].limits];
    button.addEventListener("click", () => {
      const turned = !axes[0].log, lowest = before[0] > 0 ? before[0] : least;
      for (const axis of axes) Object.assign(axis, { log: turned, limits: turned ? [lowest, before[1]] : [...before], names: turned ? names : [] });
      button.setAttribute("aria-pressed", String(turned));
      redraw(plot);
    });
    return [button];
  });
  tools.replaceChildren(...buttons, plot.reset);
  for (const saving of figure.querySelectorAll("[data-save]")) saving.onclick = () => saveChart(plot, saving.dataset.save);
  figure.querySelector("[data-save=csv]").hidden = !chart.csv && !plot.points.some((points) => points.length);
  const values = figure.querySelector("details.values");
  values.ontoggle = () => values.open && values.querySelector(".scroll").replaceChildren(tableOf(plot));
  values.ontoggle();
  values.hidden = !plot.points.some((points) => points.length);
}

/** The place of a point along x: the name of its tick or band, or a number with its unit. */
export const placeText = ({ chart: { x } }, point) => {
  const near = x.names.find(([value]) => [point.from, point.x].some((place) => Math.abs(value - place) <= 2e-3 * Math.abs(value)));
  return near ? `${near[1]} ${x.unit}`.replace(/^([\d.]+)k Hz$/, "$1 kHz").trim() : quantity(point.x, x.unit);
};

export const valueText = ({ chart }, point) => {
  const { unit } = chart.y[point.right ? 1 : 0];
  if (point.low !== undefined) return `${quantity(point.low, unit)} to ${quantity(point.high, unit)}`;
  const value = quantity(point.y, unit);
  return point.spread === undefined ? value : value.replace(/^\S+/, `$& ± ${quantity(point.spread, unit).split(" ")[0]}`);
};

/** Name of a curve, with the one of its colour if others have its name. */
export const nameOf = ({ curves, y }, number) => {
  const { name, colour } = curves[number], first = curves.find((curve) => curve.colour === colour);
  return curves.filter((curve) => curve.name === name).length > 1 ? `${first.name}, ${name}` : name || y[0].label;
};

/** A table of the values that are drawn, a row for each place along x. */
function tableOf(plot) {
  const { chart, points } = plot, columns = chart.curves.map((_, k) => k).filter((k) => points[k].length), rows = new Map();
  for (const k of columns) for (const point of points[k]) {
    if (!rows.has(point.x)) rows.set(point.x, { head: placeText(plot, point), cells: new Map() });
    rows.get(point.x).cells.set(k, valueText(plot, point));
  }
  const ordered = [...rows].sort(([a], [b]) => a - b).slice(0, MOST_ROWS), cell = (text) => make("td", {}, text);
  const head = (text, scope) => make("th", { scope }, text);
  const heads = make("tr", {}, head(chart.x.label, "col"), ...columns.map((k) => head(nameOf(chart, k), "col")));
  const body = ordered.map(([, row]) => make("tr", {}, head(row.head, "row"), ...columns.map((k) => cell(row.cells.get(k) ?? "-"))));
  const note = rows.size > MOST_ROWS ? [make("caption", {}, `The first ${MOST_ROWS} of ${rows.size} places; CSV has all.`)] : [];
  return make("table", {}, ...note, make("thead", {}, heads), make("tbody", {}, ...body));
}
