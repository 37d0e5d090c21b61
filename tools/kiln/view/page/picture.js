// The picture: requests frames and shows the pictures that arrive.
//
// Invariant: at most one request is in flight. A change requests a frame at once, with `moving: true`; a request of this
// kind is let finish, so that a slow drag shows pictures, and the newest job follows. kRest_ms after the last change the
// request in flight is aborted, and a request with `moving: false` gets all stages up to the picture of the batch.
const kRest_ms = 150;
// Distinguishes this page from others of the server: frames of a page end its older frames alone.
const kPage = Array.from(crypto.getRandomValues(new Uint8Array(8)), (byte) => byte.toString(16).padStart(2, '0')).join('');
// A moving frame that takes longer is given up for a newer job.
const kPatience_ms = 1000;

export class Picture {
  #server;
  #canvas;
  #request;
  #listeners;
  #sequence = 0;
  #flight = null;
  #wanted = false;
  #resting = null;
  #final = null;

  /**
   * `request()` returns {job, size: [w, h], frame} as of now, or null if there is no room for a picture. Listeners:
   * onResolved(record), onPicture(record, request, time in ms), onProgress(record), onError(text),
   * onState("moving" | "waiting" | "final"). The bytes read include those of earlier stages.
   */
  constructor({ server, canvas, request, listeners }) {
    this.#server = server;
    this.#canvas = canvas;
    this.#request = request;
    this.#listeners = listeners;
  }

  /** The bytes of the picture as the batch writes it, null while another is drawn. */
  get finalBytes() { return this.#final; }
  get isIdle() { return !this.#flight && this.#resting === null; }

  /** The job, the size or the frame changed. */
  changed() {
    this.#final = null;
    this.#wanted = true;
    clearTimeout(this.#resting);
    this.#resting = setTimeout(() => this.#rest(), kRest_ms);
    this.#move();
  }

  #move() {
    if (!this.#wanted) return;
    if (this.#flight?.moving && performance.now() - this.#flight.start < kPatience_ms) return;
    this.#send(true);
  }

  #rest() {
    this.#resting = null;
    this.#send(false);
  }

  async #send(moving) {
    this.#flight?.abort.abort();
    const wanted = this.#request();
    this.#wanted = false;
    if (!wanted) return;
    const flight = { moving, abort: new AbortController(), start: performance.now(), bytesRead: 0 };
    this.#flight = flight;
    const seq = ++this.#sequence;
    this.#listeners.onState(moving ? 'moving' : 'waiting');
    try {
      const body = { page: kPage, seq, size: wanted.size, moving, job: wanted.job };
      if (wanted.frame !== undefined) body.frame = wanted.frame;
      await this.#server.records('frame', body, flight.abort.signal, (head, payload) => this.#take(flight, head, payload, wanted));
    } catch (error) {
      if (!flight.abort.signal.aborted) this.#listeners.onError(error.message);
    }
    if (this.#flight !== flight) return;
    this.#flight = null;
    this.#move();
    if (!this.#flight && !moving) this.#listeners.onState('final');
  }

  async #take(flight, head, payload, wanted) {
    if (flight.abort.signal.aborted) return;
    if (head.kind === 'resolved') this.#listeners.onResolved(head, wanted);
    else if (head.kind === 'progress') this.#listeners.onProgress(head);
    else if (head.kind === 'error') this.#listeners.onError(head.error);
    else if (head.kind === 'picture') await this.#show(flight, head, payload, wanted);
  }

  async #show(flight, head, payload, wanted) {
    const blob = new Blob([payload], { type: head.type });
    const bitmap = await createImageBitmap(blob);
    if (flight.abort.signal.aborted) return;
    this.#canvas.width = bitmap.width;
    this.#canvas.height = bitmap.height;
    this.#canvas.getContext('2d').drawImage(bitmap, 0, 0);
    bitmap.close();
    if (head.asRendered) this.#final = blob;
    flight.bytesRead += head.bytesRead;
    this.#listeners.onPicture({ ...head, bytesRead: flight.bytesRead }, wanted, performance.now() - flight.start);
  }
}
