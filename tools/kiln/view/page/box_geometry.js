// Boxes of voxels and planes in the world, as outlines to draw. A box is [x0, y0, z0, x1, y1, z1], half-open, of voxels
// whose centres are whole numbers; its faces therefore lie half a voxel before its numbers.
import { add, anyNormalTo, cross, dot, length, normalize, scale, subtract, transformPoint } from './vector.js';

/** Pairs of corners; a corner's bits choose the higher side of x, y and z. */
export const kEdges = [0, 1, 2].flatMap((axis) => [0, 1, 2, 3, 4, 5, 6, 7].filter((corner) => !(corner & (1 << axis))).map((corner) => [corner, corner | (1 << axis)]));

export const wholeBox = (volume) => [0, 0, 0, ...volume.voxels];

/** Returns the eight corners of a box of voxels in the world. */
export function cornersOf(affine, box) {
  return [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => transformPoint(affine, [0, 1, 2].map((axis) => box[axis + (corner & (1 << axis) ? 3 : 0)] - 0.5)));
}

/** Returns the eight corners of a box of the world, {min, max}. */
export const cornersOfWorld = ({ min, max }) => [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => [0, 1, 2].map((axis) => (corner & (1 << axis) ? max : min)[axis]));

/** Returns the middle of the face `side` (0 low, 1 high) of an axis, in the world. */
export function faceMiddle(affine, box, axis, side) {
  const index = [0, 1, 2].map((a) => (box[a] + box[a + 3] - 1) / 2);
  index[axis] = box[axis + 3 * side] - 0.5;
  return transformPoint(affine, index);
}

/** Returns the plane with a unit normal, {normal, offset}: points with normal·x + offset >= 0 are shown. */
export function unitPlane(plane) {
  const size = length(plane.normal);
  return { normal: scale(plane.normal, 1 / size), offset: plane.offset / size };
}

const distanceTo = (plane, point) => dot(plane.normal, point) + plane.offset;
/** Returns the point of a unit plane nearest to `point`. */
export const nearestOn = (plane, point) => subtract(point, scale(plane.normal, distanceTo(plane, point)));
/** Returns the plane through a point. */
export const planeThrough = (normal, point) => ({ normal, offset: -dot(normal, point) });

/** Returns the polygon in which a plane cuts a box of eight corners, in order around the plane; [] if they miss. */
export function sectionOf(plane, corners) {
  const points = [];
  for (const [a, b] of kEdges) {
    const da = distanceTo(plane, corners[a]), db = distanceTo(plane, corners[b]);
    if ((da < 0) === (db < 0)) continue;
    points.push(add(corners[a], scale(subtract(corners[b], corners[a]), da / (da - db))));
  }
  if (points.length < 3) return [];
  const middle = scale(points.reduce(add), 1 / points.length);
  const u = anyNormalTo(normalize(plane.normal)), v = cross(normalize(plane.normal), u);
  const angle = (p) => Math.atan2(dot(subtract(p, middle), v), dot(subtract(p, middle), u));
  return points.sort((a, b) => angle(a) - angle(b));
}

/** Returns the point where a ray meets a sphere, on the near or far side; beside the sphere, the nearest point of it. */
export function onSphere(ray, middle, radius, near) {
  const from = subtract(ray.from, middle);
  const along = -dot(from, ray.direction);
  const closest = add(from, scale(ray.direction, along));
  const inside = radius * radius - dot(closest, closest);
  const place = inside > 0 ? add(closest, scale(ray.direction, (near ? -1 : 1) * Math.sqrt(inside))) : scale(normalize(closest), radius);
  return add(middle, place);
}
