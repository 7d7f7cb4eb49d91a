// ---- tables that sort ----

/** The number in a cell, or its text; an uncertainty after it does not count. */
function valueOf(cell) {
  const number = parseFloat(cell.textContent.replace("−", "-"));
  return Number.isNaN(number) ? cell.textContent.trim() : number;
}

function sortBy(button) {
  const head = button.closest("th"), column = head.cellIndex, body = head.closest("table").tBodies[0];
  const down = head.getAttribute("aria-sort") === "ascending";
  const rows = [...body.rows].map((row, place) => ({ row, place, value: valueOf(row.cells[column]) }));
  const order = ({ value: a, place: p }, { value: b, place: q }) => {
    if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1; // silent and missing ones stay at the end
    const ascending = typeof a === "number" ? a - b : a.localeCompare(b);
    return (down ? -ascending : ascending) || p - q;
  };
  body.append(...rows.sort(order).map(({ row }) => row));
  for (const other of head.parentNode.cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", down ? "descending" : "ascending");
}

/** Makes the heads of a table into buttons. */
function makeSortable(table) {
  for (const head of table.tHead.rows[0].cells) {
    const button = Object.assign(document.createElement("button"), { type: "button", className: "sort" });
    button.append(...head.childNodes);
    button.addEventListener("click", () => sortBy(button));
    head.append(button);
  }
}
