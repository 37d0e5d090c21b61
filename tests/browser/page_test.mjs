// The page's modules without a browser, against answers known from geometry and arithmetic. Needs node only.
import test from 'node:test';
import assert from 'node:assert/strict';
import * as cameras from '../../tools/kiln/view/page/camera.js';
import { distance, dot, inverseAffine, normalize, subtract, transformPoint } from '../../tools/kiln/view/page/vector.js';
import { cornersOf, cornersOfWorld, onSphere, sectionOf } from '../../tools/kiln/view/page/box_geometry.js';
import { RecordReader } from '../../tools/kiln/view/page/protocol.js';
import { JobState } from '../../tools/kiln/view/page/state.js';
import { at, simplified, withItem, withNewItem } from '../../tools/kiln/view/page/transfer_function.js';
import { hexOf, hexOfLinear, linearOf } from '../../tools/kiln/view/page/color.js';
import { axisNames } from '../../tools/kiln/view/page/orientation.js';
import { duration, short, ticks } from '../../tools/kiln/view/page/numbers.js';

const size = { width: 400, height: 300 };
// Seen from the front: x to the right, z up, as Kiln's front side of a volume.
const perspective = { projection: 'perspective', eye: [10, -90, 5], target: [10, 10, 5], up: [0, 0, 1], fov: 60 };
const parallel = { projection: 'orthographic', eye: [10, -90, 5], target: [10, 10, 5], up: [0, 0, 1], height: 30 };

function near(a, b, tolerance = 1e-9) {
  const [left, right] = [a, b].map((v) => (Array.isArray(v) ? v : [v]));
  left.forEach((v, i) => assert.ok(Math.abs(v - right[i]) <= tolerance, `${JSON.stringify(a)} is not ${JSON.stringify(b)}`));
}

test('a point right of the target is right of the middle by its share of the picture', () => {
  const pixel = cameras.pixelOf(parallel, size, [13, 10, 5]);
  near([pixel.x, pixel.y], [200 + 3 * 10, 150]);
  // At the target's depth of 100, the picture of 60 degrees spans 2·100·tan 30°.
  const seen = cameras.pixelOf(perspective, size, [10, 10, 5 + 100 * Math.tan(Math.PI / 6)]);
  near([seen.x, seen.y], [200, 0], 1e-6);
});

test('a ray through a pixel meets the point that the pixel shows', () => {
  for (const camera of [perspective, parallel]) {
    const world = [17, 30, -4];
    const { from, direction } = cameras.rayThrough(camera, size, cameras.pixelOf(camera, size, world));
    const along = dot(subtract(world, from), direction);
    near(from.map((v, i) => v + along * direction[i]), world, 1e-9);
  }
});

test('an orbit keeps the distance and the up direction, and a drag to the right moves the eye to the left', () => {
  const turned = cameras.orbit(perspective, 60, 0, size);
  near(distance(turned.eye, turned.target), 100);
  assert.deepEqual(turned.up, perspective.up);
  assert.ok(turned.eye[0] < perspective.eye[0]);
  // A drag along the shorter side is half a turn.
  near(cameras.orbit(perspective, 300, 0, size).eye, [10, 110, 5], 1e-9);
  assert.ok(cameras.orbit(perspective, 0, 40, size).eye[2] > perspective.eye[2]);
});

test('an orbit stops before the poles', () => {
  let camera = perspective;
  for (let i = 0; i < 50; ++i) camera = cameras.orbit(camera, 3, 40, size);
  const sine = Math.sqrt(1 - dot(normalize(subtract(camera.eye, camera.target)), camera.up) ** 2);
  assert.ok(sine > 0.015);
  near(distance(camera.eye, camera.target), 100);
});

test('content under the pointer follows a pan, and keeps its pixel in a zoom', () => {
  for (const camera of [perspective, parallel]) {
    const world = [12, 10, 9];
    const before = cameras.pixelOf(camera, size, world);
    const panned = cameras.pixelOf(cameras.pan(camera, 31, -17, size), size, world);
    near([panned.x, panned.y], [before.x + 31, before.y - 17], 1e-9);
    const zoomed = cameras.pixelOf(cameras.zoom(camera, 1.7, size, before), size, world);
    near([zoomed.x, zoomed.y], [before.x, before.y], 1e-9);
    near(cameras.heightAtTarget(cameras.zoom(camera, 2, size)), cameras.heightAtTarget(camera) / 2, 1e-9);
  }
});

test('a roll of a quarter turn moves the right of the picture to its top', () => {
  const right = cameras.pixelOf(cameras.roll(parallel, Math.PI / 2), size, [13, 10, 5]);
  near([right.x, right.y], [200, 150 - 30]);
});

test('a change of the projection or of the field of view keeps the size at the target', () => {
  const flat = cameras.withProjection(perspective, 'orthographic', 50);
  near(flat.height, cameras.heightAtTarget(perspective));
  assert.equal(flat.fov, undefined);
  const back = cameras.withProjection(flat, 'perspective', 50);
  near(cameras.heightAtTarget(back), flat.height);
  near(cameras.heightAtTarget(cameras.withFov(perspective, 20)), cameras.heightAtTarget(perspective));
});

