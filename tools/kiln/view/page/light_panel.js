// Mode, look, exposure, shading, shadows, occlusion and lights.
import { button, check, choice, colorField, html, numberField, replace } from './element.js';
import { hexOf } from './color.js';
import { hasSeveralVolumes, volumeOf, withKeys, withPart, withVolume } from './job.js';

const kModes = { composite: 'light of the volume', mip: 'greatest value (MIP)', minip: 'least value (MinIP)', average: 'mean value' };
const kLights = { headlight: 'at the eye', camera: 'far, with the camera', directional: 'far, in the world', point: 'near, in the world' };

export function lightPanel(app) {
  const { state } = app;
  const done = () => state.endGesture();

  // The values that a look stands for come from the server.
  const look = (job) => app.session.looks[job.look ?? 'plain'];
  let scope = 'all'; // shading of all volumes, or of the active volume
  const isCommon = () => !hasSeveralVolumes(state.job) || scope === 'all';
  const commonShading = (job) => ({ ...look(job).shading, ...job.shading });
  // A volume's shading has the picture's values where it states none.
  const shadingOf = (job) => (isCommon() ? commonShading(job) : { ...commonShading(job), ...volumeOf(job, app.active).shading });
  const occlusionOf = (job) => {
    const given = shadingOf(job).ambientOcclusion ?? { strength: 0 };
    return typeof given === 'number' ? { strength: given } : given;
  };
  const lightsOf = (job) => (Array.isArray(job.lights) ? job.lights : job.lights ? [] : look(job).lights);

  const setShading = (keys, label) => state.change(label, (job) => (isCommon() ? withPart(job, 'shading', keys)
    : withVolume(job, app.active, { shading: withKeys(shadingOf(job), keys) })), { merge: `shading-${label}` });
  // Shadows and occlusion are the picture's; a volume's own shading has a copy.
  const setCommon = (job, keys) => {
    const out = withPart(job, 'shading', keys);
    return hasSeveralVolumes(out) ? { ...out, volumes: out.volumes.map((volume) => (volume.shading ? withPart(volume, 'shading', keys) : volume)) } : out;
  };
  const scopeChoice = choice({ name: 'Shading of', options: { all: 'all volumes', one: 'this volume' }, onInput: (value) => { scope = value; update(state.job); } });
  const asOthers = button('As the others', () => state.change('shading of a volume', (job) => withVolume(job, app.active, { shading: undefined })), { class: 'small' });
  const asOthersRow = html('div', { class: 'row' }, html('span', { class: 'dim' }, 'This volume has a shading of its own.'), asOthers);
  const slider = (key, name, max, step, unit = '') => numberField({ name, unit, min: 0, max: key === 'power' ? 1e4 : 1000, slider: { min: 0, max, step }, step,
    onInput: (value) => setShading({ [key]: value }, name.toLowerCase()), onDone: done });

  const mode = choice({ name: 'Mode', options: kModes, onInput: (value) => state.change('mode', (job) => withKeys(job, { mode: value === 'composite' ? undefined : value })) });
  const lookChoice = choice({ name: 'Look', options: { plain: 'plain', studio: 'studio' },
    onInput: (value) => state.change('look', (job) => {
      const cleared = withPart(withKeys(job, { shading: undefined, lights: undefined }), 'display', { tone: undefined });
      return withKeys(cleared, { look: value === 'plain' ? undefined : value });
    }) });
  const exposure = numberField({ name: 'Exposure', unit: 'stops', min: -20, max: 20, step: 0.1, slider: { min: -4, max: 4, step: 0.1 },
    onInput: (value) => state.change('exposure', (job) => withPart(job, 'display', { exposure: value === 0 ? undefined : value }), { merge: 'exposure' }), onDone: done });
  const tone = choice({ name: 'Tone', options: { clip: 'clip at white', soft: 'soft, keeps hues' },
    onInput: (value) => state.change('tone', (job) => withPart(job, 'display', { tone: value })) });
  const shaded = check({ name: 'Shaded by lights', onInput: (on) => setShading({ model: on ? 'phong' : 'none' }, 'shading') });
  const ambient = slider('ambient', 'Ambient', 1, 0.01, '×'), diffuse = slider('diffuse', 'Diffuse', 1.5, 0.01, '×');
  const specular = slider('specular', 'Highlights', 1, 0.01, '×'), power = slider('power', 'Sharpness', 128, 1, 'power');
  const shadows = check({ name: 'All lights cast shadows', onInput: (on) => state.change('shadows', (job) => setCommon(job, { shadows: on || undefined })) });
  const setOcclusion = (keys, label) => state.change(label, (job) => {
    const next = Object.fromEntries(Object.entries({ ...occlusionOf(job), ...keys }).filter(([, v]) => v !== undefined && v !== ''));
    return setCommon(job, { ambientOcclusion: next });
  }, { merge: label });
  const occlusion = numberField({ name: 'Occlusion', unit: '×', label: 'Ambient occlusion', min: 0, max: 1, step: 0.05, slider: { min: 0, max: 1, step: 0.05 },
    onInput: (strength) => setOcclusion({ strength }, 'ambient occlusion'), onDone: done });
  const radius = numberField({ name: 'Radius', unit: app.lengthUnit(), label: 'Radius of ambient occlusion, 0 for a tenth of the longest edge', min: 0, step: 1,
    onInput: (value) => setOcclusion({ radius: value || undefined }, 'radius of occlusion'), onDone: done });
  const occludes = choice({ name: 'Occludes', options: { ambient: 'ambient light', all: 'ambient and diffuse light' }, onInput: (value) => setOcclusion({ occludes: value }, 'occluded light') });

  // Lights.
  const list = html('ul', { class: 'lights', 'aria-label': 'Lights' });
  const note = html('p', { class: 'dim' }, 'The lights have key frames; a new light replaces them.');
  let rows = [];
  const setLights = (edit, label, merge = null) => state.change(label, (job) => withKeys(job, { lights: edit(lightsOf(job)) }), { merge });
  const setLight = (index, keys, label, merge = null) => setLights((lights) => lights.map((light, i) => (i === index ? withKeys(light, keys) : light)), label, merge);
  const placeKey = (type) => (type === 'point' ? 'position' : 'direction');
  const changeType = (index, type) => setLights((lights) => lights.map((light, i) => {
    if (i !== index) return light;
    const { direction: _d, position: _p, ...rest } = light;
    if (type === 'headlight') { const { shadow: _s, ...plain } = rest; return { ...plain, type }; }
    return { ...rest, type, [placeKey(type)]: type === 'point' ? app.camera()?.eye.map((n) => Number(n.toPrecision(5))) ?? [0, 0, 0] : type === 'camera' ? [-1, 1, 1] : [0, -1, 1] };
  }), 'kind of a light');

  function newRow(index, type) {
    const name = `Light ${index + 1}`;
    const kind = choice({ name: null, label: `Kind of light ${index + 1}`, options: kLights, onInput: (value) => changeType(index, value) });
    const color = colorField({ label: `Colour of light ${index + 1}`, onInput: (hex) => setLight(index, { color: hex }, 'colour of a light', `light-color-${index}`), onDone: done });
    const intensity = numberField({ name: null, unit: '×', label: `Intensity of light ${index + 1}`, min: 0, max: 1e6, step: 0.05,
      onInput: (value) => setLight(index, { intensity: value }, 'intensity of a light', `light-intensity-${index}`), onDone: done });
    const axes = type === 'camera' ? ['right', 'up', 'towards the eye'] : ['x', 'y', 'z'];
    const place = axes.map((axis, i) => numberField({ name: null, label: `Light ${index + 1}, ${placeKey(type)} ${axis}`, step: type === 'point' ? 10 : 0.1,
      onInput: (value) => {
        const key = placeKey(type);
        const next = lightsOf(state.job)[index][key].map((n, a) => (a === i ? value : n));
        if (type === 'point' || next.some((n) => n !== 0)) setLight(index, { [key]: next }, 'place of a light', `light-place-${index}-${i}`);
      }, onDone: done }));
    const shadowOf = (light) => (typeof light.shadow === 'object' ? light.shadow : {});
    const shadow = check({ name: 'Shadow', onInput: (on) => setLight(index, { shadow: on ? true : undefined }, 'shadow of a light') });
    const softness = numberField({ name: null, unit: '° soft', spokenUnit: 'degrees', label: `Softness of the shadow of light ${index + 1}`, min: 0, max: 45, step: 0.5,
      onInput: (value) => setLight(index, { shadow: { ...shadowOf(lightsOf(state.job)[index]), softness: value } }, 'softness of a shadow', `light-soft-${index}`), onDone: done });
    const far = type !== 'headlight';
    const node = html('li', {},
      html('div', { class: 'row' }, html('span', { class: 'name' }, name), html('span', { class: 'controls' }, kind.node,
        button('Remove', () => setLights((lights) => lights.filter((_, i) => i !== index), 'removed light'), { class: 'small', 'aria-label': `Remove light ${index + 1}` }))),
      html('div', { class: 'row' }, html('span', { class: 'name' }, 'Colour'), html('span', { class: 'controls' }, color.node, intensity.node)),
      far ? html('div', { class: 'row' }, html('span', { class: 'name' }, type === 'point' ? `Position, ${app.lengthUnit()}` : 'Direction'), html('span', { class: 'controls three' }, place.map((p) => p.node))) : null,
      far ? html('div', { class: 'row' }, shadow.node, html('span', { class: 'controls' }, softness.node)) : null);
    return { node, type, kind, color, intensity, place, shadow, softness };
  }

  function showLights(job) {
    const lights = lightsOf(job);
    if (rows.length !== lights.length || rows.some((r, i) => r.type !== lights[i].type)) {
      rows = lights.map((light, index) => newRow(index, light.type));
      replace(list, rows.map((r) => r.node));
    }
    lights.forEach((light, index) => {
      const r = rows[index];
      r.kind.set(light.type);
      r.color.set(hexOf(light.color ?? [1, 1, 1], 'linear'));
      r.intensity.set(light.intensity ?? 1);
      (light[placeKey(light.type)] ?? []).forEach((n, axis) => r.place[axis].set(n));
      r.shadow.set(Boolean(light.shadow) && light.shadow.casts !== false);
      r.softness.set(light.shadow?.softness ?? 0);
      r.softness.disable(!light.shadow);
    });
    note.hidden = !job.lights?.keyframes;
  }

  const common = html('div', {}, html('h3', {}, 'Shadows and occlusion'), shadows.node, occlusion.node, radius.node, occludes.node);
  const composite = html('div', {}, lookChoice.node, exposure.node, tone.node, scopeChoice.node, asOthersRow, shaded.node, ambient.node, diffuse.node, specular.node, power.node, common,
    html('h3', {}, 'Lights'), note, list, html('div', { class: 'row' }, button('Add light', () => setLights((lights) => [...lights, { type: 'camera', direction: [-1, 1, 1] }], 'new light'), { class: 'small' })));

  function update(job) {
    const shading = shadingOf(job);
    const around = occlusionOf(job);
    mode.set(job.mode ?? 'composite');
    scopeChoice.node.hidden = !hasSeveralVolumes(job);
    scopeChoice.set(scope);
    asOthersRow.hidden = isCommon() || !volumeOf(job, app.active).shading;
    common.hidden = !isCommon();
    composite.hidden = (job.mode ?? 'composite') !== 'composite';
    lookChoice.set(job.look ?? 'plain');
    exposure.set(job.display?.exposure ?? 0);
    tone.set(job.display?.tone ?? look(job).display.tone);
    shaded.set((shading.model ?? 'phong') === 'phong');
    for (const [field, value] of [[ambient, shading.ambient], [diffuse, shading.diffuse], [specular, shading.specular], [power, shading.power]]) field.set(value ?? null);
    shadows.set(shading.shadows === true);
    occlusion.set(around.strength ?? null);
    radius.set(around.radius ?? 0);
    occludes.set(around.occludes ?? 'ambient');
    radius.node.hidden = occludes.node.hidden = !(around.strength > 0);
    showLights(job);
  }
  return { node: html('div', {}, mode.node, composite), update };
}
