// The page of `kiln view` in a browser, against the program. viewer.mjs says what must be installed.
import test, { after, before } from 'node:test';
import assert from 'node:assert/strict';
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { ViewerPage, axeSource, decodePng, forwardToSocket, launchBrowser, prefixProxy, run, startViewer, workFolder } from './viewer.mjs';

const kLabelSide = 16;
const folder = workFolder();
const viewers = new Map();
let browser;

before(async () => {
  browser = await launchBrowser();
  run(folder.path, 'convert', 'phantom:head:64x64x64', 'head.kiln');
  // Label 3 in the lower half of the slices, label 7 in the upper half.
  writeFileSync(join(folder.path, 'organs.raw'), Buffer.alloc(kLabelSide ** 3, 3).fill(7, kLabelSide ** 3 / 2));
  writeFileSync(join(folder.path, 'names.txt'), '3 liver\n7 air way\n');
  const turned = Buffer.alloc(8 * 12 * 16);
  for (const x of [6, 7]) for (const y of [10, 11]) for (const z of [14, 15]) turned[x + 8 * (y + 12 * z)] = 255;
  writeFileSync(join(folder.path, 'turned.raw'), turned);
  run(folder.path, 'convert', 'turned.raw', 'turned.kiln', '--dims', '8,12,16', '--type', 'u8', '--orient', 'SRA');
  run(folder.path, 'convert', 'organs.raw', 'organs.kiln', '--dims', '16,16,16', '--type', 'u8', '--spacing', '9,9,9', '--labels');
});

after(async () => {
  await browser?.close();
  for (const viewer of viewers.values()) await viewer.stop();
  folder.close();
});

const kArguments = { ct: ['head.kiln'], labels: ['organs.kiln'], two: ['head.kiln', '--add', 'organs.kiln'], turned: ['turned.kiln'],
  named: ['organs.kiln', '--tf', 'names.txt'] };

/** Runs a test on a page of its own; each kind of viewer is started once. */
function onPage(name, kind, body, options = {}) {
  test(name, { timeout: 120_000 }, async () => {
    if (!viewers.has(kind)) viewers.set(kind, await startViewer(folder.path, ...kArguments[kind]));
    const viewer = await ViewerPage.open(browser, viewers.get(kind).url, options);
    try {
      await viewer.settled();
      await body(viewer, viewer.page);
      assert.deepEqual(viewer.faults, []);
    } finally {
      await viewer.close();
    }
  });
}

onPage('the first picture appears with its level and cost, and no request leaves the server', 'ct', async (viewer, page) => {
  assert.match(await page.textContent('#level-text'), /level/);
  assert.match(await page.textContent('#read-text'), /iB read|B read/);
  const origin = new URL(viewer.url).origin;
  for (const request of viewer.requests) assert.ok(/^(blob|data):/.test(request.url()) || request.url().startsWith(`${origin}/`), request.url());
  assert.ok(viewer.requests.every((request) => !request.url().includes(viewer.url.split('#')[1])), 'the token is in no address');
});

onPage('a drag changes picture and job, undo restores both', 'ct', async (viewer, page) => {
  const first = { picture: await viewer.picture(), job: viewer.job() };
  await viewer.drag('#surface', 80, 30);
  await viewer.settled();
  const moved = viewer.job();
  assert.notEqual(await viewer.picture(), first.picture);
  for (const key of ['eye', 'target', 'up']) assert.equal(moved.camera[key].length, 3);
  await page.keyboard.press('Control+z');
  await viewer.settled();
  assert.deepEqual(viewer.job(), first.job);
  assert.equal(await viewer.picture(), first.picture);
  await page.keyboard.press('Control+Shift+Z');
  await viewer.settled();
  assert.deepEqual(viewer.job(), moved);
});

