/* A slider and a number field for one value, with a line that says why it is refused. */
import { rounded } from "page/numbers";

const STEPS = 1000; // of a slider

export class Control {
  /**
   * `input` has name, label, unit, per (the unit in SI units), least, most, start, and log where the
   * slider is logarithmic. `change(value)` gets values in SI units and returns "", or why the value
   * is refused.
   */
  constructor(parent, input, change) {
    this.input = input;
    this.change = change;
    this.value = input.start;
    const element = document.createElement("div");
    element.className = "control";
    element.innerHTML = `
      <label for="${input.name}"></label>
      <span class="field"><input type="number" step="any" id="${input.name}"><span class="unit"></span></span>
      <input type="range" min="0" max="${STEPS}" step="1" aria-describedby="${input.name}-refusal">
      <output id="${input.name}-refusal" class="refusal" hidden></output>`;
    element.querySelector("label").textContent = input.label;
    element.querySelector(".unit").textContent = input.unit;
    [this.field, this.slider] = element.querySelectorAll("input");
    this.slider.setAttribute("aria-label", input.label);
    this.refusal = element.querySelector("output");
    this.slider.addEventListener("input", () => this.set(this.fromSlider()));
    this.slider.addEventListener("change", () => this.show());
    this.field.addEventListener("change", () => {
      this.set(this.field.value === "" ? NaN : Number(this.field.value) * input.per);
      this.show();
    });
    parent.append(element);
    this.show();
  }

  /** Takes a value unless it is refused. */
  set(value) {
    const refusal = this.change(value);
    if (!refusal) this.value = value;
    this.refuse(refusal);
    this.showField();
    return !refusal;
  }

  refuse(reason) {
    this.refusal.textContent = reason;
    this.refusal.hidden = !reason;
    this.field.setAttribute("aria-invalid", String(!!reason));
  }

  show() {
    this.slider.value = String(this.toSlider(this.value));
    this.slider.setAttribute("aria-valuetext", `${rounded(this.value / this.input.per)} ${this.input.unit}`);
    this.showField();
  }

  showField() {
    this.field.value = rounded(this.value / this.input.per, 6);
  }

  fromSlider() {
    const part = Number(this.slider.value) / STEPS;
    const { least, most, log } = this.input;
    const value = log ? least * (most / least) ** part : least + part * (most - least);
    return Number((value / this.input.per).toPrecision(5)) * this.input.per;
  }

  toSlider(value) {
    const { least, most, log } = this.input;
    const part = log ? Math.log(value / least) / Math.log(most / least) : (value - least) / (most - least);
    return Math.round(STEPS * Math.min(Math.max(part, 0), 1));
  }
}
