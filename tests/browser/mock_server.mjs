// A stand-in for `kiln view` while the page is developed: the protocol, and pictures of a ball in a box.
import { createServer } from 'node:http';
import { readFileSync } from 'node:fs';
import { deflateSync } from 'node:zlib';
import { fileURLToPath } from 'node:url';
import { join } from 'node:path';
import { rayThrough } from '../../tools/kiln/view/page/camera.js';
import { add, cross, dot, normalize, scale, subtract } from '../../tools/kiln/view/page/vector.js';

const kind = process.argv[2] ?? 'ct';
const delay = Number(process.env.MOCK_DELAY ?? 20);
const page = fileURLToPath(new URL('../../tools/kiln/view/page/', import.meta.url));
const token = 'mocktoken';
const types = { html: 'text/html; charset=utf-8', js: 'text/javascript; charset=utf-8', css: 'text/css; charset=utf-8' };
const csp = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const voxels = [128, 128, 96], spacing = [1.5, 1.5, 2];
const affine = [[1.5, 0, 0, -96], [0, 1.5, 0, -96], [0, 0, 2, 1600]];
const counts = Array.from({ length: 256 }, (_, i) => Math.round(1e6 * Math.exp(-i / 9) + 2e5 * Math.exp(-(((i - 120) / 14) ** 2)) + 3e4 * Math.exp(-(((i - 185) / 20) ** 2))));
const ct = { name: 'head', voxels, type: 'i16', spacing, unit: 'mm', affine, patient: true, range: [-1024, 3071], levels: 4, classes: 'values', labels: [], histogram: { low: -1024, high: 3071, counts } };
const organs = { ...ct, name: 'organs', type: 'u8', range: [0, 7], classes: 'labels', histogram: { low: 0, high: 7, counts: counts.slice(0, 8) },
  labels: ['skin', 'muscle', 'liver', 'left kidney', 'right kidney', 'bone'].map((name, i) => ({ value: i + 1, name, color: ['#e0b090', '#a03020', '#803020', '#c0a040', '#40a0c0', '#f0f0e0'][i] })) };
const volumes = kind === 'labels' ? [organs] : kind === 'two' ? [ct, organs] : [ct];
const job = { kiln: 2, ...(kind === 'two' ? { volumes: [{ transferFunction: 'ct-bone' }, {}] } : kind === 'labels' ? {} : { transferFunction: 'ct-bone-and-skin' }) };
const session = { version: '0.9', title: volumes.map((v) => v.name).join(' + '), jobFile: null, job, volumes, box: { min: [-96.75, -96.75, 1599], max: [95.25, 95.25, 1791] },
  presets: ['auto', 'ct-skin', 'ct-bone', 'ct-bone-and-skin', 'ct-muscle', 'ct-lung', 'ct-vessels', 'fog', 'grayscale', 'viridis', 'plasma', 'inferno', 'fire'], memory: 2 ** 31, threads: 2, largest: 4096 };

const bone = { unit: 1, colorSpace: 'linear', points: [{ value: -300, color: [0.8, 0.5, 0.35], opacity: 0 }, { value: -50, color: [0.8, 0.5, 0.35], opacity: 0.03 }, { value: 180, color: [0.85, 0.3, 0.2], opacity: 0.02 }, { value: 350, color: [0.9, 0.85, 0.7], opacity: 0.4 }, { value: 1400, color: [1, 1, 0.95], opacity: 0.9 }] };
const map = { unit: 1.6667, colorSpace: 'linear', points: Array.from({ length: 64 }, (_, i) => ({ value: -800 + i * 40, color: [i / 63, (i / 63) ** 2, 0.4 - 0.4 * (i / 63)], opacity: (i / 63) ** 2 * 0.5 })) };
function functionOf(given, index, window) {
  let fn = typeof given === 'object' ? given : volumes[index].classes === 'labels'
    ? { unit: 1.67, colorSpace: 'linear', labels: organs.labels.map((l) => ({ label: l.value, name: l.name, color: l.color, opacity: 1 })) }
    : ['viridis', 'plasma', 'inferno', 'fire', 'grayscale'].includes(given) ? map : bone;
  if (window && fn.points) {
    const [first, last] = [fn.points[0].value, fn.points[fn.points.length - 1].value];
    fn = { ...fn, points: fn.points.map((p) => ({ ...p, value: window[0] - window[1] / 2 + ((p.value - first) / (last - first)) * window[1] })) };
  }
  return fn;
}
const functionsOf = (j) => volumes.map((_, i) => { const own = j.volumes?.[i] ?? j; return functionOf(own.transferFunction, i, own.window); });

