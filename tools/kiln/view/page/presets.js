// The presets as pictures of this volume. Pictures are requested one at a time, while the main picture is at rest.
import { html, replace } from './element.js';

const kSize_px = 96;
const kWait_ms = 200;

export class Presets {
  #server;
  #onChoose;
  #isIdle;
  #round = 0;
  #tiles = new Map();

  /** onChoose(name); isIdle() returns whether the main picture is at rest. */
  constructor({ server, names, onChoose, isIdle }) {
    this.#server = server;
    this.#onChoose = onChoose;
    this.#isIdle = isIdle;
    for (const name of names) {
      const image = html('img', { alt: '', width: kSize_px, height: kSize_px });
      const tile = html('button', { type: 'button', class: 'preset', 'aria-pressed': 'false', onclick: () => onChoose(name) }, image, html('span', {}, name));
      this.#tiles.set(name, { tile, image });
    }
    this.node = html('div', { class: 'presets', role: 'group', 'aria-label': 'Presets, as they show this volume' });
    replace(this.node, [...this.#tiles.values()].map(({ tile }) => tile));
  }

  /** Offers only the presets that `suits(name)` accepts. */
  offer(suits) {
    for (const [name, { tile }] of this.#tiles) tile.hidden = !suits(name);
  }

  /** Marks the preset in use; null marks none. */
  mark(name) {
    for (const [each, { tile }] of this.#tiles) tile.setAttribute('aria-pressed', String(each === name));
  }

  /** Draws the pictures of the offered presets anew. `request` is the body of the requests, without the preset. */
  async draw(request) {
    const round = ++this.#round;
    for (const [name, { tile, image }] of this.#tiles) {
      if (tile.hidden) continue;
      while (!this.#isIdle() || document.hidden) {
        await new Promise((resolve) => { setTimeout(resolve, kWait_ms); });
        if (round !== this.#round) return;
      }
      try {
        const blob = await this.#server.blob('thumbnail', { ...request, preset: name, size: [kSize_px, kSize_px] });
        if (round !== this.#round) return;
        if (image.src) URL.revokeObjectURL(image.src);
        image.src = URL.createObjectURL(blob);
      } catch (error) {
        // The preset does not suit this volume; its name stays.
        image.removeAttribute('src');
        tile.title = error.message;
      }
      if (round !== this.#round) return;
    }
  }
}