onPage('of fifty moves the last is shown, and at most two are finished', 'ct', async (viewer, page) => {
  await page.evaluate(() => {
    window.finished = 0;
    new MutationObserver(() => { if (document.getElementById('badge').textContent === 'as rendered') ++window.finished; })
      .observe(document.getElementById('badge'), { childList: true });
  });
  const sent = viewer.bodies('frame').length;
  const box = await page.locator('#surface').boundingBox();
  await page.mouse.move(box.x + 100, box.y + 100);
  await page.mouse.down();
  for (let i = 1; i <= 50; ++i) {
    await page.mouse.move(box.x + 100 + 4 * i, box.y + 100 + i);
    await page.waitForTimeout(15);
  }
  await page.mouse.up();
  await viewer.settled();
  const frames = viewer.bodies('frame').slice(sent);
  assert.ok((await page.evaluate(() => window.finished)) <= 2);
  assert.equal(frames.at(-1).moving, false);
  assert.deepEqual(frames.at(-1).seq, Math.max(...frames.map((frame) => frame.seq)));
  // The whole way of the drag: 200 pixels across are 200 / shorter side of half a turn.
  const angle = ([x, y]) => Math.atan2(y, x);
  const from = frames[0].job.camera, to = frames.at(-1).job.camera;
  const turn = angle([to.eye[0] - to.target[0], to.eye[1] - to.target[1]]) - angle([from.eye[0] - from.target[0], from.eye[1] - from.target[1]]);
  const whole = (Math.PI * 196) / Math.min(box.width, box.height);
  assert.ok(Math.abs(Math.abs(Math.atan2(Math.sin(turn), Math.cos(turn))) - whole) < 0.02, `turned by ${turn}, expected ${whole}`);
});

onPage('texts of the state change no size of the picture', 'ct', async (viewer, page) => {
  for (const width of [900, 1000, 1100, 1250, 1400]) {
    await page.setViewportSize({ width, height: 800 });
    await viewer.settled();
    const sizeOf = () => page.evaluate(() => [document.getElementById('stage').clientWidth, document.getElementById('stage').clientHeight]);
    const before = await sizeOf();
    await page.evaluate(() => { document.getElementById('level-text').textContent = 'levels 0 to 1 and many more words than ever'; });
    assert.deepEqual(await sizeOf(), before);
  }
});

onPage('wheel, pan, roll, sides and keys change the camera as they say', 'ct', async (viewer, page) => {
  const length = (v) => Math.hypot(...v), minus = (a, b) => a.map((x, i) => x - b[i]);
  await page.focus('#surface');
  await page.keyboard.press('ArrowRight');
  await viewer.settled();
  const turned = viewer.job().camera;
  await page.keyboard.press('+');
  await viewer.settled();
  const grown = viewer.job().camera;
  assert.ok(Math.abs(length(minus(turned.eye, turned.target)) / length(minus(grown.eye, grown.target)) - 1.1) < 1e-3);
  await viewer.drag('#surface', 40, 0, { modifiers: ['Shift'] });
  await viewer.settled();
  const panned = viewer.job().camera;
  assert.ok(length(minus(panned.target, grown.target)) > 0);
  await viewer.drag('#surface', 0, 60, { modifiers: ['Control'], from: [600, 200] });
  await viewer.settled();
  const rolled = viewer.job().camera;
  assert.notDeepEqual(rolled.up, panned.up);
  assert.deepEqual(rolled.eye, panned.eye);
  await page.focus('#surface');
  await page.keyboard.press('l');
  await viewer.settled();
  assert.equal(viewer.job().camera.view, 'left');
  await page.keyboard.press('5');
  await viewer.settled();
  assert.equal(viewer.job().camera.view, 'top');
  await page.mouse.move(300, 300);
  await page.mouse.wheel(0, -500);
  await viewer.settled();
  assert.ok(viewer.job().camera.eye);
  await page.keyboard.press('Home');
  await viewer.settled();
  assert.equal(viewer.job().camera?.eye, undefined);
});

onPage('two fingers zoom and roll', 'ct', async (viewer, page) => {
  await page.focus('#surface');
  await page.keyboard.press('ArrowRight');
  await viewer.settled();
  const before = viewer.job().camera;
  const { x, y, width, height } = await page.locator('#surface').boundingBox();
  const fingers = (radius, angle) => [0, Math.PI].map((half, id) => ({ id, x: x + width / 2 + radius * Math.cos(angle + half), y: y + height / 2 + radius * Math.sin(angle + half) }));
  const touch = await page.context().newCDPSession(page);
  await touch.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: fingers(60, 0) });
  for (let step = 1; step <= 8; ++step) await touch.send('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: fingers(60 + 7.5 * step, (step * Math.PI) / 32) });
  await touch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  await viewer.settled();
  const after = viewer.job().camera;
  const distance = ({ eye, target }) => Math.hypot(...eye.map((v, i) => v - target[i]));
  assert.ok(Math.abs(distance(before) / distance(after) - 2) < 0.05, `${distance(before)} to ${distance(after)}`);
  // Fingers turn clockwise by 45 degrees, so the camera turns counter-clockwise by as much.
  const cosine = before.up.reduce((sum, v, i) => sum + v * after.up[i], 0) / (Math.hypot(...before.up) * Math.hypot(...after.up));
  assert.ok(cosine < 0.85, `${cosine}`);
});