const centre = [0, 1, 2].map((a) => (session.box.min[a] + session.box.max[a]) / 2);
function cameraOf(j, frame) {
  let c = { ...(j.camera ?? {}) };
  if (frame !== undefined && c.keyframes) {
    const after = c.keyframes.findIndex((k) => k.frame >= frame);
    const b = c.keyframes[after < 0 ? c.keyframes.length - 1 : after], a = c.keyframes[Math.max(0, (after < 0 ? c.keyframes.length : after) - 1)];
    const t = b.frame > a.frame ? (frame - a.frame) / (b.frame - a.frame) : 0;
    for (const key of ['eye', 'target', 'up']) c[key] = a[key].map((v, i) => v * (1 - t) + b[key][i] * t);
    if (a.fov) c.fov = a.fov;
    if (a.height) c.height = a.height;
  }
  if (!c.eye) {
    const to = { front: [0, -1, 0], back: [0, 1, 0], left: [1, 0, 0], right: [-1, 0, 0], top: [0, 0, 1], bottom: [0, 0, -1] }[c.view] ?? [0.48, -0.84, 0.26];
    c = { ...c, eye: add(centre, scale(to, 520)), target: centre, up: Math.abs(to[2]) > 0.9 ? [0, -1, 0] : [0, 0, 1] };
  }
  return c.projection === 'orthographic' ? { projection: 'orthographic', eye: c.eye, target: c.target, up: c.up, height: c.height ?? 260 } : { projection: 'perspective', eye: c.eye, target: c.target, up: c.up, fov: c.fov ?? 30 };
}

function png(width, height, pixel) {
  const raw = Buffer.alloc(height * (1 + 4 * width));
  for (let y = 0, at = 0; y < height; ++y) {
    raw[at++] = 0;
    for (let x = 0; x < width; ++x) for (const v of pixel(x, y)) raw[at++] = v;
  }
  const table = png.table ??= Array.from({ length: 256 }, (_, n) => { for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1; return n >>> 0; });
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]);
    let crc = ~0;
    for (const byte of body) crc = table[(crc ^ byte) & 255] ^ (crc >>> 8);
    const out = Buffer.alloc(8 + body.length);
    out.writeUInt32BE(data.length);
    body.copy(out, 4);
    out.writeUInt32BE(~crc >>> 0, 4 + body.length);
    return out;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width);
  head.writeUInt32BE(height, 4);
  head.set([8, 6, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from([0x89, 80, 78, 71, 13, 10, 26, 10]), chunk('IHDR', head), chunk('IDAT', deflateSync(raw, { level: 1 })), chunk('IEND', Buffer.alloc(0))]);
}