test('corners of a box lie half a voxel before its numbers', () => {
  const affine = [[2, 0, 0, 10], [0, 0, 3, 20], [0, 5, 0, 30]];
  const corners = cornersOf(affine, [0, 0, 0, 4, 4, 4]);
  near(corners[0], [10 - 1, 20 - 1.5, 30 - 2.5]);
  near(corners[7], [10 + 7, 20 + 10.5, 30 + 17.5]);
  near(transformPoint(inverseAffine(affine), corners[7]), [3.5, 3.5, 3.5]);
});

test('a plane through the middle of a cube cuts a hexagon, a plane beside it nothing', () => {
  const corners = cornersOfWorld({ min: [0, 0, 0], max: [1, 1, 1] });
  assert.equal(sectionOf({ normal: [1, 1, 1], offset: -1.5 }, corners).length, 6);
  assert.equal(sectionOf({ normal: [1, 0, 0], offset: -0.5 }, corners).length, 4);
  assert.equal(sectionOf({ normal: [1, 0, 0], offset: 2 }, corners).length, 0);
});

test('a pointer beside a sphere turns to its edge', () => {
  const ray = { from: [0, 0, -10], direction: [0, 0, 1] };
  near(onSphere(ray, [0, 0, 0], 2, true), [0, 0, -2]);
  near(onSphere(ray, [0, 0, 0], 2, false), [0, 0, 2]);
  near(onSphere(ray, [0, -5, 0], 2, true), [0, -3, 0]);
});

test('records are found in a stream that is cut anywhere', () => {
  const encode = (head, payload) => {
    const json = new TextEncoder().encode(JSON.stringify(head));
    const out = new Uint8Array(8 + json.length + payload.length), view = new DataView(out.buffer);
    view.setUint32(0, json.length, true);
    out.set(json, 4);
    view.setUint32(4 + json.length, payload.length, true);
    out.set(payload, 8 + json.length);
    return out;
  };
  const stream = [...encode({ kind: 'picture', name: 'ä' }, [1, 2, 3]), ...encode({ kind: 'end' }, [])];
  for (let cut = 0; cut <= stream.length; ++cut) {
    const reader = new RecordReader();
    const records = [...reader.push(new Uint8Array(stream.slice(0, cut))), ...reader.push(new Uint8Array(stream.slice(cut)))];
    assert.deepEqual(records.map((r) => r.head), [{ kind: 'picture', name: 'ä' }, { kind: 'end' }]);
    assert.deepEqual([...records[0].payload], [1, 2, 3]);
  }
});

test('undo restores the very job, and a gesture is one step', () => {
  const first = { kiln: 2, samples: 1 };
  const state = new JobState(first);
  for (const samples of [2, 4, 16]) state.change('samples', (job) => ({ ...job, samples }), { merge: 'drag' });
  state.endGesture();
  state.change('mode', (job) => ({ ...job, mode: 'mip' }), { merge: 'drag' });
  state.change('mode', (job) => ({ ...job, mode: 'mip' }));
  assert.equal(state.undo(), 'mode');
  assert.equal(state.undo(), 'samples');
  assert.equal(state.job, first);
  assert.equal(state.undo(), null);
  assert.equal(state.redo(), 'samples');
  assert.equal(state.job.samples, 16);
});

test('a function is even between points and constant beyond', () => {
  const fn = { colorSpace: 'linear', points: [{ value: 0, color: [0, 0, 0], opacity: 0 }, { value: 10, color: [1, 0.5, 0], opacity: 0.4 }] };
  near([...at(fn, 5).color, at(fn, 5).opacity], [0.5, 0.25, 0, 0.2]);
  near([at(fn, -3).opacity, at(fn, 30).opacity], [0, 0.4]);
  assert.equal(withItem(fn, 0, { value: 20 }).points[0].value, 10);
  const grown = withNewItem(fn, 5, 0.2);
  assert.equal(grown.index, 1);
  assert.equal(simplified(grown.fn, 0.01).points.length, 2);
});

test('colours keep their bytes through linear light', () => {
  for (const hex of ['#000000', '#0a80ff', '#ffffff', '#123456']) assert.equal(hexOfLinear(linearOf(hex)), hex);
  assert.equal(hexOf('#f80'), '#ff8800');
  assert.equal(hexOf([1, 0.5, 0]), '#ff8000');
});

test('numbers for people', () => {
  assert.equal(short(1234.5678), '1235');
  assert.equal(short(0.012345), '0.01235');
  assert.equal(duration(0.0421), '42 ms');
  assert.deepEqual(ticks(-5, 25, 3), [0, 10, 20]);
});

test('names of axes follow the frame of the file', () => {
  assert.deepEqual(axisNames({ frame: 'RAS' }), ['R', 'A', 'S']);
  assert.deepEqual(axisNames({ frame: 'LPS' }), ['L', 'P', 'S']);
  assert.deepEqual(axisNames({}), ['x', 'y', 'z']);
});

test('surfaces keep different values, and have a colour and an opacity', () => {
  const fn = { surfaces: [{ value: 100 }, { value: 200, opacity: 0.3, color: '#f80' }] };
  const moved = withItem(fn, 0, { value: 500 });
  assert.ok(moved.surfaces[0].value < 200);
  assert.equal(moved.surfaces[0].opacity, 1);
  const grown = withNewItem(fn, 150, 0.5);
  assert.deepEqual([grown.index, grown.fn.surfaces.length, grown.fn.surfaces[1].opacity], [1, 3, 0.5]);
});
