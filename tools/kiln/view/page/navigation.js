// Pointer, wheel and keys on the picture, translated to motions of the camera.
//
// Drag: orbit. Shift or middle button: pan. Ctrl: roll. Wheel: zoom at the pointer. Two fingers: zoom, pan and roll.
import * as cameras from './camera.js';

const kWheelPerDoubling = 500;
const kKeyTurn = (5 * Math.PI) / 180;
const kKeyZoom = 1.1;
const kKeyPan = 0.05;
export const kSides = { front: 'Front', back: 'Back', left: 'Left', right: 'Right', top: 'Top', bottom: 'Bottom' };
const kSideKeys = { 1: 'front', 2: 'back', 3: 'left', 4: 'right', 5: 'top', 6: 'bottom', f: 'front', b: 'back', l: 'left', r: 'right', t: 'top', d: 'bottom' };

/**
 * `controls` has camera(), size() of the picture in CSS pixels, move(camera, mergeKey), endGesture(), showSide(name) and
 * reset().
 */
export function navigate(surface, controls) {
  const pointers = new Map();
  let gesture = 0;

  const placeOf = (event) => {
    const box = surface.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const apply = (motion, key) => {
    const camera = controls.camera();
    if (camera) controls.move(motion(camera, controls.size()), key);
  };
  const middle = () => {
    const [a, b] = [...pointers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, spread: Math.hypot(a.x - b.x, a.y - b.y), angle: Math.atan2(b.y - a.y, b.x - a.x) };
  };

  surface.addEventListener('pointerdown', (event) => {
    if (event.target.closest('[data-handle]') || event.button === 2) return;
    if (event.button === 1) event.preventDefault();
    surface.setPointerCapture(event.pointerId);
    surface.focus({ preventScroll: true });
    pointers.set(event.pointerId, { ...placeOf(event), button: event.button });
    if (pointers.size === 1) ++gesture;
  });

  surface.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = placeOf(event);
    const dx = now.x - before.x, dy = now.y - before.y;
    const key = `drag-${gesture}`;
    if (pointers.size === 2) {
      const from = middle();
      Object.assign(before, now);
      const to = middle();
      apply((camera, size) => {
        const grown = cameras.zoom(camera, to.spread / Math.max(1, from.spread), size, from);
        return cameras.roll(cameras.pan(grown, to.x - from.x, to.y - from.y, size), from.angle - to.angle);
      }, key);
      return;
    }
    Object.assign(before, now);
    if (dx === 0 && dy === 0) return;
    if (event.ctrlKey) {
      const { width, height } = controls.size();
      const angleAt = (p) => Math.atan2(p.y - height / 2, p.x - width / 2);
      const turned = angleAt({ x: now.x - dx, y: now.y - dy }) - angleAt(now);
      apply((camera) => cameras.roll(camera, Math.atan2(Math.sin(turned), Math.cos(turned))), key);
    } else if (event.shiftKey || before.button === 1) {
      apply((camera, size) => cameras.pan(camera, dx, dy, size), key);
    } else {
      apply((camera, size) => cameras.orbit(camera, dx, dy, size), key);
    }
  });

  const release = (event) => {
    if (pointers.delete(event.pointerId) && pointers.size === 0) controls.endGesture();
  };
  surface.addEventListener('pointerup', release);
  surface.addEventListener('pointercancel', release);

  surface.addEventListener('wheel', (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 33 : event.deltaMode === 2 ? 500 : 1;
    // A pinch on a touchpad arrives as a wheel with Ctrl, in smaller steps.
    const steps = (event.ctrlKey ? 5 : 1) * lines * event.deltaY;
    apply((camera, size) => cameras.zoom(camera, 2 ** (-steps / kWheelPerDoubling), size, placeOf(event)), 'wheel');
  }, { passive: false });

  const keyMotion = (event) => {
    const large = event.shiftKey;
    const step = (x, y) => (camera, size) => (large
      ? cameras.pan(camera, x * kKeyPan * size.width, y * kKeyPan * size.height, size)
      : cameras.orbitBy(camera, -x * kKeyTurn, y * kKeyTurn));
    return {
      ArrowLeft: step(-1, 0), ArrowRight: step(1, 0), ArrowUp: step(0, -1), ArrowDown: step(0, 1),
      '+': (camera, size) => cameras.zoom(camera, kKeyZoom, size),
      '=': (camera, size) => cameras.zoom(camera, kKeyZoom, size),
      '-': (camera, size) => cameras.zoom(camera, 1 / kKeyZoom, size),
      '[': (camera) => cameras.roll(camera, kKeyTurn),
      ']': (camera) => cameras.roll(camera, -kKeyTurn),
    }[event.key];
  };
  surface.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target !== surface) return;
    const motion = keyMotion(event);
    const side = kSideKeys[event.key.toLowerCase()];
    if (motion) apply(motion, `key-${event.key}`);
    else if (event.key === 'Home') controls.reset();
    else if (side) controls.showSide(side);
    else return;
    event.preventDefault();
  });
}
