/* The page: controls on the left change the inputs of the core, charts show what comes of it. */
import { Control } from "page/controls";
import { Core } from "page/core";
import { History } from "page/history";
import { readLink, writeLink } from "page/link";
import { withUnit } from "page/numbers";
import { Views } from "page/views";

const ROWS_PER_FRAME = 8;
const LONGEST_FRAME = 0.1; // [s], where frames are late
const PERTURBATION = 0.1; // of the range of the friction table
const SPEED = { name: "speed", label: "Speed", unit: "cycles/s", per: 1, least: 1, most: 10000, log: true };

const element = (id) => document.getElementById(id);

/** Says something about the page as a whole; "" takes it back. */
function say(text) {
  element("message").textContent = text;
  element("message").hidden = !text;
}

class Page {
  constructor(content, core) {
    Object.assign(this, { content, core, playing: false, swept: 0, contact: 0, shown: 0 });
    this.references = content.recorded.map((each) => each.reference);
    this.history = new History(content.recorded);
    this.views = new Views(content, core, this.history, (value) => this.pick(value));
    this.stale = { run: true, beat: true, curve: true };
    this.addControls();
    this.record();
  }

  addControls() {
    const { content } = this;
    this.speed = new Control(element("speed"), { ...SPEED, start: content.speed }, (value) => {
      if (!(value >= SPEED.least && value <= SPEED.most)) {
        return `The speed is from ${SPEED.least} to ${SPEED.most} cycles a second.`;
      }
      this.link();
      return "";
    });
    this.inputs = content.inputs.map((input) =>
      new Control(element("inputs"), input, (value) => this.setInput(input, value)));
    this.choose("swept", content.modes.map((mode) => `frequency ${mode}`), () => { this.stale.curve = true; });
    this.choose("shown", content.amplitudes.map((each) => each.name), () => {
      this.views.show(this.shown);
      this.stale.run = this.stale.curve = true;
    });
    this.choose("contact", content.contacts.map((each) => each.name), () => { this.stale.beat = true; });
    element("play").addEventListener("click", () => this.play(!this.playing));
    element("restart").addEventListener("click", () => this.restart());
    element("perturb").addEventListener("click", () => {
      if (!this.core.perturb(PERTURBATION)) say(this.core.takeMessage());
      this.record();
    });
    element("export").addEventListener("click", () => this.saveRun());
    element("copy").addEventListener("click", () => this.copyLink());
    document.addEventListener("keydown", (event) => {
      const taken = event.target.closest("button, select, input:not([type=range])");
      if (event.key !== " " || taken) return;
      event.preventDefault();
      this.play(!this.playing);
    });
    addEventListener("hashchange", () => this.follow(readLink()));
  }

  /** Fills a list from which one is chosen; `changed` is called when another is. */
  choose(name, options, changed) {
    const list = element(name);
    list.replaceChildren(...options.map((text, k) => new Option(text, k)));
    list.addEventListener("change", () => {
      this[name] = Number(list.value);
      this.link();
      changed();
    });
  }

  /** Sets an input of the core; returns why it is refused, or "". */
  setInput(input, value) {
    const accepted = this.core.set([input.reference], [value]);
    const message = this.core.takeMessage();
    if (!accepted) return message;
    say(message);
    this.stale.curve = true;
    this.link();
    this.record();
    return "";
  }

  /** A frequency was chosen on the response curve. */
  pick(shown) {
    const name = `frequency_${this.content.modes[this.swept]}`;
    const control = this.inputs.find((each) => each.input.name === name);
    control.set(shown * control.input.per);
    control.show();
  }

  /** Takes up the present values into the run. */
  record() {
    this.history.add(this.core.get(this.references));
    this.stale.run = this.stale.beat = true;
  }

  /** Back to t = 0, with the present inputs. */
  restart() {
    this.core.restart();
    this.history.clear();
    this.record();
  }

  play(playing) {
    this.playing = playing;
    element("play").textContent = playing ? "Pause" : "Play";
    if (playing) say("");
    this.link();
  }

  /** Advances by cycles of the slower mode; where the friction table ends, the run stops. */
  advance(cycles) {
    const duration = cycles * this.content.cycle;
    const rows = this.core.play(duration, ROWS_PER_FRAME, this.references);
    this.history.add(rows);
    this.stale.run = this.stale.beat = true;
    if (rows.length < ROWS_PER_FRAME * this.references.length) this.play(false);
    const message = this.core.takeMessage();
    if (message) say(message);
  }

  /** Draws what has changed. */
  draw() {
    const { stale, views } = this;
    if (stale.curve) views.drawCurve(this.swept);
    else if (stale.run) views.drawOperatingPoint(this.swept);
    views.drawBand(this.swept);
    if (stale.run) views.drawRun();
    if (stale.beat) views.drawBeat(this.contact);
    if (stale.run) this.read();
    this.stale = { run: false, beat: false, curve: false };
  }

  /** Shows the present values. */
  read() {
    const shown = ["time", ...this.content.modes.map((mode) => `${mode}_abs`), "dissipated_power"];
    const { labels, unit, per } = this.views.shown;
    const names = ["Time", ...labels, "Dissipation"];
    const units = ["s", ...labels.map(() => unit), "W"];
    const sizes = [1, ...per, 1];
    const values = this.history.latest(shown, 1);
    element("readings").replaceChildren(...names.flatMap((label, k) => {
      const [term, value] = [document.createElement("dt"), document.createElement("dd")];
      term.textContent = label;
      value.textContent = withUnit(values[k][0] / sizes[k], units[k]);
      return [term, value];
    }));
  }

  /** Draws frame after frame. */
  run() {
    let before = performance.now();
    const frame = (now) => {
      const elapsed = Math.min((now - before) / 1000, LONGEST_FRAME);
      before = now;
      if (this.playing && elapsed > 0) this.advance(this.speed.value * elapsed);
      this.draw();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  get settings() {
    const inputs = this.inputs.map(({ input, value }) => [input.name, value]);
    const { playing, swept, contact, shown } = this;
    return { ...Object.fromEntries(inputs), speed: this.speed.value, swept, contact, shown, play: Number(playing) };
  }

  link() {
    writeLink(() => this.settings);
  }

  /** Takes up the settings of a link. */
  follow(settings) {
    // twice: an input may be refused until another has its value
    for (const control of [this.speed, ...this.inputs, ...this.inputs]) {
      if (control.input.name in settings) control.set(Number(settings[control.input.name]));
      control.show();
    }
    for (const name of ["swept", "contact", "shown"]) {
      const list = element(name);
      if (!(Number(settings[name]) < list.options.length)) continue;
      this[name] = Number(settings[name]);
      list.value = settings[name];
    }
    this.views.show(this.shown);
    this.stale.curve = this.stale.beat = true;
    this.play(settings.play !== "0" && !matchMedia("(prefers-reduced-motion: reduce)").matches);
  }

  saveRun() {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([this.history.csv()], { type: "text/csv" }));
    link.download = `${this.content.name}.csv`;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  async copyLink() {
    const address = `${location.href.split("#")[0]}#${new URLSearchParams(this.settings)}`;
    try {
      await navigator.clipboard.writeText(address);
      say("The link is copied.");
    } catch {
      location.hash = address.split("#")[1];
      say("The address of this page now has these settings.");
    }
  }
}

/** Starts the page, or says why it cannot start. */
export async function start() {
  const content = JSON.parse(element("content").textContent);
  try {
    const page = new Page(content, await Core.open());
    globalThis.slipmode = page; // for the console, and for tests
    page.follow(readLink());
    page.restart();
    page.run();
  } catch (error) {
    say(error.message);
  }
}
