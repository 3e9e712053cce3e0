/* What the page shows of the core: the run, a response curve, the motion over a beat. */
import { Band } from "page/band";
import { isCut, line } from "page/branches";
import { Chart } from "page/chart";

// Samples per cycle of the faster mode: steps in which contacts are marched. A beat of one mode is
// one cycle; in coarser ones corners of loops were up to 2.5 % off (lap-joint).
const PER_CYCLE = { 1: 160, 2: 40 };
const SHOWN_ROWS = 1500; // of the run

/** Returns a column of rows, in a unit. */
function column({ rows, width, count }, index, per = 1) {
  return Float64Array.from({ length: count }, (_, k) => rows[k * width + index] / per);
}

export class Views {
  constructor(content, core, history, pick) {
    Object.assign(this, { content, core, history });
    const { modes, contacts, dofs, displacement, frequency } = content;
    this.axes = modes.map((mode) => ({ label: "", colour: `mode-${mode}` }));
    this.show(0);
    const { axes } = this;
    const figure = (id) => document.getElementById(id);
    figure("band").hidden = !content.samples;
    this.band = content.samples && new Band(core, content.samples, modes.length);
    const ofBand = (mode, axis) =>
      (this.band ? [0, 1] : []).map(() => ({ axis, colour: `mode-${mode}`, width: 1 }));
    this.amplitudes = new Chart(figure("amplitudes"), {
      x: "time [s]",
      axes,
      series: modes.map((mode, axis) => ({ axis, colour: `mode-${mode}` })),
      fromZero: true,
    });
    this.curve = new Chart(figure("curve"), {
      x: `frequency [${frequency.unit}]`,
      axes,
      series: modes.flatMap((mode, axis) => [
        { axis, colour: `mode-${mode}` },
        { axis, colour: `mode-${mode}`, dashed: true },
        { axis, colour: `mode-${mode}`, points: true },
        ...ofBand(mode, axis),
      ]),
      fromZero: true,
      pick,
    });
    for (const id of ["loop", "force"]) figure(id).hidden = !contacts.length;
    figure("displacement").hidden = !dofs.length;
    figure("displacement").classList.toggle("whole", !contacts.length);
    figure("plots").classList.toggle("one-row", !dofs.length);
    const length = `[${displacement.unit}]`;
    if (dofs.length) {
      this.displacement = new Chart(figure("displacement"), {
        x: "time [s]",
        axes: [{ label: `displacement ${length}` }],
        series: dofs.map(({ name }, k) => ({ label: name, colour: `dof-${k % 4}` })),
      });
    }
    if (!contacts.length) return;
    this.loop = new Chart(figure("loop"), {
      x: `displacement ${length}`,
      axes: [{ label: "force [N]" }],
      series: [{ colour: "contact" }, { colour: "contact", points: true }],
    });
    this.force = new Chart(figure("force"), {
      x: "time [s]",
      axes: [{ label: "force [N]" }],
      series: [{ colour: "contact" }],
    });
  }

  /** Shows amplitudes in one of the ways of the content: as displacements, or of the modes. */
  show(kind) {
    this.shown = this.content.amplitudes[kind];
    this.axes.forEach((axis, k) => { axis.label = `${this.shown.labels[k]} [${this.shown.unit}]`; });
  }

  /** Draws the latest part of the run. */
  drawRun() {
    const names = ["time", ...this.content.modes.map((mode) => `${mode}_abs`)];
    const [time, ...sizes] = this.history.latest(names, SHOWN_ROWS);
    const { per } = this.shown;
    this.amplitudes.draw(sizes.map((size, k) => [time, size.map((value) => value / per[k])]));
  }

  /** Draws the motion of a contact and of the DOFs over a beat from now on. */
  drawBeat(contact) {
    const { modes, contacts, dofs, displacement } = this.content;
    if (!dofs.length) return;
    const beat = this.core.beat(PER_CYCLE[modes.length]);
    const time = column(beat, 0);
    this.displacement.draw(dofs.map(({ slot }) => [time, column(beat, slot, displacement.per)]));
    if (!contacts.length) return;
    const x = column(beat, contacts[contact].x, displacement.per);
    const f = column(beat, contacts[contact].f);
    this.loop.draw([[x, f], [x.slice(0, 1), f.slice(0, 1)]]);
    this.force.draw([[time, f]]);
  }

  /** Computes and draws the response curve against the frequency of a mode. */
  drawCurve(swept) {
    const { modes, inputs } = this.content;
    const of = (mode) => inputs.find((input) => input.name === `frequency_${mode}`);
    const { least, most } = of(modes[swept]);
    const points = this.core.curve(swept, least, most, modes.length);
    const { per } = this.content.frequency;
    this.lines = modes.map((_, mode) => [1, 0].map((stable) => line(points, mode, stable, [per, this.shown.per[mode]])));
    if (this.band) this.band.begin(swept, [least, most]);
    const span = [least, most];
    if (modes.length === 2) { // the curve stays on its side of the other frequency
      const names = [modes[swept], modes[1 - swept]].map((mode) => `frequency_${mode}`);
      const [[own], [other]] = this.history.latest(names, 1);
      if (own < other) span[1] = Math.min(most, other);
      else span[0] = Math.max(least, other);
    }
    document.getElementById("cut").hidden = !isCut(points, span);
    this.drawOperatingPoint(swept);
  }

  /** Computes a part of the band; draws it when it is complete. */
  drawBand(swept) {
    if (this.band && this.band.advance()) this.drawOperatingPoint(swept);
  }

  /** Draws the response curve with the present amplitudes on it. */
  drawOperatingPoint(swept) {
    const { modes, frequency } = this.content;
    const names = [`frequency_${modes[swept]}`, ...modes.map((mode) => `${mode}_abs`)];
    const [now, ...sizes] = this.history.latest(names, 1);
    const at = [now[0] / frequency.per];
    this.curve.draw(modes.flatMap((_, mode) => [
      ...this.lines[mode],
      [at, [sizes[mode][0] / this.shown.per[mode]]],
      ...(this.band ? this.band.lines(mode, [frequency.per, this.shown.per[mode]]) : []),
    ]));
  }
}
