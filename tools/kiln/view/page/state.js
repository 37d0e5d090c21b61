// The state of the page: one job, and the history of its changes. A job is never changed in place, so a step of the
// history is a job. Changes of one gesture (a drag, a held key) share a merge key and become one step.

const kMostSteps = 500;
const kMergeTime_ms = 700;

// Compares only keys that are not shared, because functions may have thousands of points.
function isEqual(a, b) {
  const keys = new Set([...Object.keys(a), ...Object.keys(b)]);
  return [...keys].every((key) => a[key] === b[key] || JSON.stringify(a[key]) === JSON.stringify(b[key]));
}

export class JobState {
  #steps;
  #at = 0;
  #listeners = new Set();
  #mergeKey = null;
  #mergedAt = 0;
  #saved;

  constructor(job) {
    this.#steps = [{ job, label: '' }];
    this.#saved = job;
  }

  get job() { return this.#steps[this.#at].job; }
  get undoLabel() { return this.#at > 0 ? this.#steps[this.#at].label : null; }
  get redoLabel() { return this.#at + 1 < this.#steps.length ? this.#steps[this.#at + 1].label : null; }
  get isSaved() { return this.#saved === this.job; }

  /** Calls `listener(job, reason)` after each change; reason is the label of the change, "undo" or "redo". */
  subscribe(listener) { this.#listeners.add(listener); }

  /**
   * Replaces the job by `edit(job)`, which returns a new job and leaves the old as it is. `label` is a noun for the undo
   * button; steps with one `merge` key become one step.
   */
  change(label, edit, { merge = null } = {}) {
    const job = edit(this.job);
    if (isEqual(job, this.job)) return;
    const now = Date.now();
    const merges = merge !== null && merge === this.#mergeKey && now - this.#mergedAt < kMergeTime_ms && this.#at > 0;
    this.#steps.length = this.#at + 1;
    if (merges) this.#steps[this.#at] = { job, label };
    else this.#steps.push({ job, label });
    if (this.#steps.length > kMostSteps) this.#steps.shift();
    this.#at = this.#steps.length - 1;
    this.#mergeKey = merge;
    this.#mergedAt = now;
    this.#tell(label);
  }

  /** Ends the gesture: the next change is a step of its own. */
  endGesture() { this.#mergeKey = null; }

  undo() { return this.#go(-1, 'undo'); }
  redo() { return this.#go(1, 'redo'); }
  markSaved() { this.#saved = this.job; this.#tell('saved'); }

  #go(by, reason) {
    const label = by < 0 ? this.undoLabel : this.redoLabel;
    if (label === null) return null;
    this.#at += by;
    this.#mergeKey = null;
    this.#tell(reason);
    return label;
  }

  #tell(reason) { for (const listener of this.#listeners) listener(this.job, reason); }
}
