// Numbers of the camera, and of the picture: size, background, samples, quality.
import { button, check, choice, colorField, html, numberField } from './element.js';
import { hexOf } from './color.js';
import { rounded, withFov, withProjection } from './camera.js';
import { keyWithProjection } from './keyframes.js';
import { keyframesOf, withCamera, withKeys, withPart } from './job.js';
import { distance } from './vector.js';

const kAxes = ['x', 'y', 'z'];
const kSizes = { '': 'as the window', '1024x1024': '1024 × 1024', '1920x1080': '1920 × 1080', '3840x2160': '3840 × 2160', '2048x2048': '2048 × 2048', '4096x4096': '4096 × 4096', own: 'own size' };

export function cameraPanel(app) {
  const { state } = app;
  const done = () => state.endGesture();
  const move = (camera, merge = null) => app.moveCamera(camera, merge);
  const radius = () => distance(app.session.box.min, app.session.box.max) / 2;

  const projection = choice({ name: 'Projection', options: { perspective: 'perspective', orthographic: 'orthographic' }, onInput: (value) => {
    const camera = app.camera();
    if (!camera) return;
    // All keys have one projection, so key frames get the new projection, too.
    state.change('projection', (job) => {
      const changed = withProjection(camera, value, radius());
      const next = withCamera(job, rounded(changed));
      const keys = keyframesOf(job);
      if (keys.length > 0) next.camera.keyframes = keys.map((key) => keyWithProjection(key, job.camera, value, radius()));
      return next;
    });
  } });
  const fov = numberField({ name: 'Field of view', unit: '°', min: 1, max: 150, step: 1, slider: { min: 5, max: 120, step: 1 }, onInput: (value) => { const camera = app.camera(); if (camera) move(withFov(camera, value), 'fov'); }, onDone: done });
  const height = numberField({ name: 'Height', unit: app.lengthUnit(), label: 'Height of the picture', min: 0, onInput: (value) => { const camera = app.camera(); if (camera && value > 0) move({ ...camera, height: value }, 'height'); }, onDone: done });
  const triplet = (key, name, unit) => {
    const fields = kAxes.map((axis, i) => numberField({ name: null, label: `${name} ${axis}${unit ? `, ${unit}` : ''}`,
      onInput: (value) => {
        const camera = app.camera();
        if (!camera) return;
        const place = camera[key].map((n, a) => (a === i ? value : n));
        const next = { ...camera, [key]: place };
        if (distance(next.eye, next.target) > 0 && (key !== 'up' || place.some((n) => n !== 0))) move(next, `${key}-${i}`);
      }, onDone: done }));
    return { fields, node: html('div', { class: 'row' }, html('span', { class: 'name' }, unit ? `${name}, ${unit}` : name), html('span', { class: 'controls three' }, fields.map((f) => f.node))) };
  };
  const eye = triplet('eye', 'Eye', app.lengthUnit()), target = triplet('target', 'Target', app.lengthUnit()), up = triplet('up', 'Up', '');
  const toCross = button('Target at the crosshair', () => {
    const camera = app.camera(), cross = app.crossInWorld();
    if (camera && cross && distance(cross, camera.eye) > 0) move({ ...camera, target: cross });
  }, { class: 'small', title: 'Looks at the crosshair of the slices, and orbits about it' });
  const note = html('p', { class: 'dim' }, 'The volume is framed by the job until the first move.');

  function update(job) {
    const camera = app.camera();
    note.hidden = Boolean(job.camera?.eye);
    if (!camera) return;
    const parallel = camera.projection === 'orthographic';
    projection.set(camera.projection);
    fov.node.hidden = parallel;
    height.node.hidden = !parallel;
    fov.set(camera.fov ?? null);
    height.set(camera.height ?? null);
    for (const [part, key] of [[eye, 'eye'], [target, 'target'], [up, 'up']]) part.fields.forEach((field, axis) => field.set(camera[key][axis]));
  }
  return { node: html('div', {}, projection.node, fov.node, height.node, eye.node, target.node, up.node, html('div', { class: 'row' }, toCross), note), update };
}

