// Three slices through one crosshair, with the sides of `kiln slice`: the server names the axes of each slice. A slice
// is requested when the slice before has arrived; only the newest index is drawn.
import { button, follow, html, numberField, replace, svg } from './element.js';
import { short } from './numbers.js';
import { clamp, inverseAffine, transformPoint } from './vector.js';

const kAxes = ['x', 'y', 'z'];
const kEdges = ['left', 'right', 'top', 'bottom'];

export class Slices {
  #app;
  #volume = null;
  #index = 0;
  #cross = [0, 0, 0];
  #window = null;
  #labels = null; // function with labels, whose colours the slices have
  #views;
  #probing = false;
  #nextProbe = null;

  /** app: server, announce, onCross(voxel). */
  constructor(app) {
    this.#app = app;
    this.#views = kAxes.map(() => this.#newView());
    this.readout = html('output', { class: 'readout', 'aria-live': 'off' }, 'Point at a slice for its value.');
    const field = (label, unit, place) => numberField({ name: null, label: `${label} of the grey values`, unit, spokenUnit: 'value', onInput: (value) => {
      const next = [...(this.#window ?? this.#middle())];
      next[place] = value;
      if (next[1] > 0) this.#setWindow(next);
    } });
    this.centre = field('Centre', 'centre', 0);
    this.breadth = field('Width', 'width', 1);
    this.centre.input.placeholder = this.breadth.input.placeholder = 'auto';
    this.greyFields = html('span', { class: 'grey-fields' }, html('span', { class: 'dim' }, 'Grey'), this.centre.node, this.breadth.node,
      button('Auto', () => this.#setWindow(null), { class: 'small', 'aria-label': 'Auto grey values' }));
    this.node = html('div', { class: 'slices-inside' },
      html('div', { class: 'slices-bar' }, html('h2', {}, 'Slices'), this.readout, html('span', { class: 'spacer' }),
        this.greyFields),
      html('div', { class: 'slice-row' }, this.#views.map((view) => view.node)));
  }

  /** Colours the slices by a function with labels; null is grey. */
  color(fn) {
    if (JSON.stringify(fn) === JSON.stringify(this.#labels)) return;
    this.#labels = fn;
    this.greyFields.hidden = fn !== null;
    for (const view of this.#views) this.#draw(view);
  }

  get cross() { return this.#cross; }
  crossInWorld() { return this.#volume ? transformPoint(this.#volume.affine, this.#cross) : null; }

  /** Shows a volume of the session. */
  show(volume, index) {
    const same = this.#volume === volume;
    const world = this.#volume && !same ? this.crossInWorld() : null;
    this.#volume = volume;
    this.#index = index;
    if (same) return;
    // Another volume keeps the place of the crosshair in the world, if the place is inside.
    const kept = world && transformPoint(inverseAffine(volume.affine), world);
    const isInside = kept?.every((v, axis) => v > -0.5 && v < volume.voxels[axis] - 0.5);
    const start = isInside ? kept : volume.voxels.map((n) => (n - 1) / 2);
    this.#window = null;
    this.#fillWindow();
    this.#views.forEach((view, i) => this.#turn(view, volume.slices[i]));
    this.#setCross(start);
  }

  // Gives a view the axes of voxels and the letters of a volume's slice.
  #turn(view, { plane, axis, column, leftwards, row, upwards, letters }) {
    const name = kAxes[axis];
    Object.assign(view, { plane, axis, name, column, leftwards, row, upwards, index: -1, size: null });
    view.node.className = `slice axis-${axis}`;
    view.slider.max = this.#volume.voxels[axis] - 1;
    view.slider.setAttribute('aria-label', `Voxel of the slice across ${name}`);
    const kind = plane ? `Slice across ${name} (${plane})` : `Slice across ${name}`;
    view.frame.setAttribute('aria-label', `${kind}. Arrow keys move the crosshair, Page Up and Page Down change the slice.`);
    kEdges.forEach((edge, i) => { view.sides[edge].textContent = letters[i] ?? ''; });
  }

  #middle() {
    const [low, high] = this.#volume.range;
    return [(low + high) / 2, high - low];
  }
  #setWindow(window) {
    this.#window = window;
    this.#fillWindow();
    for (const view of this.#views) this.#draw(view);
  }
  #fillWindow() {
    this.centre.set(this.#window?.[0] ?? null);
    this.breadth.set(this.#window?.[1] ?? null);
  }

  #setCross(voxel) {
    this.#cross = voxel.map((v, axis) => clamp(Math.round(v), 0, this.#volume.voxels[axis] - 1));
    for (const view of this.#views) {
      const index = this.#cross[view.axis];
      if (view.index !== index) this.#draw(view);
      view.slider.value = index;
      view.caption.textContent = `${view.plane ? `${view.plane}, ` : ''}${view.name} = ${index} of ${this.#volume.voxels[view.axis] - 1}`;
      view.slider.setAttribute('aria-valuetext', `voxel ${index}`);
      this.#drawCross(view);
    }
    this.#app.onCross();
  }

  #newView() {
    const canvas = html('canvas', { width: 1, height: 1 });
    const lines = svg('svg', { class: 'slice-cross', preserveAspectRatio: 'none', viewBox: '0 0 1 1', 'aria-hidden': 'true' });
    const sides = Object.fromEntries(kEdges.map((side) => [side, html('span', { class: `side ${side}` })]));
    const frame = html('div', { class: 'slice-frame', tabindex: 0, role: 'application' }, canvas, lines, Object.values(sides));
    const slider = html('input', { type: 'range', min: 0, max: 1, step: 1 });
    const caption = html('span', { class: 'dim' });
    const area = html('div', { class: 'slice-area' }, frame);
    const node = html('div', { class: 'slice' }, area, html('div', { class: 'slice-foot' }, caption, slider));
    const view = { canvas, lines, sides, frame, slider, caption, area, node, index: -1, busy: false, wanted: false, size: null };
    slider.addEventListener('input', () => this.#step(view.axis, slider.valueAsNumber - this.#cross[view.axis]));
    frame.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || !this.#volume) return;
      event.preventDefault();
      frame.focus({ preventScroll: true });
      const take = (e) => { this.#setCross(this.#voxelAt(view, e)); this.#probe(this.#cross); };
      take(event);
      follow(event, take);
    });
    frame.addEventListener('pointermove', (event) => { if (this.#volume) this.#probe(this.#voxelAt(view, event).map(Math.round)); });
    frame.addEventListener('wheel', (event) => { event.preventDefault(); this.#step(view.axis, event.deltaY > 0 ? 1 : -1); }, { passive: false });
    frame.addEventListener('keydown', (event) => {
      const { axis, column, row } = view;
      const columnStep = view.leftwards ? -1 : 1, rowStep = view.upwards ? 1 : -1;
      const step = { ArrowLeft: [column, -columnStep], ArrowRight: [column, columnStep], ArrowUp: [row, rowStep], ArrowDown: [row, -rowStep], PageUp: [axis, 1], PageDown: [axis, -1] }[event.key];
      if (!step) return;
      event.preventDefault();
      this.#step(step[0], (event.shiftKey ? 10 : 1) * step[1]);
      this.#probe(this.#cross);
    });
    new ResizeObserver(() => this.#layout(view)).observe(area);
    return view;
  }

  #step(axis, by) {
    if (!this.#volume) return;
    const next = [...this.#cross];
    next[axis] += by;
    this.#setCross(next);
  }

  #voxelAt(view, event) {
    const box = view.frame.getBoundingClientRect();
    const x = (event.clientX - box.left) / box.width, y = (event.clientY - box.top) / box.height;
    const voxel = [...this.#cross];
    voxel[view.column] = (view.leftwards ? 1 - x : x) * this.#volume.voxels[view.column] - 0.5;
    voxel[view.row] = (view.upwards ? 1 - y : y) * this.#volume.voxels[view.row] - 0.5;
    return voxel;
  }

  #drawCross(view) {
    const { voxels } = this.#volume;
    const along = (axis, turned) => {
      const part = (this.#cross[axis] + 0.5) / voxels[axis];
      return turned ? 1 - part : part;
    };
    const x = along(view.column, view.leftwards), y = along(view.row, view.upwards);
    replace(view.lines, svg('path', { class: `axis-${view.column}`, d: `M${x} 0V1`, 'vector-effect': 'non-scaling-stroke' }),
      svg('path', { class: `axis-${view.row}`, d: `M0 ${y}H1`, 'vector-effect': 'non-scaling-stroke' }));
  }

  // The frame has the proportions of the slice in the world.
  #layout(view) {
    if (!this.#volume || view.area.clientWidth < 8 || view.area.clientHeight < 8) return;
    const { voxels, spacing } = this.#volume;
    const width = voxels[view.column] * spacing[view.column], height = voxels[view.row] * spacing[view.row];
    const fit = Math.min(view.area.clientWidth / width, view.area.clientHeight / height);
    view.frame.style.width = `${Math.max(1, Math.round(fit * width))}px`;
    view.frame.style.height = `${Math.max(1, Math.round(fit * height))}px`;
    const wanted = [view.frame.style.width, view.frame.style.height].map((side) => Math.min(4096, Math.round(parseInt(side, 10) * devicePixelRatio)));
    if (String(view.size) !== String(wanted)) {
      view.size = wanted;
      this.#draw(view);
    }
  }

  async #draw(view) {
    view.wanted = true;
    if (view.busy || !this.#volume) return;
    view.busy = true;
    while (view.wanted) {
      if (!view.size) this.#layout(view);
      view.wanted = false;
      if (!view.size) break;
      const index = this.#cross[view.axis];
      const body = { volume: this.#index, axis: view.name, index, size: view.size };
      if (this.#labels) body.transferFunction = this.#labels;
      else if (this.#window) body.window = this.#window;
      try {
        await this.#app.server.records('slice', body, undefined, async (head, payload) => {
          if (head.kind === 'error') throw new Error(head.error);
          if (payload.length === 0) return;
          const bitmap = await createImageBitmap(new Blob([payload], { type: 'image/png' }));
          [view.canvas.width, view.canvas.height] = [bitmap.width, bitmap.height];
          view.canvas.getContext('2d').drawImage(bitmap, 0, 0);
          bitmap.close();
        });
        view.index = index;
      } catch (error) {
        this.readout.textContent = error.message;
        view.index = -1;
      }
    }
    view.busy = false;
  }

  async #probe(voxel) {
    const inside = voxel.map((v, axis) => clamp(v, 0, this.#volume.voxels[axis] - 1));
    this.#nextProbe = inside;
    if (this.#probing) return;
    this.#probing = true;
    while (this.#nextProbe) {
      const wanted = this.#nextProbe;
      this.#nextProbe = null;
      try {
        const found = await this.#app.server.json('probe', { volume: this.#index, voxel: wanted });
        const place = kAxes.map((axis, i) => `${axis} ${wanted[i]}`).join('  ');
        const styled = this.#labels?.labels?.find((style) => style.label === found.value);
        const name = styled?.name ?? this.#volume.labels?.find((label) => label.value === found.value)?.name;
        const value = name ? `${short(found.value)} (${name})` : short(found.value);
        this.readout.textContent = `Voxel ${place} · value ${value} · ${found.world.map((n) => short(n)).join(', ')} ${this.#volume.unit || 'units'}`;
      } catch (error) {
        this.readout.textContent = error.message;
      }
    }
    this.#probing = false;
  }
}
