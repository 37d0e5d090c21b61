// Requests to the viewer's server, and its streams of records. All addresses are relative, so that any prefix of a
// proxy works. The token comes from the fragment of the page's address and is sent as a header.

const kLargestRecord_bytes = 1 << 28;

/** An answer other than success, in the server's words. */
export class ServerError extends Error {
  constructor(message, status) {
    super(message);
    this.status = status;
  }
}

/** Splits a stream of bytes into records: length, JSON, length, payload. Lengths are 32 bits, little endian. */
export class RecordReader {
  // Bytes from #from to #to are unread. The buffer grows by doubling, so that each byte is copied a few times only.
  #buffer = new Uint8Array(1 << 16);
  #from = 0;
  #to = 0;

  /** Takes the next bytes of the stream; returns the records that are complete now, as {head, payload}. */
  push(bytes) {
    this.#makeRoom(bytes.length);
    this.#buffer.set(bytes, this.#to);
    this.#to += bytes.length;
    const out = [];
    for (let record = this.#take(); record; record = this.#take()) out.push(record);
    return out;
  }

  #makeRoom(count) {
    if (this.#to + count <= this.#buffer.length) return;
    const unread = this.#buffer.subarray(this.#from, this.#to);
    let size = this.#buffer.length;
    while (size < unread.length + count) size *= 2;
    const buffer = new Uint8Array(size);
    buffer.set(unread);
    [this.#buffer, this.#from, this.#to] = [buffer, 0, unread.length];
  }

  #take() {
    const head = this.#part(this.#from);
    const payload = head && this.#part(head.end);
    if (!payload) return null;
    this.#from = payload.end;
    return { head: JSON.parse(new TextDecoder().decode(head.bytes())), payload: payload.bytes() };
  }

  #part(at) {
    if (this.#to < at + 4) return null;
    const size = new DataView(this.#buffer.buffer).getUint32(at, true);
    if (size > kLargestRecord_bytes) throw new Error(`stream of the server: a record of ${size} bytes is too large`);
    const end = at + 4 + size;
    return this.#to < end ? null : { bytes: () => this.#buffer.slice(at + 4, end), end };
  }
}

export class Server {
  #token;

  constructor(token) { this.#token = token; }

  async #fetch(path, body, signal) {
    const headers = { Authorization: `Bearer ${this.#token}` };
    if (body !== undefined) headers['Content-Type'] = 'application/json';
    const options = { method: body === undefined ? 'GET' : 'POST', headers, body: body && JSON.stringify(body), signal, cache: 'no-store' };
    const answer = await fetch(`api/${path}`, options).catch((error) => {
      throw signal?.aborted ? error : new Error('the viewer does not answer; is kiln view still running?');
    });
    if (answer.ok) return answer;
    let message = `the server answered ${answer.status}`;
    try {
      message = (await answer.json()).error ?? message;
    } catch {
      // An answer without JSON comes from a proxy; its status is the message.
    }
    throw new ServerError(message, answer.status);
  }

  async json(path, body, signal) { return (await this.#fetch(path, body, signal)).json(); }
  async blob(path, body, signal) { return (await this.#fetch(path, body, signal)).blob(); }

  /** Calls `onRecord(head, payload)` for each record. Resolves at the end of the stream. */
  async records(path, body, signal, onRecord) {
    const answer = await this.#fetch(path, body, signal);
    const reader = new RecordReader();
    const stream = answer.body.getReader();
    for (let part = await stream.read(); !part.done; part = await stream.read()) {
      for (const { head, payload } of reader.push(part.value)) await onRecord(head, payload);
    }
  }
}

/** Returns the token of the page's address, "" if there is none. */
export const tokenOfPage = () => decodeURIComponent(location.hash.slice(1));
