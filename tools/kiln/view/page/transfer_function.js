// Transfer functions as jobs have them: {unit, colorSpace, points: [{value, color, opacity}], gradientOpacity} or
// {unit, labels: [{label, name, color, opacity}]}. Each function returns a new object.
import { hexOfLinear, linearOf } from './color.js';

const clamp = (v, low, high) => Math.min(high, Math.max(low, v));

/** Returns linear colour and opacity at a value: even between points, constant beyond. */
export function at(fn, value) {
  const points = fn.points;
  let upper = points.findIndex((point) => point.value > value);
  if (upper < 0) upper = points.length;
  const below = points[Math.max(0, upper - 1)], above = points[Math.min(points.length - 1, upper)];
  const span = above.value - below.value;
  const t = span > 0 ? clamp((value - below.value) / span, 0, 1) : 0;
  const a = linearOf(below.color, fn.colorSpace), b = linearOf(above.color, fn.colorSpace);
  return {
    color: a.map((v, i) => v * (1 - t) + b[i] * t),
    opacity: below.opacity * (1 - t) + above.opacity * t,
  };
}

const colorAt = (fn, value) => hexOfLinear(at(fn, value).color);

/** Moves a point. Its value stays between its neighbours. `snap` rounds the value. */
export function withPoint(fn, index, changes) {
  const points = fn.points.map((point) => ({ ...point }));
  const point = Object.assign(points[index], changes);
  const low = points[index - 1]?.value ?? -Infinity, high = points[index + 1]?.value ?? Infinity;
  point.value = clamp(point.value, low, high);
  point.opacity = clamp(point.opacity, 0, 1);
  return { ...fn, points };
}

/** Adds a point; returns the function and the point's index. A point without a colour takes that of its place. */
export function withNewPoint(fn, value, opacity) {
  const color = colorAt(fn, value);
  const before = fn.points.findIndex((point) => point.value > value);
  const index = before < 0 ? fn.points.length : before;
  const points = [...fn.points];
  points.splice(index, 0, { value, color, opacity: clamp(opacity, 0, 1) });
  return { fn: { ...fn, points }, index };
}

/** Removes a point; the last one stays. */
export function withoutPoint(fn, index) {
  if (fn.points.length < 2) return fn;
  return { ...fn, points: fn.points.filter((_, i) => i !== index) };
}

/** Returns the values of the first and last point. */
export const rangeOf = (fn) => [fn.points[0].value, fn.points[fn.points.length - 1].value];

/**
 * Leaves out points whose colour and opacity follow from their neighbours to within `tolerance`.
 * Method: Douglas and Peucker 1973, on four channels.
 */
export function simplified(fn, tolerance) {
  const points = fn.points;
  const colors = points.map((point) => [...linearOf(point.color, fn.colorSpace), point.opacity]);
  const kept = new Set([0, points.length - 1]);
  const visit = (from, to) => {
    let worst = -1, error = tolerance;
    for (let i = from + 1; i < to; ++i) {
      const span = points[to].value - points[from].value;
      const t = span > 0 ? (points[i].value - points[from].value) / span : 0;
      const off = Math.max(...colors[i].map((v, c) => Math.abs(v - (colors[from][c] * (1 - t) + colors[to][c] * t))));
      if (off > error) [worst, error] = [i, off];
    }
    if (worst < 0) return;
    kept.add(worst);
    visit(from, worst);
    visit(worst, to);
  };
  visit(0, points.length - 1);
  return { ...fn, points: points.filter((_, i) => kept.has(i)) };
}

/** Changes one label's style. */
export function withLabel(fn, label, changes) {
  return { ...fn, labels: fn.labels.map((style) => (style.label === label ? { ...style, ...changes } : style)) };
}
