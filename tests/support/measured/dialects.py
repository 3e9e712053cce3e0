"""Text files of decays in dialects of loggers, oscilloscopes and spreadsheets, drawn at random."""

from dataclasses import dataclass

import numpy as np

RATES = (1000.0, 2048.0, 51200.0, 4096.0 / 3.0)  # [Hz]
TIME_UNITS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
UNITS = {  # as written, and as read
    "m/s^2": "m/s^2", "m/s²": "m/s^2", "m/s2": "m/s^2", "M/S^2": "m/s^2", "m/s**2": "m/s^2",
    "g": "g", "mm/s": "mm/s", "m / s": "m/s", "µm": "um", "mm": "mm",
}  # fmt: skip
NAMES = ("acc", "Beschleunigung", "tip", "Sensor A", "Kanal_2", "Punkt 3 +Z", "Prüfling", "y[0]")
PREAMBLES = {
    "none": (),
    "comments": ("# measured by hand", "# beam with bolt 3"),
    "keys": ("Title: decay of a beam", "Date: 2024-03-01", "Operator: NN", "Channels: 2"),
    "dates": ("File{s}hit 4", "Date{s}01.03.2024", "Time{s}12:30:00", "Range{s}10{d}00"),
    "lvm": (
        "LabVIEW Measurement", "Writer_Version\t2", "***End_of_Header***", "", "Channels\t2",
        "Date\t2024/03/01\t2024/03/01", "X0\t0{d}0\t0{d}0", "***End_of_Header***",
    ),
    "excel": ("sep={s}",),
}  # fmt: skip
FOOTERS = {
    "none": (),
    "end": ("", "End of data"),
    "statistics": ("Maximum{s}1{d}5{s}1{d}7", "Mean{s}0{d}1{s}0{d}0"),
}


@dataclass(frozen=True)
class Written:
    """What a file contains: names, unit, rate [Hz], and values (channels, samples).

    `rounding` is the largest error of printed values, `given` the sampling rate that a reader
    needs to know, `ambiguous` whether commas separate columns and decimals.
    """

    names: tuple
    unit: str | None
    rate: float
    values: np.ndarray
    rounding: np.ndarray
    given: float | None
    ambiguous: bool
    dialect: dict


def write_drawn(path, seed):
    """Write a file drawn by a seed, and return its content as `Written`."""
    rng = np.random.default_rng(seed)

    def draw(*options):
        return options[rng.integers(len(options))]

    d = {
        "separator": draw("\t", ";", ",", " ", "  "),
        "mark": draw(".", ","),
        "encoding": draw("utf-8", "utf-8-sig", "cp1252", "utf-16", "utf-16-le"),
        "end": draw("\n", "\r\n"),
        "time": draw("none", "stated", *TIME_UNITS),
        "unit": draw(None, *UNITS),
        "label": draw("[", "(", "row", "[row", "(row", "slash", "none"),
        "names": draw(True, True, True, False),
        "quotes": draw("none", "none", "header", "all"),
        "trailing": draw(False, False, True),
        "numbers": draw("%.5f", "%.6e", "%.7g", "%+.4E"),
        "preamble": draw(*PREAMBLES),
        "footer": draw(*FOOTERS),
        "blank": draw(False, True),
        "index": draw(False, False, True),
        "clock": draw(False, False, False, True),
        "missing_newline": draw(False, True),
        "channels": int(rng.integers(1, 4)),
        "rate": draw(*RATES),
        "start": draw(0.0, -0.25, 3.0),
    }
    s = d["separator"]
    blanks = s.strip(" ") == ""
    if blanks:
        d["trailing"] = d["clock"] = False
        if s == " ":
            d["label"] = {"(row": "row", "[row": "row"}.get(d["label"], d["label"])
    if not d["names"]:
        d["label"], d["index"] = "none", False
        if d["preamble"] == "comments":  # a comment above one column may be its name
            d["preamble"] = "none"
    if d["time"] in ("none", "stated") and d["clock"]:
        d["clock"] = False
    samples = int(rng.integers(40, 400))
    values = rng.standard_normal((d["channels"], samples)) * 10.0 ** rng.integers(-2, 3)
    names = [str(each) for each in rng.permutation(NAMES)[: d["channels"]]]
    if blanks:
        names = [name.replace(" ", "_") for name in names]
    times = d["start"] + np.arange(samples) / d["rate"]
    columns, heads, units = [], [], []
    if d["index"]:
        columns.append([str(k) for k in range(1, samples + 1)])
        heads.append(draw("Index", "Sample", "No."))
        units.append("")
    if d["clock"]:
        columns.append(["2024-03-01"] * samples)
        heads.append("Date")
        units.append("")
    if d["time"] in TIME_UNITS:
        # At most a twentieth of a step is lost by rounding to these digits.
        size = TIME_UNITS[d["time"]]
        digits = max(int(np.ceil(-np.log10(0.05 / d["rate"] / size))), 0)
        columns.append([f"{t / size:.{digits}f}" for t in times])
        heads.append(draw("time", "Time", "t", "Zeit", "TIME"))
        units.append(d["time"] if d["time"] != "s" or rng.random() < 0.7 else "")
        if d["label"] == "none" and d["time"] not in ("s", "sec"):
            heads[-1] += f" [{d['time']}]"
            if not d["names"]:
                d["names"] = True
    printed = [[d["numbers"] % x for x in row] for row in values]
    columns += printed
    heads += names
    units += [d["unit"] or ""] * d["channels"]
    if d["encoding"] == "cp1252":
        heads = [h.encode("cp1252", "replace").decode("cp1252") for h in heads]
    return _write(path, d, rng, columns, heads, units, values, printed)


