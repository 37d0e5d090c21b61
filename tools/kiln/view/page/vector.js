// Vectors of three numbers, as arrays, and a bound for numbers. No function changes its arguments.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, factor) => [a[0] * factor, a[1] * factor, a[2] * factor];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
export const distance = (a, b) => length(subtract(a, b));
export const normalize = (a) => scale(a, 1 / length(a));
export const mix = (a, b, t) => add(scale(a, 1 - t), scale(b, t));

/** Returns `a` turned about a unit axis, counter-clockwise if seen against the axis (Rodrigues' formula). */
export function rotate(a, axis, radians) {
  const cosine = Math.cos(radians);
  const along = scale(axis, dot(axis, a) * (1 - cosine));
  return add(add(scale(a, cosine), scale(cross(axis, a), Math.sin(radians))), along);
}

/** Returns a unit vector at a right angle to `a`. */
export function anyNormalTo(a) {
  const sizes = a.map(Math.abs);
  const least = sizes.indexOf(Math.min(...sizes));
  return normalize(cross(a, [0, 1, 2].map((axis) => (axis === least ? 1 : 0))));
}

/** Applies an affine map of three rows of four numbers to a point. */
export const transformPoint = (rows, p) => rows.slice(0, 3).map((row) => row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]);
/** Applies the linear part of an affine map to a direction. */
export const transformDirection = (rows, d) => rows.slice(0, 3).map((row) => row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);

/** Returns the affine map that undoes `rows`. */
export function inverseAffine(rows) {
  const [a, b, c] = rows.map((row) => row.slice(0, 3));
  const columns = [cross(b, c), cross(c, a), cross(a, b)];
  const determinant = dot(a, columns[0]);
  const inverse = [0, 1, 2].map((row) => columns.map((column) => column[row] / determinant));
  const origin = rows.slice(0, 3).map((row) => row[3]);
  return inverse.map((row) => [...row, -dot(row, origin)]);
}

/** Returns the number, or the nearer of the ends if the number lies outside. */
export const clamp = (v, low, high) => Math.min(high, Math.max(low, v));
