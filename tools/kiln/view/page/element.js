// Short constructors of HTML and SVG elements, and the controls that all panels share.

const kSvg = 'http://www.w3.org/2000/svg';

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (name === 'value' || name === 'checked') node[name] = value;
    else node.setAttribute(name, value === true ? '' : value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return node;
}

/** Returns an element. Attributes that begin with "on" are listeners. */
export const html = (tag, attributes, ...children) => fill(document.createElement(tag), attributes, children);
export const svg = (tag, attributes, ...children) => fill(document.createElementNS(kSvg, tag), attributes, children);
export const byId = (id) => document.getElementById(id);

/** Returns an icon of 16 pixels, drawn by a path. */
export const icon = (path) => svg('svg', { class: 'icon', viewBox: '0 0 16 16', 'aria-hidden': 'true' }, svg('path', { d: path }));

export const button = (text, onclick, attributes = {}) => html('button', { type: 'button', onclick, ...attributes }, text);

let lastId = 0;
export const newId = (prefix) => `${prefix}-${++lastId}`;

/** A row of a panel: a name, a control, and notes after it. */
export const row = (name, ...controls) => html('div', { class: 'row' }, html('span', { class: 'name' }, name), html('span', { class: 'controls' }, ...controls));

/**
 * A number with a name and a unit, and a slider if `slider` is {min, max, step}. `onInput(value)` is called while the
 * number changes, or once at its end if `late`; `onDone()` at the end of a change. `set(value)` shows a value; null shows
 * an empty field. A text that is being typed stays as it is. `spokenUnit` is the unit for screen readers.
 */
export function numberField({ name, unit = '', spokenUnit = unit, label = name, min, max, step = 'any', digits = 5, slider = null, late = false, onInput, onDone = () => {} }) {
  const input = html('input', { type: 'number', min, max, step, 'aria-label': spokenUnit ? `${label}, ${spokenUnit}` : label, class: 'number', inputmode: 'decimal' });
  const range = slider && html('input', { type: 'range', min: slider.min, max: slider.max, step: slider.step, 'aria-label': `${label}, slider`, tabindex: '-1' });
  const clamped = (value) => Math.min(max ?? Infinity, Math.max(min ?? -Infinity, value));
  const take = (source) => {
    const value = source.valueAsNumber;
    if (!Number.isFinite(value)) return;
    const allowed = source === range || clamped(value) === value;
    input.setAttribute('aria-invalid', String(!allowed));
    if (allowed) onInput(value);
  };
  let shown = null;
  let typing = false;
  const show = (value) => {
    shown = value;
    if (range) range.value = value ?? slider.min;
    if (typing) return;
    input.value = value === null || value === undefined ? '' : String(Number(Number(value).toPrecision(digits)));
    input.setAttribute('aria-invalid', 'false');
  };
  const finish = () => {
    if (late && typing) take(input);
    typing = false;
    show(shown);
    onDone();
  };
  input.addEventListener('input', () => { typing = true; if (!late) take(input); });
  input.addEventListener('change', finish);
  input.addEventListener('blur', () => { typing = false; show(shown); });
  input.addEventListener('keydown', (event) => { if (event.ctrlKey || event.metaKey) typing = false; });
  range?.addEventListener('input', () => take(range));
  range?.addEventListener('change', onDone);
  const unitText = html('span', { class: 'unit' }, unit);
  const node = name === null
    ? html('span', { class: 'field' }, input, unitText)
    : html('div', { class: range ? 'row ranged' : 'row' }, html('span', { class: 'name', 'aria-hidden': 'true' }, name), html('span', { class: 'controls' }, range, input, unitText));
  return { node, input, set: show, setUnit: (text) => { unitText.textContent = text; input.setAttribute('aria-label', `${label}, ${text}`); },
    disable: (off) => { input.disabled = off; if (range) range.disabled = off; } };
}

/** A row with a list of choices, as {value: text}. */
export function choice({ name, label = name, options, onInput }) {
  const select = html('select', { 'aria-label': label, onchange: () => onInput(select.value) },
    Object.entries(options).map(([value, text]) => html('option', { value }, text)));
  const node = name === null ? select : html('div', { class: 'row' }, html('span', { class: 'name', 'aria-hidden': 'true' }, name), html('span', { class: 'controls' }, select));
  return { node, select, set: (value) => { select.value = value; } };
}

/** A row with a box to tick. */
export function check({ name, onInput }) {
  const input = html('input', { type: 'checkbox', onchange: () => onInput(input.checked) });
  return { node: html('label', { class: 'check' }, input, html('span', {}, name)), input, set: (on) => { input.checked = on; } };
}

/** A field of a colour, "#rrggbb". */
export function colorField({ label, onInput, onDone = () => {} }) {
  const input = html('input', { type: 'color', 'aria-label': label, oninput: () => onInput(input.value), onchange: onDone });
  return { node: input, input, set: (hex) => { input.value = hex; } };
}

/** Puts children in place of the present ones. */
export const replace = (node, ...children) => node.replaceChildren(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));

/** Follows a pointer from `down` to its release. `onMove(event)` is called for moves, `onEnd()` once. */
export function follow(down, onMove, onEnd = () => {}) {
  const target = down.currentTarget;
  target.setPointerCapture(down.pointerId);
  const move = (event) => { if (event.pointerId === down.pointerId) onMove(event); };
  const end = (event) => {
    if (event.pointerId !== down.pointerId) return;
    for (const [type, listener] of listeners) target.removeEventListener(type, listener);
    onEnd();
  };
  const listeners = [['pointermove', move], ['pointerup', end], ['pointercancel', end], ['lostpointercapture', end]];
  for (const [type, listener] of listeners) target.addEventListener(type, listener);
}
