// Transfer functions as jobs have them: {unit, colorSpace, points: [{value, color, opacity}], gradientOpacity}, or
// {surfaces: [{value, color, opacity}]}, or {unit, labels: [{label, name, color, opacity}]}. Each function returns a new
// object. An item is a point or a surface; items are sorted by value.
import { hexOfLinear, linearOf } from './color.js';
import { clamp } from './vector.js';

const kSurfaceColor = 'ivory', kSurfaceOpacity = 1; // defaults of a surface
const kSurfaceGap = 1e-6; // share of the value: two surfaces have different values

export const hasSurfaces = (fn) => fn.surfaces !== undefined;
const withItems = (fn, items) => (hasSurfaces(fn) ? { ...fn, surfaces: items } : { ...fn, points: items });

/** Returns the points or surfaces, with colour and opacity. */
export function itemsOf(fn) {
  return hasSurfaces(fn) ? fn.surfaces.map((surface) => ({ color: kSurfaceColor, opacity: kSurfaceOpacity, ...surface })) : fn.points;
}

/** Returns linear colour and opacity of points at a value: even between points, constant beyond. */
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

/** Changes an item. Its value stays between its neighbours. */
export function withItem(fn, index, changes) {
  const items = itemsOf(fn).map((item) => ({ ...item }));
  const item = Object.assign(items[index], changes);
  const gap = hasSurfaces(fn) ? kSurfaceGap * Math.max(1, Math.abs(item.value)) : 0;
  item.value = clamp(item.value, (items[index - 1]?.value ?? -Infinity) + gap, (items[index + 1]?.value ?? Infinity) - gap);
  item.opacity = clamp(item.opacity, 0, 1);
  return withItems(fn, items);
}

/** Adds an item; returns the function and the item's index. A point has the colour of its place, a surface ivory. */
export function withNewItem(fn, value, opacity) {
  const items = itemsOf(fn);
  const after = items.findIndex((item) => item.value > value);
  const index = after < 0 ? items.length : after;
  const color = hasSurfaces(fn) ? kSurfaceColor : hexOfLinear(at(fn, value).color);
  const out = withItems(fn, items.toSpliced(index, 0, { value, color, opacity: 0 }));
  return { fn: withItem(out, index, { opacity }), index };
}

/** Removes an item; the last one stays. */
export function withoutItem(fn, index) {
  const items = itemsOf(fn);
  return items.length < 2 ? fn : withItems(fn, items.filter((_, i) => i !== index));
}

/** Returns the values of the first and last item. */
export function rangeOf(fn) {
  const items = itemsOf(fn);
  return [items[0].value, items[items.length - 1].value];
}

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
