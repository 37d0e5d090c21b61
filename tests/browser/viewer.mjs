// Starts `kiln view` and a browser for a test.
//
// Needs: node 20 or later; Debian's package chromium (or CHROMIUM, the path of another); the npm packages playwright-core
// and axe-core in the folder KILN_BROWSER_MODULES (the folder that holds node_modules). KILN is the path of the program.
import { createRequire } from 'node:module';
import { createServer as createHttpServer, request as httpRequest } from 'node:http';
import { connect, createServer as createTcpServer } from 'node:net';
import { execFileSync, spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { inflateSync } from 'node:zlib';

const kStart_ms = 30_000;
const modules = createRequire(join(process.env.KILN_BROWSER_MODULES ?? process.cwd(), 'package.json'));
if (!process.env.KILN) throw new Error('KILN: the path of the program is missing');
const kiln = process.env.KILN;
export const axeSource = () => readFileSync(modules.resolve('axe-core/axe.min.js'), 'utf8');

export function launchBrowser() {
  return modules('playwright-core').chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--headless', '--no-sandbox', '--disable-gpu', '--disable-background-networking', '--no-first-run'],
  });
}

/** Runs a command of the program in a folder and returns its output. */
export const run = (folder, ...args) => execFileSync(kiln, args, { cwd: folder, encoding: 'utf8' });

/** Returns a folder for the files of a test file; `close()` removes it. */
export function workFolder() {
  const path = mkdtempSync(join(tmpdir(), 'kiln-view-'));
  return { path, close: () => rmSync(path, { recursive: true, force: true }) };
}

/** Starts the viewer in a folder; returns its address and `stop()`. */
export async function startViewer(folder, ...args) {
  const child = spawn(kiln, ['view', ...args, '--no-browser'], { cwd: folder, stdio: ['pipe', 'pipe', 'pipe'] });
  let output = '';
  const url = await new Promise((resolve, reject) => {
    const late = setTimeout(() => reject(new Error(`kiln view printed no address in ${kStart_ms} ms: ${output}`)), kStart_ms);
    const look = (data) => {
      output += data;
      const found = /http:\/\/[^\s]+/.exec(output);
      if (!found || !/\s/.test(output.slice(found.index))) return;
      clearTimeout(late);
      resolve(found[0]);
    };
    child.stdout.on('data', look);
    child.stderr.on('data', look);
    child.on('exit', (code) => reject(new Error(`kiln view ended with ${code}: ${output}`)));
  });
  return { url, stop: () => new Promise((resolve) => { child.on('exit', resolve); child.kill('SIGTERM'); }) };
}

async function listening(server) {
  await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
  return { port: server.address().port, stop: () => { server.closeAllConnections?.(); server.close(); } };
}

/** Serves a viewer below a prefix, as JupyterHub and Open OnDemand do: Host and Origin stay those of the proxy. */
export function prefixProxy(prefix, port) {
  return listening(createHttpServer((request, answer) => {
    if (!request.url.startsWith(prefix)) {
      answer.writeHead(404).end();
      return;
    }
    const { method, headers } = request;
    const onward = httpRequest({ host: '127.0.0.1', port, method, headers, path: request.url.slice(prefix.length - 1) }, (found) => {
      answer.writeHead(found.statusCode, found.headers);
      found.pipe(answer);
    });
    onward.on('error', () => answer.destroy());
    answer.on('close', () => onward.destroy());
    request.pipe(onward);
  }));
}

/** Forwards a port to a socket, as `ssh -L PORT:SOCKET` does. */
export function forwardToSocket(path) {
  return listening(createTcpServer((from) => {
    const to = connect(path);
    from.pipe(to).pipe(from);
    for (const end of [from, to]) end.on('error', () => { from.destroy(); to.destroy(); });
  }));
}

