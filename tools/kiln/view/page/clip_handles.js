// Handles on the picture for the clip box of a volume and for clip planes. A handle is dragged along its axis as the
// axis lies in the picture, and moved by arrow keys.
import { heightAtTarget, pixelOf, rayThrough } from './camera.js';
import { cornersOf, cornersOfWorld, faceMiddle, nearestOn, onSphere, planeThrough, sectionOf, unitPlane, wholeBox } from './box_geometry.js';
import { edgesPath } from './overlay.js';
import { follow, replace, svg } from './element.js';
import { add, clamp, distance, length, mix, normalize, rotate, scale, subtract, transformDirection } from './vector.js';
import { short } from './numbers.js';

const kAxes = ['x', 'y', 'z'];
const kRadius = 6;
const kArrowShare = 0.18; // share of the diagonal of the scene
const kLeastShare = 0.1;   // share of an axis' length: an axis seen shorter is dragged by up and down

export class ClipHandles {
  #layer;
  #root;
  #controls;

  /**
   * `controls`: setBox(box, mergeKey), setPlane(index, plane, mergeKey), endGesture(). A dragged handle calls these.
   */
  constructor({ root, layer, controls }) {
    this.#root = root;
    this.#layer = layer;
    this.#controls = controls;
  }

  /** `scene`: {camera, size, volume, box or null, planes, bounds of the world, lengthUnit}; null hides all handles. */
  draw(scene) {
    const focused = this.#layer.contains(document.activeElement) ? document.activeElement.getAttribute('data-handle') : null;
    replace(this.#layer, scene ? [...this.#boxNodes(scene), ...this.#planeNodes(scene)] : []);
    if (focused) this.#layer.querySelector(`[data-handle="${focused}"]`)?.focus({ preventScroll: true });
  }

  #place(event) {
    const area = this.#root.getBoundingClientRect();
    return { x: event.clientX - area.left, y: event.clientY - area.top };
  }