export function imagePanel(app) {
  const { state } = app;
  const done = () => state.endGesture();
  const largest = app.session.largest;
  const setImage = (keys, label, merge = null) => state.change(label, (job) => withPart(job, 'image', keys), { merge });

  const size = choice({ name: 'Size', label: 'Size of the picture', options: kSizes, onInput: (value) => {
    if (value === 'own') { const [width, height] = app.batchSize(); setImage({ width, height }, 'size'); return; }
    const [width, height] = value ? value.split('x').map(Number) : [undefined, undefined];
    setImage({ width, height }, 'size');
  } });
  const side = (key) => numberField({ name: null, label: key === 'width' ? 'Width' : 'Height', unit: key === 'width' ? '×' : 'pixels', spokenUnit: 'pixels', min: 1, max: largest, step: 1, late: true,
    onInput: (value) => { const [width, height] = app.batchSize(); setImage({ width, height, [key]: Math.round(value) }, 'size', `size-${key}`); }, onDone: done });
  const width = side('width'), height = side('height');
  const exact = check({ name: 'Draw all its pixels here', onInput: (on) => { app.drawsBatchSize = on; app.pictureChanged(); } });

  const background = choice({ name: 'Background', options: { none: 'transparent', one: 'one colour', two: 'from top to bottom' }, onInput: (value) => {
    const [top, bottom] = colors(state.job);
    setImage({ background: value === 'none' ? undefined : value === 'one' ? top : { top, bottom } }, 'background');
  } });
  const colors = (job) => {
    const given = job.image?.background;
    if (!given || given === 'transparent') return ['#000000', '#404850'];
    const ends = given.top !== undefined ? [given.top, given.bottom] : [given, '#404850'];
    return ends.map((color) => hexOf(color, 'linear'));
  };
  const isClear = (given) => given === undefined || given === 'transparent' || (Array.isArray(given) && given[3] === 0);
  const setColor = (end) => (hex) => {
    const pair = colors(state.job);
    pair[end] = hex;
    setImage({ background: state.job.image?.background?.top !== undefined ? { top: pair[0], bottom: pair[1] } : pair[0] }, 'background', `background-${end}`);
  };
  const top = colorField({ label: 'Colour of the background, at the top', onInput: setColor(0), onDone: done });
  const bottom = colorField({ label: 'Colour of the background, at the bottom', onInput: setColor(1), onDone: done });
  background.select.after(top.node, bottom.node);

  const setKey = (key, fallback) => (value) => state.change(key, (job) => withKeys(job, { [key]: value === fallback ? undefined : /^\d+$/.test(value) ? Number(value) : value }));
  const quality = choice({ name: 'Quality', options: { '': 'good', draft: 'draft', best: 'best' }, onInput: setKey('quality', '') });
  const samples = choice({ name: 'Samples', options: { auto: 'automatic', 1: '1 ray a pixel', 2: '2 rays a pixel', 4: '4 rays a pixel', 16: '16 rays a pixel' }, onInput: setKey('samples', 'auto') });
  const interpolation = choice({ name: 'Interpolation', options: { linear: 'linear', cubic: 'cubic, smooth', 'catmull-rom': 'Catmull-Rom' }, onInput: setKey('interpolation', 'linear') });

  function update(job) {
    const { image = {} } = job;
    const name = image.width ? `${image.width}x${image.height}` : '';
    size.set(name in kSizes ? name : 'own');
    const [w, h] = app.batchSize();
    width.set(w);
    height.set(h);
    width.disable(!image.width);
    height.disable(!image.width);
    const large = w > largest || h > largest;
    exact.input.disabled = !image.width || large;
    exact.node.title = large ? `A picture here has at most ${largest} pixels a side` : '';
    const clear = isClear(image.background);
    background.set(clear ? 'none' : image.background.top !== undefined ? 'two' : 'one');
    top.node.hidden = clear;
    bottom.node.hidden = clear || image.background.top === undefined;
    const [a, b] = colors(job);
    top.set(a);
    bottom.set(b);
    quality.set(job.quality === 'good' ? '' : job.quality ?? '');
    samples.set(String(job.samples ?? 'auto'));
    interpolation.set(job.interpolation ?? 'linear');
  }
  return { node: html('div', {}, size.node, html('div', { class: 'row' }, html('span', { class: 'name' }, ''), html('span', { class: 'controls' }, width.node, height.node)), exact.node, background.node, quality.node, samples.node, interpolation.node), update };
}
