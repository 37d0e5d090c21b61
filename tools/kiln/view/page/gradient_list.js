// Gradient opacity: factors of the opacity by the length of the gradient, even between points and constant beyond.
import { button, html, numberField, replace } from './element.js';

const kFirstFactors = [0, 1];
const kFirstShares = [0.02, 0.1]; // of the range of values within a unit of length

export class GradientList {
  #onFactors;
  #onDone;
  #factors = [];
  #lengthUnit = '';
  #steepest = 1;
  #rows = [];

  /** onFactors(factors, label, mergeKey); onDone() at the end of a change. */
  constructor({ onFactors, onDone }) {
    this.#onFactors = onFactors;
    this.#onDone = onDone;
    this.list = html('ul', { class: 'gradient-list', 'aria-label': 'Gradient opacity' });
    this.add = button('Add', () => this.#add(), { class: 'small', 'aria-label': 'Add a point of gradient opacity' });
    this.node = html('div', { class: 'gradient-opacity' },
      html('div', { class: 'row' }, html('span', { class: 'name' }, 'Gradient opacity'), html('span', { class: 'controls' }, this.add)), this.list);
  }

  /** `steepest`: the range of values within a unit of length. */
  describe(lengthUnit, steepest) {
    this.#lengthUnit = lengthUnit;
    this.#steepest = steepest > 0 ? steepest : 1;
  }

  /** Shows the points; null hides all, for functions that have no gradient opacity. */
  show(factors) {
    this.node.hidden = factors === null;
    this.#factors = factors ?? [];
    if (this.#rows.length !== this.#factors.length) {
      this.#rows = this.#factors.map((_, index) => this.#newRow(index));
      replace(this.list, this.#rows.map((row) => row.node));
    }
    this.#factors.forEach(({ gradient, factor }, index) => {
      this.#rows[index].gradient.set(gradient);
      this.#rows[index].factor.set(factor);
    });
  }

  #newRow(index) {
    const name = `Gradient ${index + 1}`;
    const field = (options) => numberField({ name: null, min: 0, onDone: this.#onDone, ...options });
    const gradient = field({ label: name, unit: `per ${this.#lengthUnit}`, late: true, onInput: (value) => this.#edit(index, { gradient: value }) });
    const factor = field({ label: `Factor of the opacity at gradient ${index + 1}`, unit: '×', max: 1, step: 0.05, onInput: (value) => this.#edit(index, { factor: value }) });
    const remove = button('Remove', () => this.#emit(this.#factors.filter((_, i) => i !== index), 'removed gradient'), { class: 'small', 'aria-label': `Remove gradient ${index + 1}` });
    return { node: html('li', { class: 'row' }, html('span', { class: 'controls' }, gradient.node, factor.node, remove)), gradient, factor };
  }

  #edit(index, changes) {
    const factors = this.#factors.map((point, i) => (i === index ? { ...point, ...changes } : point));
    this.#emit(factors.sort((a, b) => a.gradient - b.gradient), 'gradient opacity', `gradient-${index}`);
  }

  // The first two points leave out flat regions.
  #add() {
    const last = this.#factors.at(-1);
    const tidy = (gradient) => Number(gradient.toPrecision(2));
    const added = last ? [{ gradient: tidy(1.5 * last.gradient) || 1, factor: last.factor }]
      : kFirstFactors.map((factor, i) => ({ gradient: tidy(kFirstShares[i] * this.#steepest), factor }));
    this.#emit([...this.#factors, ...added], 'new gradient');
  }

  #emit(factors, label, key = null) { this.#onFactors(factors, label, key); }
}