onPage('an orthographic camera has a height and no field of view', 'ct', async (viewer, page) => {
  await viewer.section('camera');
  await page.selectOption('[aria-label="Projection"]', 'orthographic');
  await viewer.settled();
  assert.ok(viewer.job().camera.height > 0);
  assert.equal(viewer.job().camera.fov, undefined);
  const height = viewer.job().camera.height;
  await page.focus('#surface');
  await page.keyboard.press('-');
  await viewer.settled();
  assert.ok(Math.abs(viewer.job().camera.height / height - 1.1) < 1e-3);
});

onPage('a dragged point changes the function by the way of the drag, and undo restores it', 'ct', async (viewer, page) => {
  await page.getByRole('button', { name: 'ct-bone-and-skin', exact: true }).click();
  await viewer.settled();
  assert.equal(viewer.job().transferFunction, 'ct-bone-and-skin');
  const before = await viewer.picture();
  const point = page.locator('circle.point').nth(1);
  const value = Number(await point.getAttribute('aria-valuenow'));
  const [x0, x1] = await page.evaluate(() => [...document.querySelectorAll('circle.point')].slice(0, 2).map((p) => p.cx.baseVal.value));
  const first = Number(await page.locator('circle.point').nth(0).getAttribute('aria-valuenow'));
  const perPixel = (value - first) / (x1 - x0);
  await point.scrollIntoViewIfNeeded();
  await viewer.drag(point, -5, -30);
  await viewer.settled();
  const fn = viewer.job().transferFunction;
  assert.ok(Math.abs(fn.points[1].value - (value - 5 * perPixel)) <= 1.5 * perPixel, `${fn.points[1].value} from ${value}, ${perPixel} a pixel`);
  assert.notEqual(await viewer.picture(), before);
  await page.click('#undo');
  await viewer.settled();
  assert.equal(viewer.job().transferFunction, 'ct-bone-and-skin');
  assert.equal(await viewer.picture(), before);
});

onPage('points are edited by keys and by numbers', 'ct', async (viewer, page) => {
  await page.getByRole('button', { name: 'ct-bone', exact: true }).click();
  await viewer.settled();
  const points = page.locator('circle.point');
  const count = await points.count();
  await points.nth(0).focus();
  await page.keyboard.press('PageDown');
  assert.equal(await page.evaluate(() => document.activeElement.dataset.index), '1');
  const opacity = async () => viewer.job().transferFunction.points[1].opacity;
  await page.keyboard.press('ArrowDown');
  await viewer.settled();
  const lowered = await opacity();
  await page.keyboard.press('ArrowUp');
  await viewer.settled();
  assert.ok((await opacity()) > lowered);
  await page.keyboard.press('Insert');
  await viewer.settled();
  assert.equal(viewer.job().transferFunction.points.length, count + 1);
  await page.getByLabel('Opacity of the point').fill('0.25');
  await viewer.settled();
  assert.ok(viewer.job().transferFunction.points.some((p) => p.opacity === 0.25));
  await page.getByLabel('Colour of the point').fill('#12ab34');
  await viewer.settled();
  assert.ok(viewer.job().transferFunction.points.some((p) => p.color === '#12ab34'));
  await page.getByRole('button', { name: 'Delete', exact: true }).click();
  await viewer.settled();
  assert.equal(viewer.job().transferFunction.points.length, count);
  // Digits that are typed one by one are not replaced by the limits of the neighbours.
  await points.nth(0).focus();
  const value = page.getByLabel('Value of the point');
  const typed = String(Number(await value.inputValue()) + 1);
  await value.press('Control+a');
  await value.pressSequentially(typed);
  await value.press('Enter');
  await viewer.settled();
  assert.ok(viewer.job().transferFunction.points.some((p) => p.value === Number(typed)), typed);
});

onPage('surfaces are added, moved and coloured as points are', 'ct', async (viewer, page) => {
  await page.getByLabel('Value of the surface').fill('1300');
  await page.getByRole('button', { name: 'Surface at' }).click();
  await viewer.settled();
  assert.equal(viewer.job().transferFunction, 'iso:1300');
  const before = await viewer.picture();
  await page.getByRole('button', { name: 'Add surface' }).click();
  await viewer.settled();
  assert.equal(viewer.job().transferFunction.surfaces.length, 2);
  const value = Number(await page.locator('circle.point').nth(0).getAttribute('aria-valuenow'));
  await viewer.drag(page.locator('circle.point').nth(0), -20, 40);
  await viewer.settled();
  const { surfaces } = viewer.job().transferFunction;
  assert.ok(surfaces[0].value < value && surfaces[0].opacity < 1);
  assert.notEqual(await viewer.picture(), before);
});

