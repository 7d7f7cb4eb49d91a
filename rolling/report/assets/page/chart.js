// ---- charts: opening, colours, curves on and off, scales ----

import { pointsOf, positive } from "./chart_scale.js";
import { MAX_NAMES, drawn, isGrey, keyOf, layoutOf, make, namesOf, sizeChart } from "./chart_draw.js";
import { saveChart } from "./chart_save.js";
import { numbersButton } from "./chart_table.js";
import { listenTo, redraw, resetZoom, widthOf } from "./chart_touch.js";
import { foldAgain, unfold } from "./folds.js";

const PALETTE = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];

/** Return a colour for light ground, with a lighter one for dark ground. */
const shadesOf = (colour) => `light-dark(${colour}, oklch(from ${colour} calc(1 - 0.45 * l) c h))`;

/** Give each run its colour, if possible the colour of its curve among compared runs. */
function colourRuns(charts, labels) {
  const compared = charts.find((chart) => chart.run === undefined && labels.every((label) => chart.curves.some((curve) => curve.name === label)));
  const colours = labels.map((label, k) => compared?.curves.find((curve) => curve.name === label).colour ?? PALETTE[k % PALETTE.length]);
  colours.forEach((colour, k) => document.documentElement.style.setProperty(`--run-${k}`, shadesOf(colour)));
  for (const chart of charts) chart.paints = paintsOf(chart, labels, colours);
}

/** Return the colours of curves; in a chart of one run, its colour and the first are exchanged. */
function paintsOf({ curves, run, parts }, labels, colours) {
  if (parts.some((part) => part.kind === "image")) return curves.map(({ colour }) => colour); // as in the image
  const compared = run === undefined && curves.some((curve) => labels.includes(curve.name));
  const first = curves.find(({ colour }) => !isGrey(colour))?.colour;
  return curves.map(({ colour }, k) => {
    const number = compared ? colours.indexOf(colour) : colour === first ? run ?? -1 : -1;
    if (isGrey(colour)) return parts.some((part) => part.of === k && part.kind === "line") ? "var(--chart-pale)" : "var(--chart-shade)";
    return number >= 0 ? `var(--run-${number})` : shadesOf(colour === colours[run] ? first : colour);
  });
}

/** Open all charts of the page in their figures; runs have their labels. */
export function openCharts(charts, labels) {
  colourRuns(charts, labels);
  for (const figure of document.querySelectorAll("figure[data-chart]")) openChart(figure, charts[Number(figure.dataset.chart)]);
}

/** Make a chart in its figure; it is drawn when it comes near the screen. */
export function openChart(figure, chart) {
  const viewOf = (axis) => ({ ...axis, whole: axis.limits }); // `limits` belong to the zoom
  const plot = { figure, chart, points: pointsOf(chart), places: null, reading: null };
  takePixels(figure, chart);
  plot.view = { x: viewOf(chart.x), y: chart.y.map(viewOf), hidden: new Set() };
  chart.offsets = offsetsOf(chart);
  plot.svg = drawn("svg", { role: "img", tabindex: 0, "aria-label": `${chart.title}: ${chart.note}. Arrow keys read values, + and - zoom.${chart.patches ? " Enter plays a patch." : ""}` });
  plot.output = make("output", { class: "reading", hidden: "" });
  figure.querySelector(".plot").replaceChildren(plot.svg, plot.output);
  figure.plot = plot;
  makeLegend(plot);
  makeTools(plot);
  listenTo(plot);
  sizeChart(plot.svg, layoutOf(chart, plot.view, widthOf(plot))); // so that nothing moves when it is drawn
  comingNear.observe(figure);
}

/** Give the image of a chart its pixels, which stand in the drawing that scripts replace. */
function takePixels(figure, chart) {
  const image = chart.parts.find((part) => part.kind === "image");
  if (image) image.png ??= figure.querySelector(".plot image").getAttribute("href");
}

/** Return offsets along x of marks with error bars, so that none hides another. */
function offsetsOf({ parts, curves }) {
  const barred = [...new Set(parts.filter((part) => part.kind === "errors").map((part) => part.of))];
  const wide = barred.length > 1 && parts.some((part) => part.kind === "steps" || part.kind === "bar");
  return curves.map((_, k) => (wide && barred.includes(k) ? barred.indexOf(k) - (barred.length - 1) / 2 : 0));
}

// ---- drawing at the present width ----

const resized = new ResizeObserver((entries) => entries.forEach(({ target }) => redraw(target.plot)));
const comingNear = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    if (!isIntersecting) continue;
    comingNear.unobserve(target);
    redraw(target.plot);
    resized.observe(target);
  }
}, { rootMargin: "600px" });
addEventListener("beforeprint", () => {
  unfold(); // so that charts have a width
  document.querySelectorAll("figure.chart").forEach(({ plot }) => plot && redraw(plot));
});
addEventListener("afterprint", foldAgain);

// ---- curves on and off, scales ----

/** Make a button for each name of curves, which shows and hides them. */
function makeLegend(plot) {
  const { chart, view, figure } = plot, names = namesOf(chart);
  if (names.length > MAX_NAMES) return;
  figure.querySelector(".legend").replaceChildren(...names.map((name) => {
    const button = make("button", { type: "button", "aria-pressed": "true" });
    button.append(drawn("svg", { width: 30, height: 12, "aria-hidden": "true" }, keyOf(chart, name)), name);
    button.addEventListener("click", () => {
      if (!view.hidden.delete(name)) view.hidden.add(name);
      button.setAttribute("aria-pressed", String(!view.hidden.has(name)));
      redraw(plot);
    });
    return button;
  }));
}

/** Connect the buttons that reset and save a chart, and make the buttons of its scales. */
function makeTools(plot) {
  const { chart, view, figure, points } = plot, image = chart.parts.some((part) => part.kind === "image");
  figure.querySelector(".whole").onclick = () => resetZoom(plot);
  for (const button of figure.querySelectorAll("[data-save]")) button.onclick = () => saveChart(plot, button.dataset.save);
  const hasNumbers = Boolean(chart.csv || points.flat().length);
  figure.querySelector("[data-save=csv]").hidden = !hasNumbers;
  if (hasNumbers) figure.querySelector(".tools").append(numbersButton(plot));
  const able = ["x", "y"].filter((name) => {
    const { log, unit } = [view[name]].flat()[0], [least, most] = positive(points, name);
    return !image && (log || /^(Hz|.?[WJ])$/.test(unit)) && most > least;
  });
  figure.querySelector(".scales").replaceChildren(...able.map((name) => {
    const axis = [view[name]].flat()[0], { limits: [low, high], names } = [chart[name]].flat()[0];
    const button = make("button", { type: "button", "aria-pressed": String(axis.log) }, `log ${name}`);
    button.addEventListener("click", () => {
      axis.log = !axis.log;
      axis.names = axis.log ? names : [];
      axis.limits = axis.whole = [axis.log && low <= 0 ? positive(points, name)[0] : low, high];
      button.setAttribute("aria-pressed", String(axis.log));
      redraw(plot);
    });
    return button;
  }));
}