const to8 = (v) => Math.max(0, Math.min(255, Math.round(255 * Math.max(0, v) ** (1 / 2.2))));
function draw(j, camera, width, height) {
  const size = { width, height };
  const fn = functionsOf(j)[0];
  const color = fn.points ? fn.points[Math.min(2, fn.points.length - 1)].color : '#d0a080';
  const base = typeof color === 'string' ? [1, 3, 5].map((i) => (parseInt(color.slice(i, i + 2), 16) / 255) ** 2.2) : color;
  const region = (j.volumes?.[0] ?? j).region ?? [0, 0, 0, ...voxels];
  const lo = [0, 1, 2].map((a) => affine[a][3] + (region[a] - 0.5) * spacing[a]), hi = [0, 1, 2].map((a) => affine[a][3] + (region[a + 3] - 0.5) * spacing[a]);
  const planes = [...(Array.isArray(j.clip) ? j.clip : []), ...[0, 1, 2].flatMap((a) => { const n = [0, 0, 0]; n[a] = 1; return [{ normal: n, offset: -lo[a] }, { normal: scale(n, -1), offset: hi[a] }]; })];
  const light = normalize([-0.4, -0.8, 0.6]);
  const hash = [...JSON.stringify([fn, j.look, j.lights, j.mode, j.samples])].reduce((a, c) => (a * 31 + c.charCodeAt(0)) % 997, 7);
  const gain = 2 ** (j.display?.exposure ?? 0) * (1 + hash / 2000);
  return png(width, height, (x, y) => {
    const { from, direction } = rayThrough(camera, size, { x: x + 0.5, y: y + 0.5 });
    const rel = subtract(from, centre), b = dot(rel, direction), disc = b * b - dot(rel, rel) + 88 * 88;
    if (disc <= 0) return [0, 0, 0, 0];
    let [t0, t1, normal] = [-b - Math.sqrt(disc), -b + Math.sqrt(disc), null];
    for (const plane of planes) {
      const slope = dot(plane.normal, direction), at = dot(plane.normal, from) + plane.offset;
      const t = -at / slope;
      if (slope > 0 && t > t0) [t0, normal] = [t, plane.normal];
      else if (slope < 0 && t < t1) t1 = t;
      else if (slope === 0 && at < 0) return [0, 0, 0, 0];
    }
    if (t0 >= t1) return [0, 0, 0, 0];
    const point = add(from, scale(direction, t0));
    let n = normal ? scale(normalize(normal), -1) : normalize(subtract(point, centre));
    const bump = Math.sin(point[0] / 9) * Math.sin(point[1] / 11) * Math.sin(point[2] / 8);
    const lit = (0.2 + 0.8 * Math.max(0, dot(n, light))) * (0.8 + 0.25 * bump) * gain;
    return [to8(base[0] * lit), to8(base[1] * lit), to8(base[2] * lit), 255];
  });
}

const record = (head, payload = Buffer.alloc(0)) => {
  const json = Buffer.from(JSON.stringify(head));
  const out = Buffer.alloc(8 + json.length + payload.length);
  out.writeUInt32LE(json.length);
  json.copy(out, 4);
  out.writeUInt32LE(payload.length, 4 + json.length);
  payload.copy(out, 8 + json.length);
  return out;
};
const sleep = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

const world = (v) => affine.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + row[3]);
const valueAt = (v) => { const r = Math.hypot(...subtract(world(v), centre)); return Math.round(r < 60 ? 900 - 8 * Math.abs(r - 50) : r < 88 ? 40 : -1000); };

