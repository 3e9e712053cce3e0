/* The present run: rows of recorded values, the latest of which are drawn, and all are exported. */

const MOST_ROWS = 200000; // the oldest half is dropped beyond

export class History {
  constructor(columns) {
    this.columns = columns; // of {name, unit}
    this.clear();
  }

  clear() {
    this.values = new Float64Array(1024 * this.columns.length);
    this.count = 0;
  }

  get width() {
    return this.columns.length;
  }

  /** Appends rows, one after the other. */
  add(rows) {
    const needed = (this.count + rows.length / this.width) * this.width;
    if (needed > MOST_ROWS * this.width) {
      const half = Math.floor(this.count / 2);
      this.values.copyWithin(0, (this.count - half) * this.width, this.count * this.width);
      this.count = half;
    } else if (needed > this.values.length) {
      const larger = new Float64Array(2 * needed);
      larger.set(this.values);
      this.values = larger;
    }
    this.values.set(rows, this.count * this.width);
    this.count += rows.length / this.width;
  }

  /** Returns the last values of some columns, at most `most` of each. */
  latest(names, most) {
    const count = Math.min(this.count, most);
    const first = this.count - count;
    return names.map((name) => {
      const column = this.columns.findIndex((each) => each.name === name);
      return Float64Array.from({ length: count }, (_, k) => this.values[(first + k) * this.width + column]);
    });
  }

  /** Returns the run as CSV, with units in its first line. */
  csv() {
    const lines = [this.columns.map(({ name, unit }) => `${name} [${unit}]`).join(",")];
    for (let k = 0; k < this.count; k++) {
      lines.push(this.values.subarray(k * this.width, (k + 1) * this.width).join(","));
    }
    return `${lines.join("\n")}\n`;
  }
}