  // Returns the way in the picture, in pixels, of a way `unit` in the world.
  #pixelsOf({ camera, size }, point, unit) {
    const a = pixelOf(camera, size, point), b = pixelOf(camera, size, add(point, unit));
    return a && b ? { x: b.x - a.x, y: b.y - a.y } : null;
  }

  // Follows a drag; `moved(t)` gets the way in multiples of `unit`.
  #dragAlong(down, scene, point, unit, moved) {
    if (down.button !== 0) return;
    down.preventDefault();
    down.stopPropagation();
    const start = this.#place(down);
    const far = this.#pixelsOf(scene, point, unit);
    const squared = far ? far.x * far.x + far.y * far.y : 0;
    const worldPerPixel = heightAtTarget(scene.camera) / scene.size.height;
    const perUnit = length(unit) / worldPerPixel; // pixels of one unit across the view
    const isSeenAlong = Math.sqrt(squared) < kLeastShare * perUnit;
    this.#follow(down, (event) => {
      const here = this.#place(event);
      const [dx, dy] = [here.x - start.x, here.y - start.y];
      moved(isSeenAlong ? -dy / perUnit : (dx * far.x + dy * far.y) / squared);
    });
  }

  #follow(down, onMove) {
    follow({ currentTarget: this.#root, pointerId: down.pointerId }, onMove, () => this.#controls.endGesture());
  }

  #handle(id, at, label, value, valueText, { className = '', onDown, onStep }) {
    const node = svg('circle', { cx: at.x.toFixed(1), cy: at.y.toFixed(1), r: kRadius, class: `handle ${className}`, 'data-handle': id, tabindex: 0,
      role: 'slider', 'aria-label': label, 'aria-valuenow': value, 'aria-valuetext': valueText }, svg('title', {}, `${label}: ${valueText}`));
    node.addEventListener('pointerdown', (event) => { onDown(event); node.focus({ preventScroll: true }); });
    node.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      onStep(event.shiftKey ? 10 * step : step);
    });
    return node;
  }

  #boxNodes(scene) {
    const { camera, size, volume, box } = scene;
    if (!box) return [];
    const { affine } = volume;
    const nodes = [svg('path', { class: 'clip-box', d: edgesPath(camera, size, cornersOf(affine, box)) })];
    const whole = wholeBox(volume);
    for (const axis of [0, 1, 2]) {
      const unit = transformDirection(affine, [0, 1, 2].map((a) => (a === axis ? 1 : 0)));
      for (const side of [0, 1]) {
        const middle = faceMiddle(affine, box, axis, side);
        const at = pixelOf(camera, size, middle);
        if (!at) continue;
        const place = axis + 3 * side;
        const moved = (voxels, key) => {
          const next = [...box];
          const low = side ? box[axis] + 1 : whole[axis], high = side ? whole[axis + 3] : box[axis + 3] - 1;
          next[place] = clamp(box[place] + Math.round(voxels), low, high);
          this.#controls.setBox(next, key);
        };
        nodes.push(this.#handle(`box-${place}`, at, `${side ? 'Upper' : 'Lower'} ${kAxes[axis]} face of the clip box`, box[place], `${box[place]} voxels`, {
          className: `axis-${axis}`,
          onDown: (event) => this.#dragAlong(event, scene, middle, unit, (t) => moved(t, `box-${place}`)),
          onStep: (step) => moved(step, `box-key-${place}`),
        }));
      }
    }
    return nodes;
  }

  #planeNodes(scene) {
    const { camera, size, planes, bounds, lengthUnit } = scene;
    const corners = cornersOfWorld(bounds);
    const centre = mix(bounds.min, bounds.max, 0.5);
    const arrow = kArrowShare * distance(bounds.min, bounds.max);
    return planes.flatMap((given, index) => {
      const plane = unitPlane(given);
      const anchor = nearestOn(plane, centre), tip = add(anchor, scale(plane.normal, arrow));
      const [a, b] = [anchor, tip].map((point) => pixelOf(camera, size, point));
      if (!a || !b) return [];
      const outline = sectionOf(plane, corners).map((point) => pixelOf(camera, size, point));
      const name = `plane ${index + 1}`;
      const move = (by, key) => this.#controls.setPlane(index, { normal: plane.normal, offset: plane.offset - by }, key);
      return [
        outline.length > 2 && outline.every(Boolean) ? svg('path', { class: 'clip-plane', d: `M${outline.map((p) => `${p.x.toFixed(1)} ${p.y.toFixed(1)}`).join('L')}Z` }) : null,
        svg('line', { class: 'plane-arrow', x1: a.x, y1: a.y, x2: b.x, y2: b.y }),
        this.#handle(`normal-${index}`, b, `Direction of ${name}`, plane.normal[0], plane.normal.map((n) => short(n, 3)).join(', '), {
          className: 'tip',
          onDown: (event) => this.#dragNormal(event, scene, index, anchor, arrow, b.depth < a.depth),
          onStep: (step) => this.#controls.setPlane(index, turned(plane, anchor, camera, step), `normal-key-${index}`),
        }),
        this.#handle(`plane-${index}`, a, `Place of ${name}`, plane.offset, `${short(plane.offset)} ${lengthUnit}`, {
          onDown: (event) => this.#dragAlong(event, scene, anchor, scale(plane.normal, arrow), (t) => move(t * arrow, `plane-${index}`)),
          onStep: (step) => move((step * arrow) / 100, `plane-key-${index}`),
        }),
      ];
    });
  }

  #dragNormal(down, scene, index, anchor, radius, near) {
    if (down.button !== 0) return;
    down.preventDefault();
    down.stopPropagation();
    this.#follow(down, (event) => {
      const tip = onSphere(rayThrough(scene.camera, scene.size, this.#place(event)), anchor, radius, near);
      const normal = scale(subtract(tip, anchor), 1 / radius);
      this.#controls.setPlane(index, planeThrough(normal, anchor), `normal-${index}`);
    });
  }
}

// Turns the plane by `step` degrees about the up direction of the camera.
const turned = (plane, anchor, camera, step) => planeThrough(rotate(plane.normal, normalize(camera.up), (step * Math.PI) / 180), anchor);
