// Key frames of the camera: a list of views with their frames, and a player. The server draws the frames between keys,
// so the player shows the motion of the batch.
import { button, choice, html, numberField, replace } from './element.js';
import { isAnimated, keyframesOf, withKeys, withoutMotion } from './job.js';
import { short } from './numbers.js';
import { rounded, withProjection } from './camera.js';

const kFirstStep = 50; // frames between new keys
const kEases = { smooth: 'smooth', linear: 'corner', stop: 'stop' };

/** Returns the camera of a key: its own numbers, the still camera's otherwise. */
const cameraOfKey = (key, still) => {
  const { frame: _f, ease: _e, ...own } = key;
  return { projection: still?.projection ?? 'perspective', ...own };
};

/** Returns the key with another projection; a key without a place of its own keeps its numbers. */
export function keyWithProjection(key, still, projection, radius) {
  const camera = cameraOfKey(key, still);
  const size = camera.projection === 'orthographic' ? camera.height : camera.fov;
  if (!camera.eye || !camera.target || !camera.up || size === undefined) return key;
  const { projection: _p, ...rest } = withProjection(camera, projection, radius);
  return { frame: key.frame, ...(key.ease ? { ease: key.ease } : {}), ...rest };
}

export function keyframesPanel(app) {
  const { state } = app;
  let rate = 25;
  let playing = null;
  const done = () => state.endGesture();
  const seconds = (frame) => `${short((frame - 1) / rate, 3)} s`;

  const list = html('ol', { class: 'keys', 'aria-label': 'Key frames' });
  let rows = [];
  const rateField = numberField({ name: 'Rate', unit: 'frames/s', min: 1, max: 120, step: 1, onInput: (value) => { rate = value; update(state.job); } });
  rateField.set(rate);
  const slider = html('input', { type: 'range', min: 1, max: 1, step: 1, 'aria-label': 'Frame', oninput: () => { stop(); app.showFrame(slider.valueAsNumber); } });
  const place = html('span', { class: 'unit frame-place' });
  const play = button('Play', () => (playing ? stop() : start()), {});
  const player = html('div', { class: 'row player' }, play, slider, place);

  const range = () => {
    const { camera = {} } = state.job;
    if (camera.turntable) return [1, camera.turntable.frames];
    if (camera.matrices) return [1, camera.matrices.length];
    const frames = [camera.keyframes, state.job.lights?.keyframes, state.job.clip?.keyframes, state.job.transferFunction?.keyframes,
      ...(state.job.volumes ?? []).map((v) => v.transferFunction?.keyframes)].flatMap((keys) => keys ?? []).map((key) => key.frame);
    return frames.length > 0 ? [Math.min(...frames), Math.max(...frames)] : [1, 1];
  };

  function start() {
    const [first, last] = range();
    if (last <= first) return;
    const from = app.frame < first || app.frame >= last ? first : app.frame;
    const begin = performance.now();
    play.textContent = 'Stop';
    const step = () => {
      const frame = Math.min(last, Math.floor(from + ((performance.now() - begin) / 1000) * rate));
      if (frame !== app.frame) app.showFrame(frame);
      if (frame >= last) stop();
      else playing = requestAnimationFrame(step);
    };
    playing = requestAnimationFrame(step);
  }
  function stop() {
    if (playing) cancelAnimationFrame(playing);
    playing = null;
    play.textContent = 'Play';
  }

  const setKeys = (edit, label, merge = null) => state.change(label, (job) => {
    const keys = edit(keyframesOf(job)).sort((a, b) => a.frame - b.frame);
    const { keyframes: _k, turntable: _t, matrices: _m, pivot, ...camera } = job.camera ?? {};
    return withKeys(job, { camera: keys.length > 0 ? { ...camera, keyframes: keys, ...(pivot ? { pivot } : {}) } : camera });
  }, { merge });

  const keyOf = (frame, ease) => {
    const { projection: _p, ...place_ } = rounded(app.camera());
    return { frame, ...(ease ? { ease } : {}), ...place_ };
  };

  function add() {
    if (!app.camera()) return;
    const keys = keyframesOf(state.job);
    const frame = keys.length > 0 ? Math.round(keys[keys.length - 1].frame) + kFirstStep : 1;
    // The still camera is written, too, because the keys are changes of it.
    if (!state.job.camera?.eye) app.moveCamera(app.camera(), 'first-key');
    setKeys((all) => [...all, keyOf(frame)], 'new key frame', 'first-key');
    done();
    app.announce(`Key frame ${frame}`);
  }

  function turntable() {
    state.change('turntable', (job) => {
      const { keyframes: _k, matrices: _m, pivot: _p, ...camera } = job.camera ?? {};
      return withKeys(job, { camera: { ...camera, turntable: { frames: 120, degrees: 360 } } });
    });
    app.showFrame(1);
  }

  function newRow(index) {
    const frame = numberField({ name: null, label: `Frame of key ${index + 1}`, min: 0, step: 1, late: true, onInput: (value) => {
      const others = keyframesOf(state.job).filter((_, i) => i !== index);
      if (!others.some((key) => key.frame === value)) setKeys((keys) => keys.map((key, i) => (i === index ? { ...key, frame: value } : key)), 'frame of a key', `key-${index}`);
    }, onDone: done });
    const time = html('span', { class: 'unit' });
    const ease = choice({ name: null, label: `Passage of key ${index + 1}`, options: kEases, onInput: (value) => setKeys((keys) => keys.map((key, i) => (i === index ? { ...key, ease: value } : key)), 'passage of a key') });
    const node = html('li', {},
      button('Go', () => { stop(); app.showFrame(Math.round(keyframesOf(state.job)[index].frame)); }, { class: 'small', 'aria-label': `Go to key ${index + 1}` }),
      frame.node, time, ease.node,
      button('Set', () => setKeys((keys) => keys.map((key, i) => (i === index ? keyOf(key.frame, key.ease) : key)), 'view of a key'), { class: 'small', 'aria-label': `Set key ${index + 1} to the present view`, title: 'Takes the present view' }),
      button('×', () => setKeys((keys) => keys.filter((_, i) => i !== index), 'removed key frame'), { class: 'small', 'aria-label': `Remove key ${index + 1}` }));
    return { node, frame, time, ease };
  }

  const turns = numberField({ name: 'Turntable', unit: 'frames', label: 'Frames of the turntable', min: 1, max: 100000, step: 1,
    onInput: (value) => state.change('turntable', (job) => withKeys(job, { camera: { ...job.camera, turntable: { ...job.camera.turntable, frames: Math.round(value) } } }), { merge: 'turntable' }), onDone: done });
  const still = button('Stand still', () => { app.leaveMotion(); state.change('no camera motion', withoutMotion); }, { class: 'small' });
  const turn = button('Turntable', turntable, { class: 'small', title: 'Turns the volume once in 120 frames' });
  const hint = html('p', { class: 'dim' }, 'Save two or more views; the batch draws all frames between them.');

  function update(job) {
    const keys = keyframesOf(job);
    if (rows.length !== keys.length) {
      rows = keys.map((_, index) => newRow(index));
      replace(list, rows.map((each) => each.node));
    }
    keys.forEach((key, index) => {
      rows[index].frame.set(key.frame);
      rows[index].time.textContent = seconds(key.frame);
      rows[index].ease.set(key.ease ?? 'smooth');
    });
    const [first, last] = range();
    player.hidden = !isAnimated(job) || last <= first;
    slider.min = first;
    slider.max = last;
    const frame = Math.max(first, Math.min(last, app.frame));
    slider.value = frame;
    place.textContent = `frame ${short(frame)} of ${short(last)}, ${seconds(frame)}`;
    slider.setAttribute('aria-valuetext', place.textContent);
    turns.node.hidden = !job.camera?.turntable;
    turns.set(job.camera?.turntable?.frames ?? null);
    still.hidden = !job.camera?.turntable && !job.camera?.matrices && keys.length === 0;
    turn.hidden = Boolean(job.camera?.turntable);
    hint.hidden = keys.length > 0;
    if (!isAnimated(job)) stop();
  }
  const node = html('div', {}, html('div', { class: 'row' }, button('Add this view', add, {}), html('span', { class: 'controls' }, turn, still)), hint, list, turns.node, player, rateField.node);
  return { node, update, stop };
}
