// ---- marks on pictures of the contact: circle, scale and arrow ----

/** Draws the dashed circle of the contact of a smooth sphere. */
export function drawEllipse(pen, x, y, [along, across]) {
  pen.setLineDash([9, 7]);
  for (const [colour, width] of [["#000", 5], ["#7fd4ff", 2]]) { // seen on the darkest pressure and on the lightest
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    pen.ellipse(x, y, along, across, 0, 0, 2 * Math.PI);
    pen.stroke();
  }
  pen.setLineDash([]);
}

/** Draws a scale of length, at most so many um long. */
export function drawScale(pen, perUm, longest) {
  const decade = 10 ** Math.floor(Math.log10(longest));
  const length = [5, 2, 1].find((digit) => digit * decade <= longest) * decade;
  const { height } = pen.canvas;
  pen.fillStyle = "#fff";
  pen.fillRect(16, height - 20, length * perUm, 4);
  pen.font = "22px system-ui, sans-serif";
  pen.textAlign = "left";
  pen.fillText(`${Number(length.toPrecision(1))} µm`, 16, height - 28);
}

/** Draws the arrow that says where the sphere rolls. */
export function drawArrow(pen) {
  const { width, height } = pen.canvas;
  pen.fillStyle = pen.strokeStyle = "#fff";
  pen.lineWidth = 3;
  pen.beginPath();
  pen.moveTo(width - 90, height - 18);
  pen.lineTo(width - 28, height - 18);
  pen.stroke();
  pen.beginPath();
  pen.moveTo(width - 14, height - 18);
  pen.lineTo(width - 32, height - 26);
  pen.lineTo(width - 32, height - 10);
  pen.fill();
  pen.textAlign = "right";
  pen.fillText("rolls", width - 14, height - 36);
}
