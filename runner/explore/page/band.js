/* The band of response curves of a model with samples: the amplitudes below which 5 and 95 % of the
 * samples are, at each frequency. One sample at a time, so that the page stays fluent. */

const POINTS = 161; // frequencies of the band
const PARTS = [0.05, 0.95];

/** Returns the largest amplitude of a mode at each frequency; NaN where no branch is. */
function largest({ rows, width, count }, mode, frequencies) {
  const sizes = frequencies.map(() => NaN);
  for (let k = 1; k < count; k++) {
    const [from, to] = [(k - 1) * width, k * width];
    if (rows[from + width - 1] !== rows[to + width - 1]) continue; // another branch
    const [low, high] = [Math.min(rows[from], rows[to]), Math.max(rows[from], rows[to])];
    frequencies.forEach((frequency, n) => {
      if (frequency < low || frequency > high || low === high) return;
      const part = (frequency - rows[from]) / (rows[to] - rows[from]);
      const size = rows[from + 1 + mode] + part * (rows[to + 1 + mode] - rows[from + 1 + mode]);
      if (!(sizes[n] >= size)) sizes[n] = size;
    });
  }
  return sizes;
}

export class Band {
  /** `samples` are {count, reference of the parameter}. */
  constructor(core, samples, modes) {
    Object.assign(this, { core, samples, modes });
    this.begin(0, [0, 1]);
  }

  /** Begins anew, for the frequency of a mode in a span. */
  begin(swept, span) {
    const [least, most] = span;
    Object.assign(this, { swept, span, curves: [] });
    this.frequencies = Array.from({ length: POINTS }, (_, n) => least + n / (POINTS - 1) * (most - least));
  }

  /** Computes the curve of the next sample; returns whether the band has become complete. */
  advance() {
    const { core, samples, curves, modes } = this;
    if (curves.length === samples.count) return false;
    core.set([samples.reference], [curves.length + 1]);
    const points = core.curve(this.swept, ...this.span, modes);
    core.set([samples.reference], [0]);
    core.takeMessage();
    curves.push(Array.from({ length: modes }, (_, mode) => largest(points, mode, this.frequencies)));
    return curves.length === samples.count;
  }

  /** Returns the two lines [xs, ys] of a mode in units, without points until they are known. */
  lines(mode, [per, perSize]) {
    if (this.curves.length < this.samples.count) return PARTS.map(() => [[], []]);
    const xs = this.frequencies.map((frequency) => frequency / per);
    const sorted = xs.map((_, n) => this.curves.map((curve) => curve[mode][n]).sort((a, b) => a - b));
    return PARTS.map((part) =>
      [xs, sorted.map((sizes) => sizes[Math.round(part * (sizes.length - 1))] / perSize)]);
  }
}
