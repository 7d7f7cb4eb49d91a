// ---- folded parts of the page, which are printed with it ----

let unfolded = []; // parts that are open for the printer alone

/** Open all folded parts. */
export function unfold() {
  unfolded = [...document.querySelectorAll("details:not([open])")];
  for (const part of unfolded) part.open = true;
}

/** Fold the parts again that were opened for the printer. */
export function foldAgain() {
  for (const part of unfolded) part.open = false;
}