onPage('the window stretches a preset', 'ct', async (viewer, page) => {
  await page.getByRole('button', { name: 'grayscale', exact: true }).click();
  await viewer.settled();
  await viewer.drag(page.getByRole('slider', { name: 'End of the window' }), -30, 0);
  await viewer.settled();
  const { transferFunction, window } = viewer.job();
  assert.equal(transferFunction, 'grayscale');
  assert.ok(window[1] > 0);
  await page.getByLabel('Width of the window').fill('500');
  await viewer.settled();
  assert.equal(viewer.job().window[1], 500);
});

onPage('a dropped colour map of ParaView becomes the function', 'ct', async (viewer, page) => {
  const map = [{ Name: 'Two colours', ColorSpace: 'Lab', RGBPoints: [0, 0.2, 0.3, 0.8, 1, 0.8, 0.2, 0.1] }];
  const transfer = await page.evaluateHandle((text) => {
    const data = new DataTransfer();
    data.items.add(new File([text], 'map.json', { type: 'application/json' }));
    return data;
  }, JSON.stringify(map));
  await page.dispatchEvent('#surface', 'drop', { dataTransfer: transfer });
  await page.waitForFunction(() => document.getElementById('live').textContent.includes('map.json'));
  await viewer.settled();
  assert.ok(viewer.job().transferFunction.points.length >= 2);
});

onPage('presets have pictures of this volume', 'ct', async (_, page) => {
  await page.waitForFunction(() => document.querySelectorAll('.preset img[src^="blob:"]').length > 3, null, { timeout: 30_000 });
});

onPage('labels are hidden, shown and coloured', 'labels', async (viewer, page) => {
  const before = await viewer.picture();
  const eyes = page.locator('.labels .eye');
  assert.ok((await eyes.count()) >= 2);
  await eyes.nth(0).click();
  await viewer.settled();
  assert.equal(viewer.job().transferFunction.labels[0].opacity, 0);
  assert.equal(await eyes.nth(0).getAttribute('aria-pressed'), 'false');
  assert.notEqual(await viewer.picture(), before);
  await eyes.nth(0).click();
  await viewer.settled();
  assert.ok(viewer.job().transferFunction.labels[0].opacity > 0);
  await page.locator('.labels input[type=color]').nth(1).fill('#00ff00');
  await viewer.settled();
  assert.equal(viewer.job().transferFunction.labels[1].color, '#00ff00');
  assert.notEqual(await viewer.picture(), before);
});

onPage('the clip box is moved by handles, keys and numbers', 'ct', async (viewer, page) => {
  await viewer.section('clip');
  const before = await viewer.picture();
  await page.getByLabel('Clip box', { exact: true }).check();
  await viewer.settled();
  const [, , , x1] = viewer.job().region;
  const handle = page.locator('[data-handle="box-3"]');
  const middle = page.locator('[data-handle="box-0"]');
  const [a, b] = [await handle.boundingBox(), await middle.boundingBox()];
  await viewer.drag(handle, (b.x - a.x) / 4, (b.y - a.y) / 4);
  await viewer.settled();
  const cut = viewer.job().region[3];
  assert.ok(Math.abs(cut - 0.75 * x1) < 0.12 * x1, `${cut} of ${x1}`);
  assert.notEqual(await viewer.picture(), before);
  await handle.focus();
  await page.keyboard.press('ArrowLeft');
  await viewer.settled();
  assert.equal(viewer.job().region[3], cut - 1);
  await page.getByLabel('Clip box z from').fill('20');
  await viewer.settled();
  assert.equal(viewer.job().region[2], 20);
});

