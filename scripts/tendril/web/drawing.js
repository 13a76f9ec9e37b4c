// What all pages draw alike: what a colour says of a number, arrows, the axis of a series.
const SIGNED = [[180, 4, 38], [221, 221, 221], [59, 76, 192]];  // of what has a sign: negative, 0, positive

const RISING = [[214, 214, 210], [253, 187, 132], [227, 74, 51], [127, 0, 0]];  // of what has none

// Where a value stands between none and the most, 0 to 1: small ones are told apart, too.
const saturation = (size, most) => (most > 0 ? Math.min(1, Math.asinh(20 * Math.abs(size) / most) / Math.asinh(20)) : 0);

// [red, green, blue] at a part of the way along some colours.
function mixed(stops, part) {
  const k = Math.min(Math.floor(part * (stops.length - 1)), stops.length - 2), w = part * (stops.length - 1) - k;
  return stops[k].map((c, i) => c * (1 - w) + stops[k + 1][i] * w);
}

// That of a number, of which colours are given for the least, 0 and the most.
function signed(stops, value, most) {
  return mixed([stops[1], stops[value < 0 ? 0 : 2]], saturation(value, most));
}

const rgb = (colour) => `rgb(${colour.map(Math.round)})`;

// An arrow as a path; head: of its length.
function arrowPath(ctx, x, y, dx, dy, head) {
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(x + dx, y + dy);
  ctx.lineTo(x + dx - head * (dx - 0.5 * dy), y + dy - head * (dy + 0.5 * dx));
  ctx.moveTo(x + dx, y + dy);
  ctx.lineTo(x + dx - head * (dx + 0.5 * dy), y + dy - head * (dy - 0.5 * dx));
}

// The axis of a series. A logarithmic one has lines and numbers at decades alone, and of many only at some; of its own, for
// those of uPlot have no end below 1e-16.
function valueAxis(log) {
  const axis = { size: 58, values: (u, ticks) => ticks.map(tick) };
  return log ? { ...axis, space: 1, splits: (u, which, low, high) => decades(Math.log10(low), Math.log10(high)) } : axis;
}

function decades(low, high) {
  const every = Math.max(1, Math.ceil((high - low) / 6)), found = [];
  for (let power = Math.ceil((low - 1e-9) / every) * every; power <= high + 1e-9; power += every) found.push(Number(`1e${power}`));
  return found;
}
