// ---- charts: their numbers as a table, one choice away ----

import { worded } from "./chart_scale.js";
import { make } from "./chart_draw.js";
import { csvOf } from "./chart_save.js";

const MAX_ROWS = 500; // of a table on the page; the CSV file has all rows

/** Return a button that shows the numbers of a chart below it, and hides them. */
export function numbersButton(plot) {
  const button = make("button", { type: "button", "aria-expanded": "false" }, "Numbers");
  let table = null;
  button.addEventListener("click", () => {
    const show = !table;
    table?.remove();
    table = show ? tableOf(csvOf(plot), plot.chart.title) : null;
    if (show) plot.figure.append(table);
    button.setAttribute("aria-expanded", String(show));
  });
  return button;
}

/** Return a table of the rows of a CSV text in a box that scrolls. */
function tableOf(csv, title) {
  const [heads, ...rows] = csv.trimEnd().split("\n").map(cellsOf);
  const head = make("tr", {}, ...heads.map((text) => make("th", { scope: "col" }, text.replaceAll("_", " "))));
  const body = rows.slice(0, MAX_ROWS).map((cells) => make("tr", {}, ...cells.map((text) => make("td", {}, shown(text)))));
  const table = make("table", {}, make("thead", {}, head), make("tbody", {}, ...body));
  const box = make("div", { class: "scroll numbers", tabindex: 0, role: "group", "aria-label": `Numbers of ${title}` }, table);
  if (rows.length > MAX_ROWS) box.append(make("p", { class: "note" }, `These are the first ${MAX_ROWS} of ${rows.length} rows; the CSV file has all of them.`));
  return box;
}

/** Return the cells of a line of CSV without their quotes. */
function cellsOf(line) {
  const cells = line.match(/("([^"]|"")*"|[^,]*)(,|$)/g).map((cell) => cell.replace(/,$/, ""));
  if (!line.endsWith(",")) cells.pop(); // the empty match at the end of the line
  return cells.map((cell) => (cell.startsWith('"') ? cell.slice(1, -1).replaceAll('""', '"') : cell));
}

/** Return the text of a cell, numbers with four digits. */
const shown = (text) => (text !== "" && Number.isFinite(Number(text)) ? worded(Number(text)) : text);