onPage('a clip plane faces the viewer, is moved, turned and flipped', 'ct', async (viewer, page) => {
  await viewer.section('clip');
  const before = await viewer.picture();
  await page.getByRole('button', { name: 'Facing' }).click();
  await viewer.settled();
  const [plane] = viewer.job().clip;
  assert.ok(Math.abs(Math.hypot(...plane.normal) - 1) < 1e-4);
  assert.notEqual(await viewer.picture(), before);
  await page.locator('[data-handle="plane-0"]').focus();
  await page.keyboard.press('ArrowRight');
  await viewer.settled();
  assert.ok(viewer.job().clip[0].offset < plane.offset);
  await viewer.drag('[data-handle="plane-0"]', 0, -40);
  await viewer.settled();
  await page.locator('[data-handle="normal-0"]').focus();
  await page.keyboard.press('Shift+ArrowRight');
  await viewer.settled();
  assert.notDeepEqual(viewer.job().clip[0].normal, plane.normal);
  await page.getByRole('button', { name: 'Flip plane 1' }).click();
  await viewer.settled();
  await page.getByRole('button', { name: 'Remove plane 1' }).click();
  await viewer.settled();
  assert.equal(viewer.job().clip, undefined);
  assert.equal(await viewer.picture(), before);
});

onPage('mode, look, lights, exposure, background and samples are keys of the job', 'ct', async (viewer, page) => {
  await viewer.section('light');
  await viewer.section('image');
  const steps = [
    [() => page.selectOption('[aria-label="Look"]', 'studio'), (job) => job.look === 'studio'],
    [() => page.getByLabel('Exposure, stops').fill('1'), (job) => job.display.exposure === 1],
    [() => page.selectOption('[aria-label="Look"]', 'plain'), (job) => job.look === undefined],
    [() => page.getByRole('button', { name: 'Add light' }).click(), (job) => job.lights.at(-1).type === 'camera'],
    [() => page.getByLabel('Ambient occlusion, ×').fill('0.5'), (job) => job.shading.ambientOcclusion.strength === 0.5],
    [() => page.getByLabel('All lights cast shadows').check(), (job) => job.shading.shadows === true],
    [() => page.selectOption('[aria-label="Background"]', 'one'), (job) => job.image.background === '#000000'],
    [() => page.selectOption('[aria-label="Samples"]', '4'), (job) => job.samples === 4],
    [() => page.selectOption('[aria-label="Mode"]', 'mip'), (job) => job.mode === 'mip'],
  ];
  let last = await viewer.picture();
  for (const [act, holds] of steps) {
    await act();
    await viewer.settled();
    assert.ok(holds(viewer.job()), JSON.stringify(viewer.job()));
  }
  assert.notEqual(await viewer.picture(), last);
  for (const [index] of steps.entries()) {
    await page.click('#undo');
    await viewer.settled();
    if (index === steps.length - 1) assert.equal(await viewer.picture(), last);
  }
});

onPage('slices follow one crosshair and show value and place', 'ct', async (viewer, page) => {
  await page.check('#show-slices');
  await page.waitForFunction(() => [...document.querySelectorAll('.slice canvas')].every((canvas) => canvas.width > 1));
  const indexOf = (axis) => page.getByLabel(`Voxel of the slice across ${axis}`).inputValue();
  const frame = page.getByLabel('Slice across z', { exact: false }).first();
  const box = await frame.boundingBox();
  const [x, y] = [Number(await indexOf('x')), Number(await indexOf('y'))];
  await page.mouse.click(box.x + box.width / 4, box.y + box.height / 2);
  assert.ok(Math.abs(Number(await indexOf('x')) - x / 2) <= 1.5);
  assert.ok(Math.abs(Number(await indexOf('y')) - y) <= 1.5);
  await page.waitForFunction(() => /value .*·.*mm|value .*·.*units/.test(document.querySelector('.readout').textContent));
  // The phantom is in LPS.
  const sides = await page.locator('.slice.axis-2 .side').allTextContents();
  assert.deepEqual(sides, ['R', 'L', 'A', 'P']);
  await page.keyboard.press('PageUp');
  const z = Number(await indexOf('z'));
  const slices = () => viewer.bodies('slice').filter((body) => body.axis === 'z').at(-1).index;
  await page.waitForTimeout(300);
  assert.equal(slices(), z);
});

