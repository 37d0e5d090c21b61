// A camera as a job has it: {projection, eye, target, up, fov | height}. `fov` is the vertical field of view in
// degrees, `height` the world length that an orthographic picture spans vertically. Each function returns a new camera.
//
// The up direction stays while the eye orbits, so the horizon keeps its place; only `roll` changes it. Pictures have x
// to the right and y down, in pixels, as pointers do.
import { add, anyNormalTo, cross, distance, dot, length, normalize, rotate, scale, subtract } from './vector.js';

const kLeastPoleAngle = (1 * Math.PI) / 180;
const kDefaultFov_deg = 30;
const kSteepest_deg = 150;

const radians = (degrees) => (degrees * Math.PI) / 180;

/** Returns the unit axes of the picture in the world. */
export function axesOf(camera) {
  const forward = normalize(subtract(camera.target, camera.eye));
  const across = cross(forward, camera.up);
  const right = length(across) > 1e-9 * length(camera.up) ? normalize(across) : anyNormalTo(forward);
  return { right, up: cross(right, forward), forward };
}

/** Returns the world length that the picture spans vertically at the depth of the target. */
export function heightAtTarget(camera) {
  if (camera.projection === 'orthographic') return camera.height;
  return 2 * Math.tan(radians(camera.fov) / 2) * distance(camera.eye, camera.target);
}

/** Turns the eye about the target: a whole half turn for a drag along the shorter side of the picture. */
export function orbit(camera, dx_px, dy_px, size) {
  const perPixel = Math.PI / Math.min(size.width, size.height);
  return orbitBy(camera, -dx_px * perPixel, dy_px * perPixel);
}

/** Turns the eye about the up direction by `turn`, then towards it by `rise`; the poles are not passed. unit: radians. */
export function orbitBy(camera, turn, rise) {
  const up = normalize(camera.up);
  const { right } = axesOf(camera);
  const towardsEye = subtract(camera.eye, camera.target);
  const poleAngle = Math.acos(Math.max(-1, Math.min(1, dot(normalize(towardsEye), up))));
  const allowed = Math.max(kLeastPoleAngle, Math.min(Math.PI - kLeastPoleAngle, poleAngle - rise));
  const raised = rotate(towardsEye, right, allowed - poleAngle);
  return { ...camera, eye: add(camera.target, rotate(raised, up, turn)) };
}

/** Moves the camera so that the content at the depth of the target follows the pointer. */
export function pan(camera, dx_px, dy_px, size) {
  const perPixel = heightAtTarget(camera) / size.height;
  const { right, up } = axesOf(camera);
  const by = add(scale(right, -dx_px * perPixel), scale(up, dy_px * perPixel));
  return { ...camera, eye: add(camera.eye, by), target: add(camera.target, by) };
}

/** Enlarges the content by `factor`. The content under `at`, at the depth of the target, keeps its pixel. */
export function zoom(camera, factor, size, at = { x: size.width / 2, y: size.height / 2 }) {
  const fromMiddle = { x: at.x - size.width / 2, y: at.y - size.height / 2 };
  const grown = camera.projection === 'orthographic'
    ? { ...camera, height: camera.height / factor }
    : { ...camera, eye: add(camera.target, scale(subtract(camera.eye, camera.target), 1 / factor)) };
  return pan(grown, fromMiddle.x * (1 - factor), fromMiddle.y * (1 - factor), size);
}

/** Turns the content of the picture counter-clockwise, and with it the up direction. */
export function roll(camera, angle) {
  const { up, forward } = axesOf(camera);
  return { ...camera, up: rotate(up, forward, angle) };
}

/** Changes the projection. The content at the depth of the target keeps its size. `radius` is that of the scene. */
export function withProjection(camera, projection, radius) {
  if (projection === camera.projection) return camera;
  const height = heightAtTarget(camera);
  const { fov: _fov, height: _height, ...place } = camera;
  const back = scale(axesOf(camera).forward, -1);
  if (projection === 'orthographic') {
    const away = Math.max(distance(camera.eye, camera.target), 2 * radius);
    return { ...place, projection, eye: add(camera.target, scale(back, away)), height };
  }
  const away = height / (2 * Math.tan(radians(kDefaultFov_deg) / 2));
  return { ...place, projection, eye: add(camera.target, scale(back, away)), fov: kDefaultFov_deg };
}

/** Changes the field of view and the distance of the eye: the content at the depth of the target keeps its size. */
export function withFov(camera, fov) {
  const legal = Math.max(1, Math.min(kSteepest_deg, fov));
  const away = heightAtTarget(camera) / (2 * Math.tan(radians(legal) / 2));
  const back = scale(axesOf(camera).forward, -1);
  return { ...camera, fov: legal, eye: add(camera.target, scale(back, away)) };
}

/** Returns the pixel of a world point and its depth; pixels of points behind a perspective eye are null. */
export function pixelOf(camera, size, world) {
  const { right, up, forward } = axesOf(camera);
  const parallel = camera.projection === 'orthographic';
  const from = subtract(world, parallel ? camera.target : camera.eye);
  const depth = dot(from, forward);
  if (!parallel && depth <= 0) return null;
  const perUnit = parallel ? size.height / camera.height : size.height / (2 * Math.tan(radians(camera.fov) / 2) * depth);
  return { x: size.width / 2 + dot(from, right) * perUnit, y: size.height / 2 - dot(from, up) * perUnit, depth };
}

/** Returns the ray through a pixel: a point and a unit direction. */
export function rayThrough(camera, size, pixel) {
  const { right, up, forward } = axesOf(camera);
  const x = pixel.x - size.width / 2, y = size.height / 2 - pixel.y;
  const across = (perPixel) => add(scale(right, x * perPixel), scale(up, y * perPixel));
  if (camera.projection === 'orthographic') {
    return { from: add(add(camera.target, across(camera.height / size.height)), scale(forward, -distance(camera.eye, camera.target))), direction: forward };
  }
  const perPixel = (2 * Math.tan(radians(camera.fov) / 2)) / size.height;
  return { from: camera.eye, direction: normalize(add(forward, across(perPixel))) };
}

/** Rounds the camera's numbers to a millionth of the eye's distance, so that jobs are readable. */
export function rounded(camera) {
  const digits = Math.max(0, Math.min(12, 6 - Math.floor(Math.log10(distance(camera.eye, camera.target) || 1))));
  const short = (number) => Number(number.toFixed(digits));
  const out = { projection: camera.projection, eye: camera.eye.map(short), target: camera.target.map(short), up: camera.up.map((n) => Number(n.toFixed(6))) };
  if (camera.projection === 'orthographic') return { ...out, height: Number(camera.height.toPrecision(8)) };
  return { ...out, fov: Number(camera.fov.toPrecision(8)) };
}
