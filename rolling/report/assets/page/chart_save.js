// ---- charts as files: SVG, PNG and CSV ----

import { LETTER, MAX_NAMES, drawChart, drawn, keyOf, namesOf, rowsOf } from "./chart_draw.js";

const WIDTH = 900; // of a saved chart [pixels]
const STYLES = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "opacity", "font-family", "font-size", "font-weight", "text-anchor"];

export function download(content, type, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export function saveChart(plot, kind) {
  const name = `${plot.figure.dataset.file}.${kind}`;
  if (kind === "csv") return download(csvOf(plot), "text/csv", name);
  const text = savedChart(plot);
  return kind === "svg" ? download(text, "image/svg+xml", name) : savePixels(text, name);
}

/** Return the table of a chart, or its drawn curves, as CSV; names are in quotes. */
export function csvOf({ chart, points }) {
  if (chart.csv) return chart.csv;
  const quoted = (text) => `"${text.replaceAll('"', '""')}"`;
  const rows = chart.curves.flatMap(({ name }, k) => points[k].map((point) => [quoted(name), point.x, point.low ?? point.y, point.high ?? point.y, point.spread ?? ""].join()));
  return ["curve", quoted(`${chart.x.label} [${chart.x.unit}]`), "minimum", "maximum", "standard uncertainty"].join().concat("\n", rows.join("\n"), "\n");
}

/** Return the zoomed chart with title and legend as SVG in the colours of paper. */
function savedChart({ figure, chart, view }) {
  const svg = drawn("svg", { xmlns: "http://www.w3.org/2000/svg", class: "saved" }), texts = [];
  figure.querySelector(".plot").append(svg);
  const { height } = drawChart(svg, chart, view, WIDTH), inner = drawn("g", {}, ...svg.childNodes);
  let bottom = 0;
  for (const text of rowsOf(chart.title, 110)) texts.push(drawn("text", { x: 6, y: (bottom += 20), class: "title" }, text));
  for (const text of rowsOf(chart.note, 140)) texts.push(drawn("text", { x: 6, y: (bottom += 15) }, text));
  inner.setAttribute("transform", `translate(0 ${(bottom += 8)})`);
  bottom += height;
  const names = namesOf(chart).filter((name) => !view.hidden.has(name)).slice(0, MAX_NAMES);
  const across = Math.max(1, Math.floor(WIDTH / (60 + LETTER * Math.max(1, ...names.map((name) => name.length)))));
  names.forEach((name, k) => {
    const place = `translate(${6 + (k % across) * (WIDTH / across)} ${bottom + 18 * Math.floor(k / across)})`;
    texts.push(drawn("g", { transform: place }, drawn("g", { transform: "translate(0 6)" }, keyOf(chart, name)), drawn("text", { x: 38, y: 16 }, name)));
  });
  const whole = Math.ceil(bottom + 18 * Math.ceil(names.length / across) + 10);
  svg.replaceChildren(drawn("rect", { width: WIDTH, height: whole, class: "paper" }), inner, ...texts);
  for (const [key, value] of [["viewBox", `0 0 ${WIDTH} ${whole}`], ["width", WIDTH], ["height", whole]]) svg.setAttribute(key, value);
  const elements = [...svg.querySelectorAll("*")];
  const styles = elements.map((element) => STYLES.map((key) => [key, getComputedStyle(element).getPropertyValue(key)]));
  elements.forEach((element, k) => {
    element.removeAttribute("style");
    for (const [key, value] of styles[k]) element.setAttribute(key, value);
  });
  svg.remove();
  return new XMLSerializer().serializeToString(svg);
}

async function savePixels(text, name) {
  const image = Object.assign(new Image(), { src: `data:image/svg+xml,${encodeURIComponent(text)}` });
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), { width: 2 * image.naturalWidth, height: 2 * image.naturalHeight });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((content) => download(content, "image/png", name), "image/png");
}
