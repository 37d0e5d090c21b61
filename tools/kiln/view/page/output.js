// From looking to batch: the job's file, its command, its cost, and the render on the server's machine.
import { button, html, numberField, replace } from './element.js';
import { bytes, duration, short } from './numbers.js';

/** Returns actions {save, command, render}. Each opens what it needs. `app` has server, state, batchSize and announce. */
export function outputActions(app) {
  const body = () => ({ job: app.state.job, size: app.batchSize() });

  async function save() {
    const job = app.state.job;
    try {
      const written = await app.server.json('save', body());
      if (app.state.job === job) app.state.markSaved();
      app.announce(`Saved ${written.path} (${bytes(written.bytes)})`);
    } catch (error) {
      app.fail(error.message);
    }
  }

  // The command, selected and copied.
  const text = html('textarea', { readonly: true, rows: 6, 'aria-label': 'Command line' });
  const copied = html('p', { class: 'dim', role: 'status' });
  const unsaved = html('div', { class: 'row' }, html('span', {}, 'The command draws the saved job, and the job has changes.'),
    button('Save job', async () => { await save(); unsaved.hidden = app.state.isSaved; }, { class: 'small' }));
  const commandDialog = html('dialog', { 'aria-labelledby': 'command-title' }, html('h2', { id: 'command-title' }, 'Command line'), text, unsaved, copied,
    html('div', { class: 'dialog-buttons' }, button('Copy', () => copy()), button('Close', () => commandDialog.close())));
  async function copy() {
    text.select();
    try {
      await navigator.clipboard.writeText(text.value);
      copied.textContent = 'Copied.';
    } catch {
      copied.textContent = 'The browser keeps the clipboard to itself; press Ctrl+C.';
    }
  }
  async function command() {
    try {
      text.value = (await app.server.json('command', body())).command;
      copied.textContent = '';
      const drawsFile = app.session.jobFile !== null && text.value.includes(app.session.jobFile);
      unsaved.hidden = app.state.isSaved || !drawsFile;
      commandDialog.showModal();
      await copy();
    } catch (error) {
      app.fail(error.message);
    }
  }

  // Cost and render.
  const facts = html('dl', { class: 'facts' });
  const bar = html('progress', { max: 1, value: 0, 'aria-label': 'Progress of the render' });
  const line = html('p', { role: 'status' });
  const start = button('Render', () => run(), { class: 'primary' });
  const cancel = button('Cancel', () => running?.abort());
  const close = button('Close', () => renderDialog.close());
  const wanted = [1, 1];
  const sides = ['Width', 'Height'].map((label, i) => {
    return numberField({ name: null, label, unit: i === 0 ? '×' : 'pixels', spokenUnit: 'pixels', min: 1, max: app.session.largest, step: 1, onInput: (value) => { setSide(i, Math.round(value)); later(); } });
  });
  const setSide = (i, value) => { wanted[i] = value; sides[i].set(value); };
  const renderDialog = html('dialog', { 'aria-labelledby': 'render-title' }, html('h2', { id: 'render-title' }, 'Render here'),
    html('div', { class: 'row' }, html('span', { class: 'name' }, 'Size'), html('span', { class: 'controls' }, sides.map((side) => side.node))),
    html('h3', {}, 'What will it take'), facts, bar, line, html('div', { class: 'dialog-buttons' }, start, cancel, close));
  let running = null;
  let estimating = null;
  let wait = null;
  renderDialog.addEventListener('cancel', (event) => { if (running) event.preventDefault(); });
  renderDialog.addEventListener('close', () => estimating?.abort());

  const request = () => ({ job: app.state.job, size: [...wanted] });

  function later() {
    clearTimeout(wait);
    wait = setTimeout(estimate, 400);
  }

  async function estimate() {
    estimating?.abort();
    const mine = (estimating = new AbortController());
    replace(facts, html('dt', {}, 'Memory, bricks, time'), html('dd', {}, 'counting …'));
    try {
      const found = await app.server.json('estimate', request(), mine.signal);
      const fact = (name, value) => [html('dt', {}, name), html('dd', {}, value)];
      replace(facts, fact('Memory', bytes(found.memory)), fact('Bricks', `${short(found.bricks)} of ${bytes(found.bytes)}`),
        fact('Time', found.seconds === null || found.seconds === undefined ? 'not known' : `about ${duration(found.seconds)}`));
    } catch (error) {
      if (!mine.signal.aborted) replace(facts, html('dt', {}, 'Not known'), html('dd', {}, error.message));
    }
  }

  function show(isRunning) {
    start.disabled = isRunning;
    cancel.hidden = !isRunning;
    bar.hidden = !isRunning;
    close.disabled = isRunning;
  }

  async function run() {
    running = new AbortController();
    bar.removeAttribute('value');
    line.textContent = 'Drawing …';
    show(true);
    let written = false;
    try {
      await app.server.records('render', request(), running.signal, (head) => {
        if (head.kind === 'progress') {
          bar.value = head.total > 0 ? head.done / head.total : 0;
          line.textContent = `${head.done} of ${head.total} ${head.unit}`;
        } else if (head.kind === 'written') {
          written = true;
          line.textContent = head.frames > 1 ? `Wrote ${head.frames} pictures from ${head.path} on (${bytes(head.bytes)})` : `Wrote ${head.path} (${bytes(head.bytes)})`;
        } else if (head.kind === 'error') {
          throw new Error(head.error);
        }
      });
      if (!written) line.textContent = 'The render ended without a file.';
    } catch (error) {
      line.textContent = running.signal.aborted ? 'Cancelled; no file was written.' : error.message;
    }
    running = null;
    show(false);
  }

  function render() {
    app.batchSize().forEach((value, i) => setSide(i, value));
    line.textContent = '';
    show(false);
    renderDialog.showModal();
    estimate();
  }

  document.body.append(commandDialog, renderDialog);
  return { save, command, render };
}
