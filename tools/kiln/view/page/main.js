// The page: connects the job's state with the picture, the panels and the server.
import { byId, button, html, numberField, replace } from './element.js';
import { Server, ServerError, tokenOfPage } from './protocol.js';
import { JobState } from './state.js';
import { Picture } from './picture.js';
import { kSides, navigate } from './navigation.js';
import { Overlay } from './overlay.js';
import { axisNames } from './orientation.js';
import { ClipHandles } from './clip_handles.js';
import { wholeBox } from './box_geometry.js';
import { FunctionEditor } from './function_editor.js';
import { LabelList } from './label_list.js';
import { Presets } from './presets.js';
import { clipPanel } from './clip_panel.js';
import { lightPanel } from './light_panel.js';
import { cameraPanel, imagePanel } from './camera_panel.js';
import { keyframesPanel } from './keyframes.js';
import { Slices } from './slices.js';
import { outputActions } from './output.js';
import { startTheme } from './theme.js';
import { rounded } from './camera.js';
import { bytes, duration } from './numbers.js';
import { isAnimated, ownCamera, volumeOf, withCamera, withKeys, withoutMotion, withSide, withVolume } from './job.js';

const kMessageTime_ms = 8000;
const kLeastSide_px = 8; // a smaller stage shows no picture

class App {
  active = 0;               // the volume whose function and box are edited
  showsHandles = true;
  shownSize = { width: 1, height: 1 };
  drawsBatchSize = false;
  frame;                    // frame of an animated job that is shown
  followsMotion = false;    // the shown camera is that of the frame, not the still camera
  presetsOf = null;         // the volume that the pictures of presets show
  resolved = null;          // camera and functions of the newest frame, as the server understood the job

  constructor(server, session) {
    this.server = server;
    this.session = session;
    this.state = new JobState(session.job);
    this.frame = session.frame;
    this.followsMotion = isAnimated(session.job);
  }

  get volume() { return this.session.volumes[this.active]; }
  lengthUnit() { return this.session.volumes[0].unit || 'units'; }

  start() {
    byId('title').textContent = this.session.title;
    document.title = `${this.session.title} – Kiln`;
    this.#startPicture();
    this.#startPanels();
    this.#startActions();
    this.state.subscribe((job, reason) => this.#jobChanged(job, reason));
    this.#updatePanels();
    new ResizeObserver(() => this.#resized()).observe(byId('stage'));
    this.#resized();
  }

  // Camera.

  /** Returns the camera of the picture, null before the first answer of the server. */
  camera() {
    const own = ownCamera(this.state.job), found = this.resolved?.camera ?? null;
    return this.#follows() ? found ?? own : own ?? found;
  }

  #follows() { return this.followsMotion && isAnimated(this.state.job); }

  /** Shows the still camera from now on. */
  leaveMotion() {
    this.keysPanel.stop();
    this.followsMotion = false;
  }

  moveCamera(camera, merge = null) {
    this.leaveMotion();
    this.state.change('camera', (job) => withCamera(job, rounded(camera)), { merge });
  }

  /** Returns the job with the present camera in place of a framing, which would follow what is cut off. */
  withPresentCamera(job) {
    const camera = this.camera();
    return camera && !ownCamera(job) && !this.#follows() ? withCamera(job, camera) : job;
  }

  showSide(side) {
    this.leaveMotion();
    this.state.change(`${side} view`, (job) => withSide(job, side));
  }

  resetCamera() {
    this.leaveMotion();
    const first = withoutMotion(this.session.job).camera;
    this.state.change('first view', (job) => (first ? withCamera(job, first) : withKeys(withCamera(job, {}), isAnimated(job) ? {} : { camera: undefined })));
  }

  /** Shows a frame of the animation. */
  showFrame(frame) {
    this.frame = frame;
    this.followsMotion = true;
    this.pictureChanged();
    this.keysPanel.update(this.state.job);
  }

  crossInWorld() { return this.slices.crossInWorld(); }

  // Picture.

  /** Returns the size of the batch's picture: the job's, else that of the shown picture. */
  batchSize() {
    const { image = {} } = this.state.job;
    return image.width && image.height ? [image.width, image.height] : this.#windowSize();
  }

  /** Returns the size of the shown picture in CSS pixels. */
  size() { return this.shownSize; }

  pictureChanged() {
    this.picture.changed();
    this.redrawOverlay();
  }

  #windowSize() {
    const { width, height } = this.size();
    const most = this.session.largest;
    const ratio = Math.min(devicePixelRatio, most / width, most / height);
    return [width, height].map((side) => Math.max(1, Math.round(side * ratio)));
  }

  #request() {
    if (this.shownSize.width < kLeastSide_px || this.shownSize.height < kLeastSide_px) return null;
    const size = this.drawsBatchSize && this.state.job.image?.width ? this.batchSize() : this.#windowSize();
    const job = this.#follows() ? this.state.job : withoutMotion(this.state.job);
    return isAnimated(job) ? { job, size, frame: this.frame } : { job, size };
  }

