// The editor of a transfer function: points or surfaces over the histogram of the volume, a bar for the window of points,
// fields for the selected item. Opacity has an axis of square roots, because useful opacities of tissue begin at a hundredth.
import { at, hasSurfaces, itemsOf, rangeOf, simplified, withItem, withNewItem, withoutItem } from './transfer_function.js';
import { hexOf, hexOfLinear } from './color.js';
import { GradientList } from './gradient_list.js';
import { button, colorField, follow, html, newId, numberField, replace, svg } from './element.js';
import { short, ticks } from './numbers.js';
import { clamp } from './vector.js';

const kHeight = 210, kLeft = 36, kRight = 12, kTop = 10, kBottom = 46;
const kOpacityTicks = [0, 0.01, 0.05, 0.1, 0.2, 0.5, 1];
const kCurveSteps = 160;
const kManyPoints = 48;
const kPointRadius = 6;
const kSimplifyTolerance = 0.01;

export class FunctionEditor {
  #onFunction;
  #onWindow;
  #onDone;
  #fn = null;
  #items = [];     // points or surfaces
  #noun = 'Point';
  #histogram = null;
  #view = null;  // shown values: [low, high]
  #whole = null; // all values of interest
  #selected = 0;
  #width = 380;
  #gradientId = newId('colors');
  #clipId = newId('plot');
  #gesture = 0;

