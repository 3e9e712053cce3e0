/* Branches of a response curve: rows of the frequency, |a| of each mode, 1 if stable, branch. */

const CLOSE = 1e-3; // of the span: a branch that reaches its ends comes closer

/** Returns the stable or unstable parts of all branches in units, with gaps between them. */
export function line({ rows, width, count }, mode, stable, [per, perSize]) {
  const [xs, ys] = [[], []];
  for (let k = 0; k < count; k++) {
    const at = k * width;
    const [stability, branch] = [at + width - 2, at + width - 1];
    const follows = k > 0 && rows[branch] === rows[branch - width];
    const shown = rows[stability] === stable || (follows && rows[stability - width] === stable);
    if (!follows) {
      xs.push(rows[at] / per);
      ys.push(NaN);
    }
    xs.push(rows[at] / per);
    ys.push(shown ? rows[at + 1 + mode] / perSize : NaN);
  }
  return [xs, ys];
}

/** Returns whether there is no branch, or one ends inside a span of frequencies: at the edge of the
 * friction table. A closed branch ends where it begins. */
export function isCut({ rows, width, count }, [least, most]) {
  const near = (a, b) => Math.abs(a - b) < CLOSE * (most - least);
  const isOpen = (k) => !near(rows[k * width], least) && !near(rows[k * width], most);
  let first = 0;
  for (let k = 0; k < count; k++) {
    const isLast = k + 1 === count || rows[(k + 2) * width - 1] !== rows[(k + 1) * width - 1];
    if (!isLast) continue;
    const closed = near(rows[first * width], rows[k * width])
      && rows[first * width + 1] === rows[k * width + 1];
    if (!closed && (isOpen(first) || isOpen(k))) return true;
    first = k + 1;
  }
  return count === 0;
}