/** A page of the viewer, with what it sent. */
export class ViewerPage {
  constructor(page, url) {
    this.page = page;
    this.url = url;
    this.requests = [];
    this.faults = [];
    page.on('request', (request) => this.requests.push(request));
    page.on('pageerror', (error) => this.faults.push(error.message));
    page.on('console', (message) => { if (message.type() === 'error') this.faults.push(message.text()); });
  }

  static async open(browser, url, { width = 1280, height = 800 } = {}) {
    const context = await browser.newContext({ viewport: { width, height }, acceptDownloads: true });
    const out = new ViewerPage(await context.newPage(), url);
    await out.page.goto(url);
    return out;
  }

  close() { return this.page.context().close(); }

  /** Waits for the picture as the batch draws it, of the newest job. */
  async settled() {
    await this.page.waitForTimeout(200);
    await this.page.waitForFunction(() => document.getElementById('badge').textContent === 'as rendered', null, { timeout: kStart_ms });
  }

  bodies(name) {
    return this.requests.filter((request) => new URL(request.url()).pathname.endsWith(`api/${name}`)).map((request) => request.postDataJSON());
  }
  /** Returns the job that the page drew last. */
  job() { return this.bodies('frame').at(-1).job; }

  /** Opens a section of the settings. */
  async section(name) {
    await this.page.evaluate((id) => { document.getElementById(`${id}-section`).open = true; }, name);
  }

  /** Returns a number that changes with the picture. */
  picture() {
    return this.page.evaluate(() => {
      const canvas = document.getElementById('picture');
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      let sum = 0;
      for (let i = 0; i < data.length; ++i) sum = (sum * 31 + data[i]) | 0;
      return sum;
    });
  }

  /** Drags by pixels from the middle of an element, in steps. */
  async drag(target, dx, dy, { steps = 5, modifiers = [], from } = {}) {
    const box = await (typeof target === 'string' ? this.page.locator(target) : target).boundingBox();
    const x = from ? box.x + from[0] : box.x + box.width / 2, y = from ? box.y + from[1] : box.y + box.height / 2;
    for (const key of modifiers) await this.page.keyboard.down(key);
    await this.page.mouse.move(x, y);
    await this.page.mouse.down();
    await this.page.mouse.move(x + dx, y + dy, { steps });
    await this.page.mouse.up();
    for (const key of modifiers) await this.page.keyboard.up(key);
  }
}

/** Returns the pixels of a PNG of 8 bits a channel, without interlacing: {width, height, channels, data}. */
export function decodePng(bytes) {
  let at = 8, width = 0, height = 0, channels = 0;
  const parts = [];
  while (at < bytes.length) {
    const size = bytes.readUInt32BE(at), name = bytes.toString('latin1', at + 4, at + 8), body = bytes.subarray(at + 8, at + 8 + size);
    if (name === 'IHDR') {
      [width, height] = [body.readUInt32BE(0), body.readUInt32BE(4)];
      channels = { 0: 1, 2: 3, 4: 2, 6: 4 }[body[9]];
      if (body[8] !== 8 || body[12] !== 0 || !channels) throw new Error('PNG: expected 8 bits a channel, not interlaced');
    } else if (name === 'IDAT') {
      parts.push(body);
    }
    at += 12 + size;
  }
  const raw = inflateSync(Buffer.concat(parts)), row = width * channels, data = Buffer.alloc(height * row);
  for (let y = 0; y < height; ++y) {
    const filter = raw[y * (row + 1)];
    for (let i = 0; i < row; ++i) {
      const a = i >= channels ? data[y * row + i - channels] : 0, b = y > 0 ? data[(y - 1) * row + i] : 0;
      const c = i >= channels && y > 0 ? data[(y - 1) * row + i - channels] : 0;
      const p = a + b - c, [pa, pb, pc] = [Math.abs(p - a), Math.abs(p - b), Math.abs(p - c)];
      const guess = [0, a, b, (a + b) >> 1, pa <= pb && pa <= pc ? a : pb <= pc ? b : c][filter];
      data[y * row + i] = raw[y * (row + 1) + 1 + i] + guess;
    }
  }
  return { width, height, channels, data };
}