  /** onFunction(fn, label, mergeKey), onWindow([centre, width], mergeKey), onDone() at the end of a gesture. */
  constructor({ onFunction, onWindow, onDone }) {
    this.#onFunction = onFunction;
    this.#onWindow = onWindow;
    this.#onDone = onDone;
    this.plot = svg('svg', { class: 'function-plot', role: 'group', 'aria-label': 'Transfer function over the histogram' });
    this.#layers();
    const field = (options) => numberField({ name: null, onDone, ...options });
    this.value = field({ label: 'Value of the point', unit: 'value', spokenUnit: '', late: true, onInput: (value) => this.#editPoint({ value }, 'value of a point') });
    this.opacity = field({ label: 'Opacity of the point', min: 0, max: 1, step: 0.01, onInput: (opacity) => this.#editPoint({ opacity }, 'opacity of a point') });
    this.color = colorField({ label: 'Colour of the point', onInput: (color) => this.#editPoint({ color }, 'colour of a point'), onDone });
    this.unit = field({ label: 'Opacity is per this length', min: 0, onInput: (unit) => { if (unit > 0) this.#emit({ ...this.#fn, unit }, 'unit of opacity', 'unit'); } });
    this.centre = field({ label: 'Centre of the window', unit: 'centre', spokenUnit: 'value', onInput: (centre) => this.#editWindow([centre, this.#window()[1]], 'window-number') });
    this.breadth = field({ label: 'Width of the window', unit: 'width', spokenUnit: 'value', onInput: (width) => { if (width > 0) this.#editWindow([this.#window()[0], width], 'window-number'); } });
    this.count = html('span', { class: 'dim' });
    this.previous = button('‹', () => this.#select(this.#selected - 1), { 'aria-label': 'Previous point', class: 'small' });
    this.next = button('›', () => this.#select(this.#selected + 1), { 'aria-label': 'Next point', class: 'small' });
    this.fewer = button('Fewer points', () => this.#emit(simplified(this.#fn, kSimplifyTolerance), 'fewer points'), { class: 'small', title: 'Leaves out points that change colour and opacity by less than a hundredth' });
    this.add = button('Add point', () => this.#addBeside(), { class: 'small' });
    this.name = html('span', { class: 'name' }, 'Point');
    const per = html('span', { class: 'controls' }, html('span', { class: 'unit' }, 'per'), this.unit.node);
    const windowName = html('span', { class: 'name' }, 'Window'), windowFields = html('span', { class: 'controls' }, this.centre.node, this.breadth.node);
    this.ofPoints = [per, windowName, windowFields];
    this.gradient = new GradientList({ onDone, onFactors: (factors, label, key) => this.#editFactors(factors, label, key) });
    this.node = html('div', { class: 'function-editor' }, this.plot,
      html('div', { class: 'point-row' }, this.previous, this.count, this.next,
        html('span', { class: 'spacer' }),
        this.add,
        button('Delete', () => this.#remove(this.#selected), { class: 'small' }), this.fewer),
      html('div', { class: 'grid-fields' },
        this.name, html('span', { class: 'controls' }, this.value.node, this.color.node),
        html('span', { class: 'name' }, 'Opacity'), html('span', { class: 'controls' }, this.opacity.node, per),
        windowName, windowFields),
      this.gradient.node);
    new ResizeObserver(([entry]) => {
      const width = Math.round(entry.contentRect.width);
      if (width > 0 && width !== this.#width) { this.#width = width; this.#draw(); }
    }).observe(this.plot);
  }

  /** Shows a function with points or surfaces. `lengthUnit` is the unit of the volume's world. */
  show({ fn, histogram, lengthUnit }) {
    const fresh = this.#histogram !== histogram;
    this.#fn = fn;
    this.#items = itemsOf(fn);
    this.#noun = hasSurfaces(fn) ? 'Surface' : 'Point';
    this.#histogram = histogram;
    const [first, last] = rangeOf(fn);
    const pad = 0.02 * (histogram.high - histogram.low || 1);
    this.#whole = [Math.min(histogram.low - pad, first), Math.max(histogram.high + pad, last)];
    if (fresh || !this.#view) this.#view = this.#whole;
    this.#selected = clamp(this.#selected, 0, this.#items.length - 1);
    this.unit.setUnit(lengthUnit);
    this.gradient.describe(lengthUnit, (histogram.high - histogram.low) / (fn.unit || 1));
    this.#draw();
  }

  #layers() {
    const layer = (name, attributes = {}) => svg('g', { class: name, ...attributes });
    this.gradientStops = svg('linearGradient', { id: this.#gradientId, gradientUnits: 'userSpaceOnUse', y1: 0, y2: 0 });
    this.clip = svg('rect', {});
    this.back = svg('rect', { class: 'plot-back' });
    this.bars = svg('path', { class: 'bars' });
    this.area = svg('path', { class: 'area', fill: `url(#${this.#gradientId})` });
    this.curve = svg('path', { class: 'curve' });
    this.band = svg('rect', { class: 'band', fill: `url(#${this.#gradientId})` });
    this.axes = layer('axes', { 'aria-hidden': 'true' });
    this.windowBar = layer('window-bar');
    this.points = layer('points');
    const clipped = { 'clip-path': `url(#${this.#clipId})` };
    this.plot.append(
      svg('defs', {}, this.gradientStops, svg('clipPath', { id: this.#clipId }, this.clip)),
      this.back, svg('g', clipped, this.bars, this.area, this.curve), this.band, this.axes, this.windowBar, this.points);
    this.back.addEventListener('pointerdown', (event) => this.#panView(event));
    for (const target of [this.back, this.area, this.curve, this.bars])
      target.addEventListener('dblclick', (event) => this.#addAt(event));
    this.plot.addEventListener('wheel', (event) => this.#zoomView(event), { passive: false });
  }

  // Scales of the plot.
  get #right() { return this.#width - kRight; }
  get #base() { return kHeight - kBottom; }
  #x(value) { return kLeft + ((value - this.#view[0]) / (this.#view[1] - this.#view[0])) * (this.#right - kLeft); }
  #valueAt(x) { return this.#view[0] + ((x - kLeft) / (this.#right - kLeft)) * (this.#view[1] - this.#view[0]); }
  #y(opacity) { return this.#base - Math.sqrt(clamp(opacity, 0, 1)) * (this.#base - kTop); }
  #opacityAt(y) { return clamp((this.#base - y) / (this.#base - kTop), 0, 1) ** 2; }
  #tidy(value) {
    const step = 10 ** Math.floor(Math.log10((this.#view[1] - this.#view[0]) / 1000));
    return Number((Math.round(value / step) * step).toPrecision(12));
  }
  #place(event) {
    const box = this.plot.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  #draw() {
    if (!this.#fn) return;
    this.plot.setAttribute('viewBox', `0 0 ${this.#width} ${kHeight}`);
    this.plot.setAttribute('height', kHeight);
    const frame = { x: kLeft, y: kTop, width: Math.max(0, this.#right - kLeft), height: this.#base - kTop };
    for (const rect of [this.back, this.clip]) for (const [name, value] of Object.entries(frame)) rect.setAttribute(name, value);
    this.bars.setAttribute('d', this.#barsPath());
    if (hasSurfaces(this.#fn)) this.#drawStems();
    else this.#drawCurve();
    this.#drawAxes();
    this.#drawWindow();
    this.#drawPoints();
    this.#fillFields();
  }

  #drawCurve() {
    const path = this.#curvePoints().map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join('L');
    this.curve.setAttribute('d', `M${path}`);
    this.area.setAttribute('d', `M${kLeft} ${this.#base}L${path}L${this.#right} ${this.#base}Z`);
    this.#drawColors();
  }

  // A surface has one value: a line up to the surface's opacity.
  #drawStems() {
    this.curve.setAttribute('d', this.#items.map(({ value, opacity }) => `M${this.#x(value).toFixed(1)} ${this.#base}V${this.#y(opacity).toFixed(1)}`).join(''));
    this.area.setAttribute('d', '');
    this.band.setAttribute('width', 0);
  }

  #barsPath() {
    const { counts, low, high } = this.#histogram;
    const most = Math.log1p(Math.max(...counts));
    if (!(most > 0)) return '';
    const width = (high - low) / counts.length;
    const steps = counts.map((count, bin) => {
      const y = (this.#base - (Math.log1p(count) / most) * (this.#base - kTop)).toFixed(1);
      return `L${this.#x(low + bin * width).toFixed(1)} ${y}L${this.#x(low + (bin + 1) * width).toFixed(1)} ${y}`;
    });
    return `M${this.#x(low).toFixed(1)} ${this.#base}${steps.join('')}L${this.#x(high).toFixed(1)} ${this.#base}Z`;
  }

  // Points of the curve are exact; between them, the square root needs steps.
  #curvePoints() {
    const values = Array.from({ length: kCurveSteps + 1 }, (_, i) => this.#view[0] + (i / kCurveSteps) * (this.#view[1] - this.#view[0]));
    const inside = this.#items.filter((p) => p.value > this.#view[0] && p.value < this.#view[1]);
    const all = [...values.map((value) => [value, at(this.#fn, value).opacity]), ...inside.map((p) => [p.value, p.opacity])];
    all.sort((a, b) => a[0] - b[0]);
    return all.map(([value, opacity]) => [this.#x(value), this.#y(opacity)]);
  }

  #drawColors() {
    this.gradientStops.setAttribute('x1', kLeft);
    this.gradientStops.setAttribute('x2', this.#right);
    const values = Array.from({ length: 97 }, (_, i) => this.#view[0] + (i / 96) * (this.#view[1] - this.#view[0]));
    replace(this.gradientStops, values.map((value, i) => svg('stop', { offset: i / 96, 'stop-color': hexOfLinear(at(this.#fn, value).color) })));
    for (const [name, value] of Object.entries({ x: kLeft, y: this.#base + 1, width: this.#right - kLeft, height: 8 })) this.band.setAttribute(name, value);
  }

  #drawAxes() {
    const text = (x, y, anchor, content) => svg('text', { x, y, 'text-anchor': anchor }, content);
    const sides = kOpacityTicks.map((opacity) => [
      svg('line', { x1: kLeft, x2: this.#right, y1: this.#y(opacity), y2: this.#y(opacity) }),
      text(kLeft - 4, this.#y(opacity) + 3.5, 'end', String(opacity)),
    ]);
    const bottom = ticks(this.#view[0], this.#view[1], Math.max(2, Math.floor(this.#width / 75)))
      .map((value) => text(clamp(this.#x(value), kLeft + 8, this.#right - 8), this.#base + 21, 'middle', short(value)));
    replace(this.axes, sides, bottom);
  }

  #window() {
    const [first, last] = rangeOf(this.#fn);
    return [(first + last) / 2, last - first];
  }

  #drawWindow() {
    if (hasSurfaces(this.#fn)) {
      replace(this.windowBar);
      return;
    }
    const [first, last] = rangeOf(this.#fn);
    const y = this.#base + 34;
    const [x0, x1] = [first, last].map((value) => clamp(this.#x(value), kLeft, this.#right));
    const body = svg('rect', { x: x0, y: y - 4, width: Math.max(2, x1 - x0), height: 8, rx: 2, class: 'window-body' }, svg('title', {}, 'Drag to move the window of values'));
    body.addEventListener('pointerdown', (event) => this.#dragWindow(event, (by) => [first + by, last + by]));
    const end = (value, x, name, moved) => {
      const node = svg('rect', { x: x - 4, y: y - 8, width: 8, height: 16, rx: 2, class: 'window-end', tabindex: 0, role: 'slider', 'aria-label': name,
        'aria-valuenow': value, 'aria-valuetext': `value ${short(value)}` });
      node.addEventListener('pointerdown', (event) => this.#dragWindow(event, moved));
      node.addEventListener('keydown', (event) => {
        const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
        if (!step) return;
        event.preventDefault();
        this.#takeWindow(moved((step * (this.#view[1] - this.#view[0])) / (event.shiftKey ? 20 : 200)), `window-key-${name}`);
        this.windowBar.querySelector(`[aria-label="${name}"]`)?.focus();
      });
      return node;
    };
    const track = svg('line', { x1: kLeft, x2: this.#right, y1: y, y2: y, class: 'window-track' });
    replace(this.windowBar, track, body, end(first, x0, 'Start of the window', (by) => [first + by, last]), end(last, x1, 'End of the window', (by) => [first, last + by]));
  }

  #takeWindow([low, high], key) {
    if (high > low) this.#editWindow([(low + high) / 2, high - low], key);
  }

  #editWindow([centre, width], key) { this.#onWindow([this.#tidyFine(centre), this.#tidyFine(width)], key); }
  #tidyFine(value) { return Number(value.toPrecision(6)); }

  // The plot keeps its children while a pointer is captured; new windows are drawn after the release.
  #dragWindow(down, moved) {
    down.preventDefault();
    const start = this.#valueAt(this.#place(down).x);
    const key = `window-${++this.#gesture}`;
    this.#followOnPlot(down, (event) => this.#takeWindow(moved(this.#valueAt(this.#place(event).x) - start), key));
  }

  #followOnPlot(down, onMove) {
    const view = this.#view;
    follow({ currentTarget: this.plot, pointerId: down.pointerId }, (event) => { this.#view = view; onMove(event); }, () => this.#onDone());
  }

  #drawPoints() {
    const points = this.#items;
    const focused = document.activeElement?.parentNode === this.points;
    const nodes = points.map((point, index) => {
      const [x, y] = [this.#x(point.value), this.#y(point.opacity)];
      if (x < kLeft - 1 || x > this.#right + 1) return null;
      const selected = index === this.#selected;
      const reachable = selected || points.length <= kManyPoints;
      const node = svg('circle', { cx: x.toFixed(2), cy: y.toFixed(2), r: points.length > kManyPoints && !selected ? 2.5 : kPointRadius,
        fill: hexOf(point.color, this.#fn.colorSpace), class: selected ? 'point selected' : 'point', tabindex: reachable ? 0 : undefined,
        role: 'slider', 'data-index': index, 'aria-label': `${this.#noun} ${index + 1} of ${points.length}`, 'aria-valuenow': point.value,
        'aria-valuetext': `value ${short(point.value)}, opacity ${short(point.opacity)}, colour ${hexOf(point.color, this.#fn.colorSpace)}` });
      node.addEventListener('pointerdown', (event) => this.#dragPoint(event, index));
      node.addEventListener('focus', () => { if (this.#selected !== index) this.#select(index); });
      node.addEventListener('keydown', (event) => this.#pointKey(event, index));
      return node;
    });
    replace(this.points, nodes);
    if (focused) this.points.querySelector(`[data-index="${this.#selected}"]`)?.focus();
  }

  #fillFields() {
    const points = this.#items, point = points[this.#selected];
    const isPoint = !hasSurfaces(this.#fn);
    this.name.textContent = this.#noun;
    this.add.textContent = `Add ${this.#noun.toLowerCase()}`;
    for (const node of this.ofPoints) node.hidden = !isPoint;
    this.value.set(point.value);
    this.opacity.set(point.opacity);
    this.color.set(hexOf(point.color, this.#fn.colorSpace));
    this.unit.set(this.#fn.unit);
    const [centre, width] = this.#window();
    this.centre.set(centre);
    this.breadth.set(width);
    this.count.textContent = `${this.#noun} ${this.#selected + 1} of ${points.length}`;
    this.previous.disabled = this.#selected === 0;
    this.next.disabled = this.#selected === points.length - 1;
    this.fewer.hidden = !isPoint || points.length <= 16;
    const factors = this.#fn.gradientOpacity ?? [];
    this.gradient.show(isPoint && !this.#fn.regions && !this.#fn.table ? factors : null);
  }

  #select(index) {
    this.#selected = clamp(index, 0, this.#items.length - 1);
    this.#draw();
  }

  #emit(fn, label, key = null) { this.#onFunction(fn, label, key && `function-${key}`); }

  #editPoint(changes, label) {
    this.#emit(withItem(this.#fn, this.#selected, changes), label, `${label}-${this.#selected}`);
  }

  #editFactors(factors, label, key) {
    const { gradientOpacity: _, ...rest } = this.#fn;
    this.#emit(factors.length > 0 ? { ...rest, gradientOpacity: factors } : rest, label, key);
  }

  #dragPoint(down, index) {
    if (down.button !== 0) return;
    down.preventDefault();
    this.#selected = index;
    this.#draw();
    this.points.querySelector(`[data-index="${index}"]`)?.focus();
    const start = this.#place(down), point = this.#items[index];
    const offset = { x: this.#x(point.value) - start.x, y: this.#y(point.opacity) - start.y };
    const key = `point-${++this.#gesture}`;
    this.#followOnPlot(down, (event) => {
      const here = this.#place(event);
      const across = Math.abs(here.x - start.x) >= Math.abs(here.y - start.y);
      const changes = {};
      if (!event.shiftKey || across) changes.value = this.#tidy(this.#valueAt(here.x + offset.x));
      if (!event.shiftKey || !across) changes.opacity = Number(this.#opacityAt(here.y + offset.y).toPrecision(3));
      this.#emit(withItem(this.#fn, index, changes), 'point', key);
    });
  }

  #pointKey(event, index) {
    const point = this.#items[index];
    const valueStep = (this.#view[1] - this.#view[0]) / (event.shiftKey ? 20 : 200);
    const rootStep = event.shiftKey ? 0.1 : 0.01;
    const raised = (by) => Number((clamp(Math.sqrt(point.opacity) + by, 0, 1) ** 2).toPrecision(3));
    const changes = {
      ArrowLeft: { value: this.#tidy(point.value - valueStep) }, ArrowRight: { value: this.#tidy(point.value + valueStep) },
      ArrowUp: { opacity: raised(rootStep) }, ArrowDown: { opacity: raised(-rootStep) },
    }[event.key];
    if (changes) this.#emit(withItem(this.#fn, index, changes), 'point', `key-${index}`);
    else if (event.key === 'Delete' || event.key === 'Backspace') this.#remove(index);
    else if (event.key === 'Insert') this.#addBeside();
    else if (event.key === 'PageUp') this.#select(index - 1);
    else if (event.key === 'PageDown') this.#select(index + 1);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  #addAt(event) {
    const { x, y } = this.#place(event);
    this.#add(this.#tidy(this.#valueAt(x)), Number(this.#opacityAt(y).toPrecision(3)));
  }

  // Between the selected point and the next; beyond the last point, a tenth of the view further.
  #addBeside() {
    const points = this.#items;
    const here = points[this.#selected], next = points[this.#selected + 1];
    const value = next ? (here.value + next.value) / 2 : here.value + (this.#view[1] - this.#view[0]) / 10;
    this.#add(this.#tidy(value), hasSurfaces(this.#fn) ? here.opacity : Number(at(this.#fn, value).opacity.toPrecision(3)));
  }

  #add(value, opacity) {
    const { fn, index } = withNewItem(this.#fn, value, opacity);
    this.#selected = index;
    this.#emit(fn, 'new point');
  }

  #remove(index) {
    const fn = withoutItem(this.#fn, index);
    this.#selected = clamp(index - (index === this.#items.length - 1 ? 1 : 0), 0, itemsOf(fn).length - 1);
    if (fn !== this.#fn) this.#emit(fn, 'removed point');
  }

  #panView(down) {
    if (down.button !== 0) return;
    const start = this.#place(down).x, [low, high] = this.#view;
    const perPixel = (high - low) / (this.#right - kLeft);
    follow({ currentTarget: this.plot, pointerId: down.pointerId }, (event) => {
      const by = clamp(-(this.#place(event).x - start) * perPixel, Math.min(0, this.#whole[0] - low), Math.max(0, this.#whole[1] - high));
      this.#view = [low + by, high + by];
      this.#draw();
    });
  }

  #zoomView(event) {
    event.preventDefault();
    const middle = this.#valueAt(clamp(this.#place(event).x, kLeft, this.#right));
    const factor = 2 ** (event.deltaY / 400);
    const least = (this.#whole[1] - this.#whole[0]) / 1e4;
    let [low, high] = this.#view.map((v) => middle + (v - middle) * factor);
    if (high - low < least) return;
    low = Math.max(low, this.#whole[0]);
    high = Math.min(high, this.#whole[1]);
    this.#view = [low, high];
    this.#draw();
  }
}