  // The picture has the proportions of the batch's picture.
  #resized() {
    const stage = byId('stage'), surface = byId('surface');
    const { image = {} } = this.state.job;
    this.sizedImage = this.state.job.image;
    let [width, height] = [stage.clientWidth, stage.clientHeight];
    if (image.width && image.height) {
      const fit = Math.min(width / image.width, height / image.height);
      [width, height] = [fit * image.width, fit * image.height].map((side) => Math.max(1, Math.round(side)));
    }
    surface.style.width = `${width}px`;
    surface.style.height = `${height}px`;
    if (this.shownSize.width === width && this.shownSize.height === height) return;
    this.shownSize = { width, height };
    this.pictureChanged();
    this.imagePanel.update(this.state.job);
  }

  #startPicture() {
    this.picture = new Picture({
      server: this.server,
      canvas: byId('picture'),
      request: () => this.#request(),
      listeners: {
        onResolved: (record) => this.#resolvedArrived(record),
        onPicture: (record, wanted, time) => this.#pictureArrived(record, wanted, time),
        onProgress: (record) => { byId('stage-text').textContent = `${record.done} of ${record.total} ${record.unit}`; },
        onError: (text) => this.fail(text),
        onState: (name) => this.#showState(name),
      },
    });
    this.overlay = new Overlay(byId('overlay'));
    this.handles = new ClipHandles({ root: byId('overlay'), layer: this.overlay.handles, controls: {
      setBox: (box, merge) => this.clipPanel.setBox(box, merge),
      setPlane: (index, plane, merge) => this.clipPanel.setPlane(index, plane, merge),
      endGesture: () => this.state.endGesture(),
    } });
    navigate(byId('surface'), {
      camera: () => this.camera(),
      size: () => this.size(),
      move: (camera, merge) => this.moveCamera(camera, merge),
      endGesture: () => this.state.endGesture(),
      showSide: (side) => this.showSide(side),
      reset: () => this.resetCamera(),
    });
    replace(byId('sides'), Object.entries(kSides).map(([side, name], i) => button(name, () => this.showSide(side), { class: 'small', title: `${name} (${i + 1} or ${side === 'bottom' ? 'd' : side[0]})` })),
      button('Reset', () => this.resetCamera(), { class: 'small', title: 'First view (Home)' }));
    byId('show-box').addEventListener('change', () => this.redrawOverlay());
    byId('surface').addEventListener('contextmenu', (event) => event.preventDefault());
  }

  #resolvedArrived(record) {
    this.resolved = record;
    this.redrawOverlay();
    this.#updatePanels();
    if (this.presetsOf !== this.active) this.#drawPresets();
  }

  // The pictures show the active volume, and other volumes with their present functions.
  #drawPresets() {
    this.presetsOf = this.active;
    this.presets.draw({ job: withoutMotion(this.state.job), volume: this.active });
  }

  #pictureArrived(record, wanted, time) {
    this.clearFailure();
    byId('stage-text').textContent = record.asRendered ? '' : record.stage;
    const size = wanted.size.join(' × '), batch = this.batchSize().join(' × ');
    byId('size-text').textContent = `${size}${size === batch ? '' : ` of ${batch}`} pixels`;
    const [finest, coarsest] = record.level;
    byId('level-text').textContent = finest === coarsest ? `level ${finest}` : `levels ${finest} to ${coarsest}`;
    byId('read-text').textContent = `${bytes(record.bytesRead)} read`;
    byId('time-text').textContent = `drawn in ${duration(record.seconds)}, shown after ${duration(time / 1000)}`;
    if (record.asRendered) this.#showBadge('as rendered');
    byId('keep').disabled = !record.asRendered;
    byId('picture').setAttribute('aria-label', `Picture of ${this.session.title}, ${record.asRendered ? 'as rendered' : 'preview'}`);
  }

  #showState(name) {
    if (name === 'moving') this.#showBadge('moving');
    else if (name === 'waiting') this.#showBadge('drawing');
    else if (!this.picture.finalBytes) this.#showBadge('preview');
    if (name !== 'final') byId('keep').disabled = true;
  }

  #showBadge(text) {
    const badge = byId('badge');
    badge.textContent = text;
    badge.dataset.state = text.replace(' ', '-');
  }

  redrawOverlay() {
    const camera = this.camera();
    if (!camera || camera.projection === 'equirectangular') return;
    const size = this.size();
    const box = byId('show-box').checked ? { affine: this.volume.affine, box: wholeBox(this.volume) } : null;
    const cross = byId('show-slices').checked ? this.crossInWorld() : null;
    this.overlay.draw({ camera, size, lengthUnit: this.lengthUnit(), names: axisNames(this.session.volumes[0]), box, cross });
    const shows = this.showsHandles && byId('clip-section').open;
    this.handles.draw(shows ? { camera, size, volume: this.volume, box: this.clipPanel.boxOf(), planes: this.clipPanel.planesOf(), bounds: this.session.box, lengthUnit: this.lengthUnit() } : null);
  }

  // Panels.

  #startPanels() {
    const put = (id, ...nodes) => byId(id).querySelector('.inside').append(...nodes);
    const done = () => this.state.endGesture();
    const setFunction = (fn, label, merge = null) => this.state.change(label, (job) => withVolume(job, this.active, { transferFunction: fn, window: undefined }), { merge });
    this.editor = new FunctionEditor({ onFunction: setFunction, onDone: done,
      onWindow: (window, merge) => this.state.change('window', (job) => withVolume(job, this.active, { window }), { merge }) });
    this.labels = new LabelList({ onFunction: setFunction, onDone: done });
    this.presets = new Presets({ server: this.server, names: this.session.presets, isIdle: () => this.picture.isIdle,
      onChoose: (name) => setFunction(name, `preset ${name}`) });
    this.unresolved = html('p', { class: 'dim' }, 'The function arrives with the first picture.');
    this.animatedFunction = html('p', { class: 'dim' }, 'The function has key frames; an edit replaces them.');
    const file = html('input', { type: 'file', accept: '.json,.txt,application/json', hidden: true, onchange: () => { if (file.files[0]) this.#takeFile(file.files[0]); file.value = ''; } });
    let surfaceAt = null;
    const surfaceValue = numberField({ name: null, label: 'Value of the surface', unit: 'value', spokenUnit: '', onInput: (value) => { surfaceAt = value; surfaceValue.set(value); } });
    const surface = button('Surface at', () => { if (surfaceAt !== null) setFunction(`iso:${surfaceAt}`, 'surface'); }, { class: 'small' });
    this.surface = html('span', { class: 'controls' }, surface, surfaceValue.node);
    put('function-section', this.presets.node,
      html('div', { class: 'row wrap' }, this.surface, html('span', { class: 'spacer' }), button('Open file…', () => file.click(), { class: 'small', title: 'A function of Kiln or a colour map of ParaView, JSON' }), file),
      this.animatedFunction, this.unresolved, this.editor.node, this.labels.node);
    this.slices = new Slices({ server: this.server, onCross: () => this.redrawOverlay() });
    byId('slices').append(this.slices.node);
    const showSlices = byId('show-slices');
    const toggle = () => {
      byId('slices').hidden = !showSlices.checked;
      if (showSlices.checked) this.slices.show(this.volume, this.active);
      this.redrawOverlay();
    };
    showSlices.addEventListener('change', toggle);
    this.lightPanel = lightPanel(this);
    this.clipPanel = clipPanel(this);
    this.cameraPanel = cameraPanel(this);
    this.imagePanel = imagePanel(this);
    this.keysPanel = keyframesPanel(this);
    put('light-section', this.lightPanel.node);
    put('clip-section', this.clipPanel.node);
    put('camera-section', this.cameraPanel.node);
    put('image-section', this.imagePanel.node);
    put('keys-section', this.keysPanel.node);
    byId('clip-section').addEventListener('toggle', () => this.redrawOverlay());
    this.#startTabs();
    addEventListener('dragover', (event) => event.preventDefault());
    addEventListener('drop', (event) => { event.preventDefault(); if (event.dataTransfer.files[0]) this.#takeFile(event.dataTransfer.files[0]); });
  }

  #startTabs() {
    const tabs = byId('volumes');
    if (this.session.volumes.length < 2) return;
    tabs.hidden = false;
    const nodes = this.session.volumes.map((volume, index) => html('button', { type: 'button', role: 'tab', id: `volume-${index}`, 'aria-controls': 'function-section', onclick: () => this.#activate(index) }, volume.name));
    tabs.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      this.#activate((this.active + step + nodes.length) % nodes.length);
      nodes[this.active].focus();
    });
    replace(tabs, nodes);
    this.#activate(0);
  }

  #activate(index) {
    this.active = index;
    for (const [i, tab] of [...byId('volumes').children].entries()) {
      tab.setAttribute('aria-selected', String(i === index));
      tab.tabIndex = i === index ? 0 : -1;
    }
    if (byId('show-slices').checked) this.slices.show(this.volume, index);
    this.#updatePanels();
    if (this.resolved && this.presetsOf !== index) this.#drawPresets();
    this.redrawOverlay();
  }

  // Returns the function of the active volume as an object; null before the server resolved it.
  #functionNow(job) {
    const { transferFunction, window } = volumeOf(job, this.active);
    if (typeof transferFunction === 'object' && !transferFunction.keyframes && !window) return transferFunction;
    return this.resolved?.transferFunctions?.[this.active] ?? null;
  }

  #updatePanels() {
    const { job } = this.state;
    const own = volumeOf(job, this.active);
    const fn = this.#functionNow(job);
    const lengthUnit = this.volume.unit || 'units';
    const hasLabels = Boolean(fn?.labels);
    this.unresolved.hidden = fn !== null;
    this.animatedFunction.hidden = !own.transferFunction?.keyframes;
    this.editor.node.hidden = !fn || hasLabels;
    this.labels.node.hidden = !hasLabels;
    const unit = fn?.unit || this.volume.spacing.reduce((a, b) => a + b) / 3;
    const shown = JSON.stringify([this.active, fn]);
    if (shown !== this.shownFunction) {
      this.shownFunction = shown;
      if (fn && !hasLabels) this.editor.show({ fn: { ...fn, unit }, histogram: this.volume.histogram, lengthUnit });
      if (hasLabels) this.labels.show({ fn: { ...fn, unit }, labels: this.volume.labels ?? [], lengthUnit });
    }
    // Presets other than "auto" colour values, and the values of labels mean nothing.
    this.presets.offer((name) => this.volume.classes !== 'labels' || name === 'auto');
    this.surface.hidden = this.volume.classes === 'labels';
    this.slices.color(hasLabels ? fn : null);
    this.presets.mark(typeof own.transferFunction === 'string' ? own.transferFunction : own.transferFunction === undefined ? 'auto' : null);
    for (const panel of [this.lightPanel, this.clipPanel, this.cameraPanel, this.imagePanel, this.keysPanel]) panel.update(job);
  }

  async #takeFile(file) {
    try {
      if (file.size > 900_000) throw new Error(`${file.name}: ${bytes(file.size)}; a function has at most 900 kB`);
      const { transferFunction } = await this.server.json('function', { text: await file.text(), volume: this.active });
      this.state.change(`function of ${file.name}`, (job) => withVolume(job, this.active, { transferFunction, window: undefined }));
      this.announce(`Took the function of ${file.name}`);
    } catch (error) {
      this.fail(error.message);
    }
  }

  // History and actions.

  #jobChanged(job, reason) {
    if (reason !== 'saved') {
      if (job.image !== this.sizedImage) this.#resized();
      this.pictureChanged();
    }
    this.#updatePanels();
    this.#showHistory();
  }

  #showHistory() {
    const { undoLabel, redoLabel, isSaved } = this.state;
    for (const [id, label, name] of [['undo', undoLabel, 'Undo'], ['redo', redoLabel, 'Redo']]) {
      byId(id).disabled = label === null;
      byId(id).setAttribute('aria-label', label === null ? name : `${name}: ${label}`);
      byId(id).title = label === null ? '' : `${name}: ${label}`;
    }
    byId('save-state').textContent = isSaved ? '' : 'not saved';
  }

  #startActions() {
    const actions = outputActions(this);
    const go = (step, done) => { const label = this.state[step](); if (label !== null) this.announce(`${done}: ${label}`); };
    const undo = () => go('undo', 'Undone'), redo = () => go('redo', 'Redone');
    byId('undo').addEventListener('click', undo);
    byId('redo').addEventListener('click', redo);
    byId('save').addEventListener('click', actions.save);
    byId('command').addEventListener('click', actions.command);
    byId('render').addEventListener('click', actions.render);
    byId('keep').addEventListener('click', () => this.#keepPicture());
    byId('help-button').addEventListener('click', () => byId('help').showModal());
    byId('help-close').addEventListener('click', () => byId('help').close());
    addEventListener('beforeunload', (event) => { if (!this.state.isSaved) event.preventDefault(); });
    addEventListener('keydown', (event) => {
      if (!(event.ctrlKey || event.metaKey)) return;
      const key = event.key.toLowerCase();
      const isText = event.target instanceof HTMLInputElement && ['text', 'search'].includes(event.target.type);
      if (key === 's') actions.save();
      else if (key === 'z' && !isText) (event.shiftKey ? redo : undo)();
      else if (key === 'y' && !isText) redo();
      else return;
      event.preventDefault();
    });
    this.#showHistory();
  }

  #keepPicture() {
    const blob = this.picture.finalBytes;
    if (!blob) return;
    const link = html('a', { href: URL.createObjectURL(blob), download: `${this.session.title.replace(/[^\w.-]+/g, '_')}.png` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }

  announce(text) {
    const live = byId('live');
    live.textContent = text;
    clearTimeout(this.announceTimer);
    this.announceTimer = setTimeout(() => { live.textContent = ''; }, kMessageTime_ms);
  }

  fail(text) {
    const message = byId('message');
    message.textContent = text;
    message.hidden = false;
    this.#showBadge('error');
  }
  clearFailure() { byId('message').hidden = true; }
}

async function start() {
  startTheme(byId('theme'));
  const server = new Server(tokenOfPage());
  try {
    const session = await server.json('session');
    new App(server, session).start();
  } catch (error) {
    const message = byId('message');
    message.hidden = false;
    message.textContent = error instanceof ServerError && error.status === 401
      ? 'This page needs the whole address that kiln view printed, with the token after #.' : `The viewer cannot start: ${error.message}`;
    byId('badge').textContent = 'error';
    if (!(error instanceof ServerError)) throw error;
  }
}

start();