// Voxels whose axes x, y and z grow to the head, to the right and to the front; the mark, of value 255, is the patient's
// upper right front corner: voxels 7,11,15 and their neighbours.
onPage('slices of turned voxels have the sides of the patient', 'turned', async (viewer, page) => {
  await page.check('#show-slices');
  await page.waitForFunction(() => [...document.querySelectorAll('.slice canvas')].every((canvas) => canvas.width > 1));
  const letters = (slice) => slice.locator('.side').allTextContents();
  const slices = page.locator('.slice');
  assert.deepEqual(await letters(slices.nth(0)), ['R', 'L', 'A', 'P']);
  assert.deepEqual(await letters(slices.nth(1)), ['R', 'L', 'S', 'I']);
  assert.deepEqual(await letters(slices.nth(2)), ['A', 'P', 'S', 'I']);
  // The click on the mark in each slice selects its voxels; the slice after shows the mark at the upper left.
  const indexOf = async (axis) => Number(await page.getByLabel(`Voxel of the slice across ${axis}`).inputValue());
  const click = async (slice) => {
    const box = await slice.locator('.slice-frame').boundingBox();
    await page.mouse.click(box.x + 3, box.y + 3);
  };
  await click(slices.nth(0));
  assert.deepEqual([await indexOf('y'), await indexOf('z')], [11, 15]);
  await click(slices.nth(1));
  assert.deepEqual([await indexOf('x'), await indexOf('y'), await indexOf('z')], [7, 11, 15]);
  const isMarked = () => [...document.querySelectorAll('.slice canvas')].every((canvas) => {
    const at = (x, y) => canvas.getContext('2d').getImageData(x, y, 1, 1).data[0];
    return at(1, 1) === 255 && at(canvas.width - 2, canvas.height - 2) === 0 && at(1, canvas.height - 2) === 0;
  });
  await page.waitForFunction(isMarked);
  // Keys move the crosshair as the picture shows: to the patient's left, y falls.
  await slices.nth(0).locator('.slice-frame').focus();
  await page.keyboard.press('ArrowRight');
  assert.equal(await indexOf('y'), 10);
  await page.keyboard.press('ArrowDown');
  assert.equal(await indexOf('z'), 14);
});

onPage('key frames are saved with the job and played', 'ct', async (viewer, page) => {
  await viewer.section('keys');
  await page.getByRole('button', { name: 'Add this view' }).click();
  await viewer.drag('#surface', 150, 0);
  await page.getByRole('button', { name: 'Add this view' }).click();
  await viewer.settled();
  await page.getByLabel('Frame of key 2').fill('11');
  await page.getByLabel('Frame of key 2').press('Enter');
  await page.click('#save');
  await page.waitForFunction(() => document.getElementById('live').textContent.startsWith('Saved'));
  const { keyframes } = viewer.bodies('save').at(-1).job.camera;
  assert.deepEqual(keyframes.map((key) => key.frame), [1, 11]);
  await page.getByRole('button', { name: 'Go to key 1' }).click();
  await viewer.settled();
  const first = await viewer.picture();
  await page.getByRole('button', { name: 'Play' }).click();
  await page.waitForFunction(() => document.querySelector('.frame-place').textContent.startsWith('frame 11 of 11'));
  await viewer.settled();
  assert.notEqual(await viewer.picture(), first);
  const frames = viewer.bodies('frame').map((body) => body.frame).filter((frame) => frame !== undefined);
  assert.equal(frames.at(-1), 11);
});

onPage('the command, the cost and a render with cancel', 'ct', async (viewer, page) => {
  await page.click('#command');
  assert.match(await page.getByRole('textbox', { name: 'Command line' }).inputValue(), /kiln render/);
  await page.getByRole('button', { name: 'Close' }).first().click();
  await page.click('#render');
  await page.waitForFunction(() => /iB/.test(document.querySelector('.facts').textContent));
  await page.getByRole('button', { name: 'Render', exact: true }).click();
  await page.waitForFunction(() => document.querySelector('dialog[open] p[role=status]').textContent.startsWith('Wrote'), null, { timeout: 60_000 });
  assert.ok(readdirSync(folder.path).some((name) => name.endsWith('.png')));
  await page.locator('dialog[open]').getByLabel('Width').fill('4096');
  await page.locator('dialog[open]').getByLabel('Height').fill('4096');
  await page.getByRole('button', { name: 'Render', exact: true }).click();
  assert.deepEqual(viewer.bodies('render').at(-1).size, [4096, 4096]);
  await page.getByRole('button', { name: 'Cancel' }).click();
  await page.waitForFunction(() => document.querySelector('dialog[open] p[role=status]').textContent.startsWith('Cancelled'));
});