def _write(path, d, rng, columns, heads, units, values, printed):
    s, mark, label = d["separator"], d["mark"], d["label"]
    quoted = d["quotes"] == "all"

    def joined(cells, quote):
        cells = [f'"{cell}"' if quote else cell for cell in cells]
        return s.join(cells) + (s if d["trailing"] else "")

    lines = [line.format(s=s, d=mark) for line in PREAMBLES[d["preamble"]]]
    if d["time"] == "stated":
        rate = f"{d['rate']!r}".replace(".", mark)
        step = f"{1.0 / d['rate']:.12g}".replace(".", mark)
        milli = f"{1e3 / d['rate']:.12g}".replace(".", mark)
        stated = (
            f"Sample rate: {rate} Hz",
            f"Sampling frequency [Hz]{s}{rate}",
            f"Delta_X{s}{step}",
            f"Sample interval (ms){s}{milli}",
            f"dt = {step}",
            f"Abtastrate: {float(d['rate']) / 1e3!r} kHz".replace(".", mark),
        )
        lines.append(stated[rng.integers(len(stated))])
    texts = list(heads)
    if label in ("[", "("):
        close = {"[": "]", "(": ")"}[label]
        texts = [f"{h} {label}{u}{close}" if u else h for h, u in zip(heads, units, strict=True)]
    elif label == "slash":
        wrapped = [f"({u})" if "/" in u else u for u in units]
        texts = [f"{h}/{u}" if u else h for h, u in zip(heads, wrapped, strict=True)]
    if d["names"]:
        quote = quoted or d["quotes"] == "header" or s == " "
        comment = "# " if d["preamble"] == "comments" and s != "," else ""
        lines.append(comment + joined(texts, quote))
        if label.endswith("row"):
            open_, close = {"[": "[]", "(": "()", "r": ("", "")}[label[0]]
            row = [f"{open_}{u}{close}" if u else "-" for u in units]
            lines.append(joined(row, quote))
    if d["blank"]:
        lines.append("")
    lines += [
        joined([x.replace(".", mark) for x in row], quoted) for row in zip(*columns, strict=True)
    ]
    lines += [line.format(s=s, d=mark) for line in FOOTERS[d["footer"]]]
    text = d["end"].join(lines) + ("" if d["missing_newline"] else d["end"])
    encoding = d["encoding"]
    path.write_bytes(text.encode(encoding))
    labelled = label != "none" and d["unit"] is not None
    return Written(
        names=tuple(heads[-len(values) :])
        if d["names"]
        else tuple(f"channel {k}" for k in range(len(values))),
        unit=UNITS[d["unit"]] if labelled else None,
        rate=d["rate"],
        values=values,
        rounding=np.abs(np.array(printed, dtype=float) - values).max(),
        given=d["rate"] if d["time"] == "none" else None,
        ambiguous=mark == "," and s == "," and not quoted,
        dialect=d,
    )
