"use strict";
// Numbers as pages write them.
function number(v) {
  if (!Number.isFinite(v)) return "–";
  const size = Math.abs(v);
  return size === 0 ? "0" : size >= 1e-3 && size < 1e5 ? String(+v.toPrecision(4)) : v.toExponential(2);
}

function tick(v) {
  const size = Math.abs(v);
  return v === null ? "" : size === 0 || (size >= 1e-3 && size < 1e5) ? String(+v.toPrecision(6))
    : v.toExponential().replace("e+", "e");
}

// Base64 of 32-bit numbers.
function floats(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

// ... of 64-bit numbers.
function doubles(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}
