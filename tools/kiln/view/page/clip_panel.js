// Numbers of the clip box of a volume and of the clip planes.
import { button, check, choice, html, numberField, replace } from './element.js';
import { wholeBox } from './box_geometry.js';
import { axesOf } from './camera.js';
import { hasSeveralVolumes, volumeOf, withKeys, withVolume } from './job.js';
import { dot, scale } from './vector.js';

const kAxes = ['x', 'y', 'z'];
const kSections = { off: 'none', tf: 'colours of the function', gray: 'grey values', viridis: 'viridis', plasma: 'plasma', inferno: 'inferno', 'cool-to-warm': 'cool to warm', fire: 'fire' };

export function clipPanel(app) {
  const { state } = app;
  let scope = 'all'; // planes of all volumes, or of the active volume
  const done = () => state.endGesture();

  const handles = check({ name: 'Handles on the picture', onInput: (on) => { app.showsHandles = on; app.redrawOverlay(); } });
  handles.set(true);
  const boxOn = check({ name: 'Clip box', onInput: (on) => setBox(on ? wholeBox(app.volume) : undefined, null) });
  const boxFields = kAxes.map((axis, i) => ['from', 'to'].map((end, side) => numberField({
    name: null, label: `Clip box ${axis} ${end}`, unit: side ? 'voxels' : 'to', spokenUnit: 'voxels', step: 1,
    onInput: (value) => {
      const next = [...(boxOf() ?? wholeBox(app.volume))];
      next[i + 3 * side] = Math.round(value);
      if (next[i] < next[i + 3]) setBox(next, `box-number-${i}-${side}`);
    },
    onDone: done,
  })));
  const boxRows = html('div', {}, kAxes.map((axis, i) => html('div', { class: 'row' }, html('span', { class: 'name' }, axis), html('span', { class: 'controls' }, boxFields[i].map((field) => field.node)))));
  const worldRegion = html('div', { class: 'row' }, html('span', { class: 'dim' }, 'The job also has a box of the world.'),
    button('Remove', () => state.change('box of the world', (job) => withKeys(withVolume(job, app.active, { worldRegion: undefined }), { worldRegion: undefined })), { class: 'small' }));

  const scopeChoice = choice({ name: 'Planes cut', options: { all: 'all volumes', one: 'this volume' }, onInput: (value) => { scope = value; update(state.job); app.redrawOverlay(); } });
  const list = html('ul', { class: 'planes', 'aria-label': 'Clip planes' });
  let rows = [];

  const boxOf = () => volumeOf(state.job, app.active).region ?? null;
  const setBox = (box, merge) => state.change('clip box', (job) => withVolume(app.withPresentCamera(job), app.active, { region: box }), { merge });
  const isCommon = () => !hasSeveralVolumes(state.job) || scope === 'all';
  const planesOf = (job) => {
    const clip = isCommon() ? job.clip : volumeOf(job, app.active).clip;
    return Array.isArray(clip) ? clip : [];
  };
  const setPlanes = (edit, label, merge = null) => state.change(label, (job) => {
    const planes = edit(planesOf(job));
    const clip = planes.length > 0 ? planes : undefined;
    const seen = app.withPresentCamera(job);
    return isCommon() ? withKeys(seen, { clip }) : withVolume(seen, app.active, { clip });
  }, { merge });
  const setPlane = (index, plane, merge) => setPlanes((planes) => planes.map((old, i) => (i === index ? tidy(plane) : old)), 'clip plane', merge);

  function addPlane(normal) {
    const { min, max } = app.session.box;
    const middle = [0, 1, 2].map((axis) => (min[axis] + max[axis]) / 2);
    setPlanes((planes) => [...planes, tidy({ normal, offset: -dot(normal, middle) })], 'new clip plane');
  }
  const facing = () => {
    const camera = app.camera();
    if (camera) addPlane(axesOf(camera).forward);
  };

  function newRow(index) {
    const numbers = [0, 1, 2].map((axis) => numberField({
      name: null, label: `Plane ${index + 1}, normal ${kAxes[axis]}`, step: 0.1, digits: 4,
      onInput: (value) => {
        const plane = planesOf(state.job)[index];
        const normal = plane.normal.map((n, i) => (i === axis ? value : n));
        if (normal.some((n) => n !== 0)) setPlane(index, { ...plane, normal }, `plane-number-${index}-${axis}`);
      },
      onDone: done,
    }));
    const offset = numberField({ name: null, label: `Plane ${index + 1}, offset`, unit: app.lengthUnit(), step: 1,
      onInput: (value) => setPlane(index, { ...planesOf(state.job)[index], offset: value }, `plane-offset-${index}`), onDone: done });
    const node = html('li', {},
      html('div', { class: 'row' }, html('span', { class: 'name' }, `Plane ${index + 1}`), html('span', { class: 'controls' },
        button('Flip', () => setPlane(index, flipped(planesOf(state.job)[index]), null), { class: 'small', 'aria-label': `Flip plane ${index + 1}` }),
        button('Remove', () => setPlanes((planes) => planes.filter((_, i) => i !== index), 'removed clip plane'), { class: 'small', 'aria-label': `Remove plane ${index + 1}` }))),
      html('div', { class: 'row' }, html('span', { class: 'name' }, 'normal'), html('span', { class: 'controls three' }, numbers.map((n) => n.node))),
      html('div', { class: 'row' }, html('span', { class: 'name' }, 'offset'), html('span', { class: 'controls' }, offset.node)));
    return { node, numbers, offset };
  }

  // Cut faces of the active volume.
  const sectionOf = (job) => volumeOf(job, app.active).section ?? false;
  const sectionObject = (job) => (typeof sectionOf(job) === 'object' ? sectionOf(job) : {});
  const setSection = (section, label, merge = null) => state.change(label, (job) => withVolume(job, app.active, { section }), { merge });
  const editSection = (keys, label) => setSection({ ...sectionObject(state.job), ...keys }, label, label);
  const section = choice({ name: 'Cut faces', options: kSections, onInput: (value) => {
    const { opacity } = sectionObject(state.job);
    const kept = opacity === undefined ? {} : { opacity };
    if (value === 'off') setSection(undefined, 'cut faces');
    else if (value === 'tf') setSection(opacity === undefined ? true : kept, 'cut faces');
    else setSection({ ...kept, colormap: value }, 'cut faces');
  } });
  const windowOf = (job) => {
    const [low, high] = app.volume.range;
    return sectionObject(job).window ?? [(low + high) / 2, Math.max(high - low, 1e-6)];
  };
  const sectionWindow = ['centre', 'width'].map((end, place) => numberField({ name: null, label: `Window of the cut faces, ${end}`, unit: end, spokenUnit: 'value',
    onInput: (value) => {
      const window = windowOf(state.job).map((v, i) => (i === place ? value : v));
      if (window[1] > 0) editSection({ window }, 'window of cut faces');
    }, onDone: done }));
  const sectionOpacity = numberField({ name: 'Opacity', label: 'Opacity of the cut faces', min: 0, max: 1, step: 0.05, slider: { min: 0, max: 1, step: 0.05 },
    onInput: (opacity) => editSection({ opacity }, 'opacity of cut faces'), onDone: done });
  const sectionWindowRow = html('div', { class: 'row' }, html('span', { class: 'name' }, 'Values'), html('span', { class: 'controls' }, sectionWindow.map((field) => field.node)));

  function updateSection(job) {
    const given = sectionOf(job);
    // A window of labels means nothing.
    for (const option of section.select.options) option.hidden = app.volume.classes === 'labels' && !['off', 'tf'].includes(option.value);
    const colormap = sectionObject(job).colormap ?? (sectionObject(job).window ? 'gray' : null);
    section.set(given === false ? 'off' : colormap ?? 'tf');
    sectionWindowRow.hidden = given === false || colormap === null;
    sectionOpacity.node.hidden = given === false;
    sectionWindow.forEach((field, i) => field.set(sectionObject(job).window?.[i] ?? null));
    sectionOpacity.set(sectionObject(job).opacity ?? 1);
  }

  function update(job) {
    updateSection(job);
    const box = boxOf();
    boxOn.set(box !== null);
    boxRows.hidden = box === null;
    if (box) boxFields.forEach((pair, axis) => pair.forEach((field, side) => field.set(box[axis + 3 * side])));
    worldRegion.hidden = !job.worldRegion && !volumeOf(job, app.active).worldRegion;
    scopeChoice.node.hidden = !hasSeveralVolumes(job);
    scopeChoice.set(scope);
    const planes = planesOf(job);
    if (rows.length !== planes.length) {
      rows = planes.map((_, index) => newRow(index));
      replace(list, rows.map((each) => each.node));
    }
    planes.forEach((plane, index) => {
      plane.normal.forEach((n, axis) => rows[index].numbers[axis].set(n));
      rows[index].offset.set(plane.offset);
    });
    animated.hidden = !job.clip?.keyframes;
  }
  const animated = html('p', { class: 'dim' }, 'The planes have key frames; a new plane replaces them.');

  const node = html('div', {}, handles.node, boxOn.node, boxRows, worldRegion,
    html('div', { class: 'row wrap' }, html('span', { class: 'name' }, 'New plane'), html('span', { class: 'controls' },
      button('Facing', facing, { class: 'small', title: 'Cuts off the half towards the viewer' }),
      ...kAxes.map((axis, i) => button(axis, () => addPlane([0, 1, 2].map((a) => (a === i ? 1 : 0))), { class: 'small', 'aria-label': `New plane across ${axis}` })))),
    scopeChoice.node, animated, list, section.node, sectionWindowRow, sectionOpacity.node);
  return { node, update, boxOf, planesOf: () => planesOf(state.job), setBox, setPlane };
}

const flipped = (plane) => ({ normal: scale(plane.normal, -1).map((n) => n || 0), offset: -plane.offset || 0 });
const tidy = (plane) => ({ normal: plane.normal.map((n) => Number(n.toFixed(6)) || 0), offset: Number(plane.offset.toPrecision(9)) || 0 });
