// The list of a label volume: an eye, a colour, a name and an opacity for each label.
import { hexOf } from './color.js';
import { button, colorField, html, icon, numberField, replace } from './element.js';
import { withLabel } from './transfer_function.js';

const kMostRows = 200;
const kOpenEye = 'M1 8c2-3.5 4.3-5 7-5s5 1.500 7 5c-2 3.500-4.300 5-7 5s-5-1.500-7-5zM8 5.500a2.500 2.500 0 1 0 0 5a2.500 2.500 0 1 0 0-5z';
const kClosedEye = 'M1 8c2-3.5 4.3-5 7-5s5 1.500 7 5c-2 3.500-4.300 5-7 5s-5-1.500-7-5zM2 14L14 2';

export class LabelList {
  #onFunction;
  #onDone;
  #fn = null;
  #names = new Map();
  #before = new Map(); // opacity of a label before its eye was closed
  #rows = new Map();

  constructor({ onFunction, onDone }) {
    this.#onFunction = onFunction;
    this.#onDone = onDone;
    this.filter = html('input', { type: 'search', placeholder: 'Name or number', 'aria-label': 'Labels whose name or number has', oninput: () => this.#build() });
    this.list = html('ul', { class: 'labels', 'aria-label': 'Labels' });
    this.note = html('p', { class: 'dim' });
    this.unit = numberField({ name: 'Opacity per', label: 'Opacity is per this length', min: 0, onInput: (unit) => { if (unit > 0) this.#emit({ ...this.#fn, unit }, 'unit of opacity', 'unit'); }, onDone });
    this.node = html('div', { class: 'label-list' },
      html('div', { class: 'row' }, this.filter, button('Show all', () => this.#all(true), { class: 'small' }), button('Hide all', () => this.#all(false), { class: 'small' })),
      this.list, this.note, this.unit.node);
  }

  /** Shows a function with labels. `labels` are the volume's, with names. */
  show({ fn, labels, lengthUnit }) {
    this.#fn = fn;
    this.#names = new Map(labels.map((label) => [label.value, label.name]));
    this.unit.setUnit(lengthUnit);
    this.unit.set(fn.unit);
    this.#build();
  }

  #nameOf(style) { return style.name || this.#names.get(style.label) || `Label ${style.label}`; }

  #build() {
    const wanted = this.filter.value.trim().toLowerCase();
    const all = this.#fn.labels.filter((style) => !wanted || String(style.label) === wanted || this.#nameOf(style).toLowerCase().includes(wanted));
    const shown = all.slice(0, kMostRows);
    const labels = new Set(shown.map((style) => style.label));
    for (const label of [...this.#rows.keys()]) if (!labels.has(label)) this.#rows.delete(label);
    for (const style of shown) {
      if (!this.#rows.has(style.label)) this.#rows.set(style.label, this.#newRow(style));
      this.#fillRow(this.#rows.get(style.label), style);
    }
    const nodes = shown.map((style) => this.#rows.get(style.label).node);
    if (nodes.length !== this.list.children.length || nodes.some((node, i) => this.list.children[i] !== node)) replace(this.list, nodes);
    this.note.textContent = all.length > shown.length ? `${shown.length} of ${all.length} labels are listed; write a name to find others.` : '';
    this.note.hidden = all.length <= shown.length;
  }

  #newRow(style) {
    const { label } = style;
    const name = this.#nameOf(style);
    const change = (changes, what) => this.#emit(withLabel(this.#fn, label, changes), `${what} of ${name}`, `${what}-${label}`);
    const eye = button('', () => this.#toggle(label), { class: 'eye small' });
    const color = colorField({ label: `Colour of ${name}`, onInput: (hex) => change({ color: hex }, 'colour'), onDone: this.#onDone });
    const opacity = numberField({ name: null, label: `Opacity of ${name}`, min: 0, max: 1, step: 0.05, onInput: (value) => change({ opacity: value }, 'opacity'), onDone: this.#onDone });
    const only = button('Only', () => this.#only(label), { class: 'small', 'aria-label': `Show only ${name}` });
    const text = html('span', { class: 'label-name', title: name }, name);
    const node = html('li', {}, eye, color.node, text, html('span', { class: 'dim number-of-label' }, String(label)), opacity.node, only);
    return { node, eye, color, opacity, text };
  }

  #fillRow(rowParts, style) {
    const visible = (style.opacity ?? 1) > 0;
    const name = this.#nameOf(style);
    replace(rowParts.eye, icon(visible ? kOpenEye : kClosedEye));
    rowParts.eye.setAttribute('aria-pressed', String(visible));
    rowParts.eye.setAttribute('aria-label', `Show ${name}`);
    rowParts.color.set(hexOf(style.color, this.#fn.colorSpace));
    rowParts.opacity.set(style.opacity ?? 1);
    rowParts.node.classList.toggle('hidden-label', !visible);
  }

  #emit(fn, label, key = null) { this.#onFunction(fn, label, key && `label-${key}`); }

  #opened(style) { return { ...style, opacity: this.#before.get(style.label) ?? 1 }; }
  #closed(style) {
    if ((style.opacity ?? 1) > 0) this.#before.set(style.label, style.opacity ?? 1);
    return { ...style, opacity: 0 };
  }
  #styled(style, visible) {
    if (visible === (style.opacity ?? 1) > 0) return style;
    return visible ? this.#opened(style) : this.#closed(style);
  }

  #toggle(label) {
    const labels = this.#fn.labels.map((style) => (style.label === label ? this.#styled(style, !((style.opacity ?? 1) > 0)) : style));
    this.#emit({ ...this.#fn, labels }, 'eye of a label');
  }
  #all(visible) { this.#emit({ ...this.#fn, labels: this.#fn.labels.map((style) => this.#styled(style, visible)) }, visible ? 'show all labels' : 'hide all labels'); }
  #only(label) { this.#emit({ ...this.#fn, labels: this.#fn.labels.map((style) => this.#styled(style, style.label === label)) }, 'show one label'); }
}