onPage('the final picture has the pixels of kiln render of the saved job', 'ct', async (viewer, page) => {
  await page.getByRole('button', { name: 'ct-bone', exact: true }).click();
  await viewer.drag('#surface', 90, 40);
  await viewer.settled();
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#keep')]);
  const shown = decodePng(readFileSync(await download.path()));
  const saved = page.waitForResponse((response) => response.url().endsWith('api/save'));
  await page.click('#save');
  const { path } = await (await saved).json();
  run(folder.path, 'render', path, '-o', 'again.png');
  const again = decodePng(readFileSync(join(folder.path, 'again.png')));
  assert.deepEqual([shown.width, shown.height, shown.channels], [again.width, again.height, again.channels]);
  assert.ok(shown.data.equals(again.data));
});

onPage('gradient opacity is added, edited and removed', 'ct', async (viewer, page) => {
  await page.getByRole('button', { name: 'ct-skin', exact: true }).click();
  await viewer.settled();
  const before = await viewer.picture();
  await page.getByRole('button', { name: 'Add a point of gradient opacity' }).click();
  await viewer.settled();
  const factors = () => viewer.job().transferFunction.gradientOpacity;
  assert.deepEqual(factors().map((point) => point.factor), [0, 1]);
  await page.getByLabel('Factor of the opacity at gradient 2').fill('0.1');
  await viewer.settled();
  assert.equal(factors()[1].factor, 0.1);
  assert.notEqual(await viewer.picture(), before);
  for (const _ of [0, 1]) {
    await page.getByRole('button', { name: 'Remove gradient 1' }).click();
    await viewer.settled();
  }
  assert.equal(factors(), undefined);
});

onPage('cut faces take colours, a window and an opacity', 'ct', async (viewer, page) => {
  await viewer.section('clip');
  await page.getByRole('button', { name: 'Facing' }).click();
  await viewer.settled();
  const plain = await viewer.picture();
  await page.selectOption('[aria-label="Cut faces"]', 'fire');
  await viewer.settled();
  assert.deepEqual(viewer.job().section, { colormap: 'fire' });
  const fire = await viewer.picture();
  assert.notEqual(fire, plain);
  await page.getByLabel('Window of the cut faces, width').fill('500');
  await viewer.settled();
  assert.equal(viewer.job().section.window[1], 500);
  await page.getByLabel('Opacity of the cut faces', { exact: true }).fill('0.5');
  await viewer.settled();
  assert.equal(viewer.job().section.opacity, 0.5);
  assert.notEqual(await viewer.picture(), fire);
  await page.selectOption('[aria-label="Cut faces"]', 'off');
  await viewer.settled();
  assert.equal(viewer.job().section, undefined);
  assert.equal(await viewer.picture(), plain);
});

onPage('slices of labels have the colours of the list', 'labels', async (viewer, page) => {
  await page.check('#show-slices');
  await page.locator('.labels input[type=color]').nth(1).fill('#00ff00');
  await viewer.settled();
  // Across y, label 7 is the upper half.
  const isGreen = () => {
    const canvas = document.querySelector('.slice.axis-1 canvas');
    const [r, g, b] = canvas.getContext('2d').getImageData(canvas.width / 2, canvas.height / 4, 1, 1).data;
    return r === 0 && g === 255 && b === 0;
  };
  await page.waitForFunction(isGreen);
});

onPage('the value under the pointer has the name of the label file', 'named', async (viewer, page) => {
  await page.check('#show-slices');
  await page.waitForFunction(() => [...document.querySelectorAll('.slice canvas')].every((canvas) => canvas.width > 1));
  const box = await page.locator('.slice.axis-1 .slice-frame').boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 4);
  await page.waitForFunction(() => document.querySelector('.readout').textContent.includes('value 7 (air way)'));
});

onPage('one of several volumes has a shading of its own', 'two', async (viewer, page) => {
  await viewer.section('light');
  const before = await viewer.picture();
  await page.selectOption('[aria-label="Shading of"]', 'one');
  await page.getByLabel('Ambient, ×').fill('0.9');
  await viewer.settled();
  assert.equal(viewer.job().volumes[0].shading.ambient, 0.9);
  assert.equal(viewer.job().volumes[1].shading, undefined);
  assert.equal(viewer.job().shading, undefined);
  assert.notEqual(await viewer.picture(), before);
  await page.getByRole('button', { name: 'As the others' }).click();
  await viewer.settled();
  assert.equal(viewer.job().volumes[0].shading, undefined);
  assert.equal(await viewer.picture(), before);
  // Cut faces are each volume's own.
  await viewer.section('clip');
  await page.getByRole('button', { name: 'Facing' }).click();
  await page.selectOption('[aria-label="Cut faces"]', 'gray');
  await viewer.settled();
  assert.deepEqual(viewer.job().volumes[0].section, { colormap: 'gray' });
  assert.equal(viewer.job().volumes[1].section, undefined);
});