const api = {
  async frame({ seq, size, moving, job: j, frame }, answer) {
    const camera = cameraOf(j, frame);
    answer.write(record({ kind: 'resolved', seq, camera, transferFunctions: functionsOf(j) }));
    const picture = async (stage, share, asRendered) => {
      await sleep(delay);
      if (answer.destroyed) return;
      const [w, h] = size.map((s) => Math.max(1, Math.round(s * share)));
      const start = Date.now();
      const data = draw(j, camera, w, h);
      answer.write(record({ kind: 'picture', seq, stage, type: 'image/png', width: w, height: h, level: asRendered ? [0, 1] : [2, 2], bricks: 12, bytesRead: 3400000, seconds: (Date.now() - start) / 1000, asRendered }, data));
    };
    await picture('preview', 0.2, false);
    if (!moving) { await picture('refined', 0.4, false); await picture('final', 1, true); }
    answer.end(record({ kind: 'end', seq }));
  },
  async slice({ axis, index, size }, answer) {
    const [c, r] = { x: [1, 2], y: [0, 2], z: [0, 1] }[axis], a = { x: 0, y: 1, z: 2 }[axis];
    const [w, h] = size ?? [128, 128];
    const data = png(w, h, (x, y) => {
      const v = [0, 0, 0];
      v[a] = index; v[c] = (x / w) * voxels[c]; v[r] = (axis === 'z' ? y / h : 1 - y / h) * voxels[r];
      const g = Math.max(0, Math.min(255, Math.round(((valueAt(v) + 1024) / 2400) * 255)));
      return [g, g, g, 255];
    });
    answer.write(record({ kind: 'slice', axis, index, level: 0, width: w, height: h, voxelSize: [1.5, 1.5] }, data));
    answer.end(record({ kind: 'end' }));
  },
  probe: ({ voxel }) => ({ value: valueAt(voxel), label: null, world: world(voxel) }),
  thumbnail: ({ preset, size, job: j }) => draw({ ...j, transferFunction: preset }, cameraOf(j), ...size),
  function: ({ text }) => { const given = JSON.parse(text); const fn = Array.isArray(given) ? given[0] : given; if (!fn.points && !fn.RGBPoints) throw new Error('dropped file: expected points or RGBPoints'); return { transferFunction: fn.points ? fn : map }; },
  resolve: ({ job: j }) => ({ camera: cameraOf(j), transferFunctions: functionsOf(j) }),
  command: ({ size }) => ({ command: `kiln render /data/head.kiln -o head.png --size ${size.join('x')} --tf ct-bone-and-skin` }),
  estimate: () => ({ memory: 310000000, bricks: 120, bytes: 8800000, seconds: 1.4 }),
  save: ({ job: j }) => ({ path: 'head.view.json', bytes: JSON.stringify(j).length }),
  async render(_, answer) {
    for (let done = 0; done <= 20 && !answer.destroyed; ++done) { answer.write(record({ kind: 'progress', done, total: 20, unit: 'tiles' })); await sleep(60); }
    answer.end(record({ kind: 'written', path: 'head.view.png', bytes: 123456 }));
  },
};

const server = createServer(async (request, answer) => {
  const path = new URL(request.url, 'http://x').pathname;
  answer.setHeader('Content-Security-Policy', csp);
  const fail = (status, error) => { answer.writeHead(status, { 'Content-Type': 'application/json' }); answer.end(JSON.stringify({ error })); };
  try {
    if (!path.startsWith('/api/')) {
      const name = path === '/' ? 'index.html' : path.slice(1);
      if (!/^[\w.]+$/.test(name)) return fail(404, 'no such page');
      answer.writeHead(200, { 'Content-Type': types[name.split('.').pop()] });
      return answer.end(readFileSync(join(page, name)));
    }
    if (request.headers.authorization !== `Bearer ${token}`) return fail(401, 'token missing');
    const name = path.slice(5);
    if (name === 'session') { answer.writeHead(200, { 'Content-Type': 'application/json' }); return answer.end(JSON.stringify(session)); }
    const parts = [];
    for await (const part of request) parts.push(part);
    const body = JSON.parse(Buffer.concat(parts).toString());
    if (!api[name]) return fail(404, 'no such request');
    if (['frame', 'slice', 'render'].includes(name)) { answer.writeHead(200, { 'Content-Type': 'application/octet-stream' }); return await api[name](body, answer); }
    const out = api[name](body);
    const isImage = Buffer.isBuffer(out);
    answer.writeHead(200, { 'Content-Type': isImage ? 'image/png' : 'application/json' });
    answer.end(isImage ? out : JSON.stringify(out));
  } catch (error) {
    if (!answer.headersSent) fail(400, error.message);
    else answer.destroy();
  }
});
server.listen(Number(process.env.MOCK_PORT ?? 0), '127.0.0.1', () => console.log(`http://127.0.0.1:${server.address().port}/#${token}`));
