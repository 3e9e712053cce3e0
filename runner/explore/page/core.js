/* The C core: one instance of the model, behind the calls of fmu/src/faces/browser/browser.c. All
 * values are in SI units. Where a call is refused, `takeMessage` says why. */

const MOST_ROWS = 4000; // of a curve, and of a beat
const MOST_PLAYED = 64; // rows of one call
const MOST_VALUES = 64; // of one row

/** Returns the bytes of compressed data in an element of the page. */
async function unpacked(id) {
  const packed = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

export class Core {
  /** Returns the core with the model of the page; an error says why there is none. */
  static async open() {
    const [module, files] = await Promise.all([unpacked("module"), unpacked("files")]);
    const { instance } = await WebAssembly.instantiate(module);
    return new Core(instance.exports, new Uint8Array(files));
  }

  constructor(calls, files) {
    this.calls = calls;
    calls._initialize();
    const at = calls.browser_allocate(files.length);
    new Uint8Array(calls.memory.buffer, at, files.length).set(files);
    this.instance = calls.browser_open(at, files.length);
    if (!this.instance || !calls.browser_is_open(this.instance)) {
      throw new Error(this.instance ? this.takeMessage() : "The model does not fit into memory.");
    }
    this.width = calls.browser_output_count(this.instance);
    this.references = calls.browser_allocate(4 * MOST_VALUES);
    this.values = calls.browser_allocate(8 * MOST_VALUES * MOST_PLAYED);
    this.rows = calls.browser_allocate(8 * MOST_ROWS * Math.max(this.width, 5));
  }

  doubles(at, count) {
    return new Float64Array(this.calls.memory.buffer, at, count);
  }

  put(references) {
    new Uint32Array(this.calls.memory.buffer, this.references, references.length).set(references);
  }

  /** Returns the reason of the last refusal, or a warning, since the last call; "" if none. */
  takeMessage() {
    const bytes = new Uint8Array(this.calls.memory.buffer, this.calls.browser_message(this.instance), 512);
    const text = new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
    this.calls.browser_clear_message(this.instance);
    return text;
  }

  /** Returns the values of variables. */
  get(references) {
    this.put(references);
    this.calls.browser_get(this.instance, this.references, references.length, this.values);
    return this.doubles(this.values, references.length).slice();
  }

  /** Sets inputs; returns whether they are accepted. */
  set(references, values) {
    this.put(references);
    this.doubles(this.values, values.length).set(values);
    return !!this.calls.browser_set(this.instance, this.references, references.length, this.values);
  }

  /** Advances by a duration in equal steps; returns rows of values after each, fewer where it stops. */
  play(duration, steps, references) {
    this.put(references);
    const done = this.calls.browser_play(
      this.instance, duration, steps, this.references, references.length, this.values);
    return this.doubles(this.values, done * references.length).slice();
  }

  /** Back to t = 0, with the present inputs. */
  restart() {
    return !!this.calls.browser_restart(this.instance);
  }

  /** Moves the amplitudes by a part of their range. */
  perturb(part) {
    return !!this.calls.browser_perturb(this.instance, part);
  }

  /** Returns rows of all outputs over a beat from now on; the present stays. */
  beat(perCycle) {
    const count = this.calls.browser_beat(this.instance, perCycle, MOST_ROWS, this.rows);
    return { count, width: this.width, rows: this.doubles(this.rows, count * this.width) };
  }

  /** Returns rows of a response curve: frequency, |a| of each mode, 1 if stable, branch. */
  curve(mode, from, to, modes) {
    const width = modes + 3;
    const count = this.calls.browser_curve(this.instance, mode, from, to, MOST_ROWS, this.rows);
    return { count, width, rows: this.doubles(this.rows, count * width) };
  }
}
