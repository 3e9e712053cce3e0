/* A chart of lines and points whose x need not increase: uPlot's axes, with paths of its own. */
import { exponentOf, powerOfTen } from "page/numbers";
import uPlot from "page/uplot";

const FONT = "12px system-ui, sans-serif";

/** The value of a colour of page.css, which depends on the scheme. */
function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** Draws a line through points, broken where one is not a number. */
function linePath(u, index) {
  const path = new Path2D();
  uPlot.orient(u, index, (_series, xs, ys, scaleX, scaleY, toX, toY, left, top, width, height) => {
    let down = false;
    for (let k = 0; k < xs.length; k++) {
      const shown = Number.isFinite(ys[k]);
      if (shown) {
        const x = toX(xs[k], scaleX, width, left);
        const y = toY(ys[k], scaleY, height, top);
        if (down) path.lineTo(x, y);
        else path.moveTo(x, y);
      }
      down = shown;
    }
  });
  return { stroke: path, fill: null, clip: null, band: null, gaps: null };
}

/** Draws a disk at each point. */
function pointPath(u, index) {
  const path = new Path2D();
  const radius = 4.5 * devicePixelRatio;
  uPlot.orient(u, index, (_series, xs, ys, scaleX, scaleY, toX, toY, left, top, width, height) => {
    for (let k = 0; k < xs.length; k++) {
      const x = toX(xs[k], scaleX, width, left);
      const y = toY(ys[k], scaleY, height, top);
      path.moveTo(x + radius, y);
      path.arc(x, y, radius, 0, 2 * Math.PI);
    }
  });
  return { stroke: path, fill: path, clip: null, band: null, gaps: null };
}

export class Chart {
  /**
   * `x` is the label of the axis; `axes` are {label, colour} of one or two vertical axes, from 0 if
   * `fromZero`; `series` are {axis, colour, width, dashed, points}, with a `label` for the caption if there
   * are several of a kind. `pick(x)` is called where the chart is clicked.
   */
  constructor(figure, { x, axes, series, fromZero = false, pick = null }) {
    this.element = figure.querySelector(".plot");
    const caption = figure.querySelector("figcaption");
    this.element.setAttribute("role", "img");
    this.element.setAttribute("aria-label", caption.firstChild.textContent.trim());
    for (const { label, colour } of series.filter((each) => each.label)) {
      const key = caption.appendChild(document.createElement("span"));
      key.textContent = label;
      key.style.color = `var(--${colour})`;
    }
    this.fromZero = fromZero;
    this.ranges = { x: [0, 1], y0: [0, 1], y1: [0, 1] };
    this.x = x;
    const scale = (name) => ({ time: false, auto: true, range: () => this.ranges[name] });
    const options = {
      mode: 2,
      width: Math.max(this.element.clientWidth, 50),
      height: Math.max(this.element.clientHeight, 50),
      legend: { show: false },
      cursor: { show: false },
      padding: [10, axes.length > 1 ? 0 : 14, 0, 0],
      scales: { x: scale("x"), y0: scale("y0"), y1: scale("y1") },
      axes: [this.axis("x", 2, () => this.x), ...axes.map((each, k) =>
        this.axis(`y${k}`, k ? 1 : 3, () => each.label, each.colour))],
      series: [null, ...series.map((each) => ({
        facets: [{ scale: "x", auto: true }, { scale: `y${each.axis ?? 0}`, auto: true }],
        stroke: () => colour(each.colour),
        fill: () => colour(each.colour),
        width: each.width ?? 2,
        dash: each.dashed ? [5, 4] : undefined,
        paths: each.points ? pointPath : linePath,
        points: { show: false },
      }))],
    };
    this.axisOf = series.map((each) => each.axis ?? 0);
    this.plot = new uPlot(options, [null, ...series.map(() => [[], []])], this.element);
    new ResizeObserver(() => {
      this.plot.setSize({ width: this.element.clientWidth, height: this.element.clientHeight });
    }).observe(this.element);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.plot.redraw());
    if (pick) this.plot.over.addEventListener("click", (event) => pick(this.plot.posToVal(event.offsetX, "x")));
  }

  axis(scale, side, label, stroke = "text") {
    const exponent = () => exponentOf(Math.max(...this.ranges[scale].map(Math.abs)));
    return {
      scale,
      side,
      label: () => `${label()} ${powerOfTen(exponent())}`,
      stroke: () => colour(stroke),
      grid: { show: side !== 1, stroke: () => colour("grid"), width: 1 },
      ticks: { show: false },
      font: FONT,
      labelFont: FONT,
      labelSize: 18,
      size: side === 2 ? 30 : 46,
      gap: 4,
      values: (_, splits) => splits.map((value) => Number((value / 10 ** exponent()).toPrecision(6))),
    };
  }

  /** Shows lines and points: [xs, ys] of each series. */
  draw(data) {
    const bounds = { x: [Infinity, -Infinity], y0: [Infinity, -Infinity], y1: [Infinity, -Infinity] };
    const extend = (bound, values) => {
      for (const value of values) {
        if (value < bound[0]) bound[0] = value;
        if (value > bound[1]) bound[1] = value;
      }
    };
    data.forEach(([xs, ys], k) => {
      extend(bounds.x, xs);
      extend(bounds[`y${this.axisOf[k]}`], ys);
    });
    for (const [name, [least, most]] of Object.entries(bounds)) {
      this.ranges[name] = this.range(name, least, most);
    }
    this.plot.setData([null, ...data]);
  }

  range(name, least, most) {
    if (!(least <= most)) return [0, 1];
    const margin = 0.06 * (most - least) || 0.05 * Math.abs(most) || 1;
    if (name === "x") return most > least ? [least, most] : [least, least + margin];
    return this.fromZero ? [0, most + 0.08 * most || 1] : [least - margin, most + margin];
  }
}