onPage('each of several volumes has a function of its own', 'two', async (viewer, page) => {
  assert.equal(await page.getByRole('tab').count(), 2);
  await page.getByRole('button', { name: 'ct-skin', exact: true }).click();
  await viewer.settled();
  assert.equal(viewer.job().volumes[0].transferFunction, 'ct-skin');
  await page.getByRole('tab').nth(1).click();
  await page.locator('.labels .eye').nth(0).click();
  await viewer.settled();
  assert.equal(viewer.job().volumes[0].transferFunction, 'ct-skin');
  assert.equal(viewer.job().volumes[1].transferFunction.labels[0].opacity, 0);
});

test('without a token the page says what it needs', async () => {
  if (!viewers.has('ct')) viewers.set('ct', await startViewer(folder.path, ...kArguments.ct));
  const viewer = await ViewerPage.open(browser, viewers.get('ct').url.split('#')[0]);
  await viewer.page.waitForFunction(() => document.getElementById('message').textContent.includes('#'));
  await viewer.close();
});

async function worksAt(url) {
  const viewer = await ViewerPage.open(browser, url);
  await viewer.settled();
  const first = await viewer.picture();
  await viewer.drag('#surface', 80, 30);
  await viewer.settled();
  assert.notEqual(await viewer.picture(), first);
  assert.deepEqual(viewer.faults, []);
  await viewer.close();
}

test('the page works below a prefix of a proxy', { timeout: 120_000 }, async () => {
  const viewer = await startViewer(folder.path, 'head.kiln', '--allow-host', 'localhost');
  const { port, hash } = new URL(viewer.url);
  const proxy = await prefixProxy('/user/a/proxy/kiln/', Number(port));
  try {
    await worksAt(`http://localhost:${proxy.port}/user/a/proxy/kiln/${hash}`);
  } finally {
    proxy.stop();
    await viewer.stop();
  }
});

test('the page works through a forwarded socket', { timeout: 120_000 }, async () => {
  const socket = join(folder.path, 'viewer.socket');
  const viewer = await startViewer(folder.path, 'head.kiln', '--socket', socket);
  const forward = await forwardToSocket(socket);
  try {
    await worksAt(`http://localhost:${forward.port}/${new URL(viewer.url).hash}`);
  } finally {
    forward.stop();
    await viewer.stop();
  }
});

async function requireAccessible(page) {
  for (const scheme of ['light', 'dark']) {
    await page.emulateMedia({ colorScheme: scheme });
    // The protocol of the browser evaluates the script; the page's own policy forbids scripts of others.
    await page.evaluate(axeSource());
    const { violations } = await page.evaluate(() => window.axe.run());
    const serious = violations.filter((fault) => ['serious', 'critical'].includes(fault.impact));
    assert.deepEqual(serious.map((fault) => `${fault.id}: ${fault.nodes.slice(0, 3).map((node) => node.html.slice(0, 160)).join(' | ')}`), []);
  }
}

onPage('axe finds nothing serious in dialogs and among tabs', 'two', async (viewer, page) => {
  await requireAccessible(page);
  for (const id of ['help-button', 'command', 'render']) {
    await page.click(`#${id}`);
    await page.waitForSelector('dialog[open]');
    await requireAccessible(page);
    await page.locator('dialog[open]').getByRole('button', { name: 'Close' }).click();
  }
});

for (const [width, height] of [[320, 640], [360, 740], [1280, 800], [3840, 2160]]) {
  for (const kind of ['ct', 'labels']) {
    onPage(`nothing sticks out and axe finds nothing serious at ${width} pixels: ${kind}`, kind, async (viewer, page) => {
      for (const name of ['light', 'clip', 'camera', 'image', 'keys']) await viewer.section(name);
      await page.getByRole('button', { name: 'Add this view' }).click();
      await page.getByRole('button', { name: 'Facing' }).click();
      await page.getByLabel('Clip box', { exact: true }).check();
      await page.check('#show-slices');
      await viewer.settled();
      const wide = await page.evaluate(() => [...document.querySelectorAll('body, #panels, .bar, .view-bar, #status, .inside')]
        .filter((node) => node.scrollWidth > node.clientWidth + 1).map((node) => `${node.id || node.className} ${node.scrollWidth} > ${node.clientWidth}`));
      assert.deepEqual(wide, []);
      await requireAccessible(page);
    }, { width, height });
  }
}
