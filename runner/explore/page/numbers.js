/* Numbers as people read them. */

/** Returns a number with few digits, as text that number fields take. */
export function rounded(value, digits = 5) {
  return String(Number(value.toPrecision(digits)));
}

/** Returns the power of ten that numbers up to `most` are shown in, a multiple of 3; or 0. */
export function exponentOf(most) {
  const decade = most > 0 ? Math.floor(Math.log10(most)) : 0;
  return decade >= -2 && decade < 4 ? 0 : 3 * Math.floor(decade / 3);
}

/** Returns "×10⁻⁶" for -6, "" for 0. */
export function powerOfTen(exponent) {
  const raised = String(exponent).replace(/./g, (each) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(each)]);
  return exponent ? `×10${raised}` : "";
}

/** Returns a value with four digits, a power of ten, and its unit. */
export function withUnit(value, unit) {
  const exponent = exponentOf(Math.abs(value));
  const digits = (value / 10 ** exponent).toPrecision(4);
  return [digits, powerOfTen(exponent), unit].filter(Boolean).join(" ");
}
