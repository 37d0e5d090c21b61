// Lines over the picture: axes of the world, a bar of known length, the box of the volume, and the handles of clipping.
// Everything is drawn from the camera of the job, in CSS pixels.
import { axesOf, heightAtTarget, pixelOf } from './camera.js';
import { cornersOf, kEdges } from './box_geometry.js';
import { replace, svg } from './element.js';
import { roundLength, short } from './numbers.js';
import { dot } from './vector.js';

const kAxesRadius = 26;
const kLeastAxis = 0.12; // share of an axis' length: a shorter axis is seen from its end
const kBarShare = 0.22;
const kLongestBar_px = 240;

export class Overlay {
  constructor(root) {
    this.root = root;
    const layer = (name, more = {}) => svg('g', { class: name, ...more });
    this.box = layer('volume-box');
    this.cross = layer('cross');
    this.handles = layer('handles');
    this.axes = layer('world-axes');
    this.bar = layer('scale-bar');
    root.append(this.box, this.cross, this.handles, this.axes, this.bar);
  }

  /** `scene`: {camera, size, lengthUnit, axisNames, box: {affine, box} or null, cross: world point or null}. */
  draw({ camera, size, lengthUnit, names, box, cross }) {
    this.root.setAttribute('viewBox', `0 0 ${size.width} ${size.height}`);
    this.#drawAxes(camera, size, names);
    this.#drawBar(camera, size, lengthUnit);
    replace(this.box, box ? [svg('path', { d: edgesPath(camera, size, cornersOf(box.affine, box.box)) })] : []);
    const at = cross && pixelOf(camera, size, cross);
    replace(this.cross, at ? [svg('path', { d: `M${at.x - 9} ${at.y}h6m6 0h6M${at.x} ${at.y - 9}v6m0 6v6` })] : []);
  }

  #drawAxes(camera, size, names) {
    const { right, up, forward } = axesOf(camera);
    const middle = { x: 42, y: size.height - 42 };
    const ends = [0, 1, 2].map((axis) => {
      const direction = [0, 1, 2].map((a) => (a === axis ? 1 : 0));
      return { name: names[axis], x: dot(direction, right), y: -dot(direction, up), depth: dot(direction, forward), axis };
    });
    ends.sort((a, b) => b.depth - a.depth);
    const seen = ends.filter((end) => Math.hypot(end.x, end.y) > kLeastAxis);
    replace(this.axes, seen.map((end) => [
      svg('line', { x1: middle.x, y1: middle.y, x2: middle.x + kAxesRadius * end.x, y2: middle.y + kAxesRadius * end.y, class: `axis-${end.axis}` }),
      svg('text', { x: middle.x + (kAxesRadius + 8) * end.x, y: middle.y + (kAxesRadius + 8) * end.y + 3.5, 'text-anchor': 'middle', class: `axis-${end.axis}` }, end.name),
    ]).flat());
  }

  #drawBar(camera, size, unit) {
    const perUnit = size.height / heightAtTarget(camera);
    const length = roundLength(Math.min(kLongestBar_px, kBarShare * size.width) / perUnit);
    const width = length * perUnit;
    const x = size.width - 14 - width, y = size.height - 14;
    replace(this.bar,
      svg('path', { d: `M${x} ${y - 5}v5h${width}v-5` }),
      svg('text', { x: x + width / 2, y: y - 5, 'text-anchor': 'middle' }, `${short(length)} ${unit}`));
  }
}

/** Returns the path of the edges of a box; edges with an end behind the eye are left out. */
export function edgesPath(camera, size, corners) {
  const pixels = corners.map((corner) => pixelOf(camera, size, corner));
  return kEdges.filter(([a, b]) => pixels[a] && pixels[b])
    .map(([a, b]) => `M${pixels[a].x.toFixed(1)} ${pixels[a].y.toFixed(1)}L${pixels[b].x.toFixed(1)} ${pixels[b].y.toFixed(1)}`).join('');
}
