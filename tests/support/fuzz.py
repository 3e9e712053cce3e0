"""Scenes and model files that went wrong in the ways files do; the same seed, the same file."""

import io
import json
import re

import numpy as np

from slipmode.rom.table.model import digest

VALUES = (
    *("0", "-1", "1", "7", "0.5", "1e-30", "-1e30", "5e-324", "1e308", "nan", "inf", "-inf"),
    *("9223372036854775807", "0x1F", "1" + 400 * "0", "true", '""', '"A"', '"\\u0000"', "{A = 1}"),
    *('"jenkins"', '"iwan"', '"frictional"', '"tanh"', '"paper"', "'" + 300 * "x" + "'", "[]"),
    *('"naïve Ωµ"', "1979-05-27", "[[]]", "[1]", "[0, 1]", "[1.0, 2.0, 3.0]", "[nan]", '["a", 1]'),
    *("[[0, 0.1], [5, 0.9], [5, 0.2]]", "[[5, 1], [0, 1]]", "[[0, 1e30]]", "[[0, -1e-30]]"),
)
KEYS = ("A", "B", "limit", "alpha", "dof", "vector", "frequency", "k1", "stiffness", "mu", "gap")
KEYS += ("contacts", "law", "Ω", "''")


def _scaled(value, random):
    """A value whose numbers are another factor each, most of them near 1."""
    width = random.choice([0.05, 0.5, 5.0, 50.0])
    return re.sub(
        r"\d+\.?\d*(e-?\d+)?",
        lambda number: repr(float(number[0]) * 10.0 ** random.normal(scale=width)),
        value,
    )


def _damaged(data, random):
    """The bytes with some flipped, cut out, doubled, or without their end."""
    data = bytearray(data)
    start, end = sorted(random.integers(len(data), size=2).tolist())
    match random.integers(4):
        case 0:
            data[start] ^= 1 << int(random.integers(8))
        case 1:
            del data[start : start + 200]
        case 2:
            data[start:start] = data[start : start + 200]
        case _:
            data = data[:end]
    return bytes(data)


def mutated_scene(text, random):
    """The text with one or a few things changed: lines, keys, values, bytes; as bytes."""
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    for _ in range(random.geometric(0.6)):
        k = int(random.integers(len(lines)))
        key, equals, value = lines[k].partition(" = ")
        match random.integers(12):
            case 0:
                lines[k] = ""
            case 1:
                lines.insert(int(random.integers(len(lines) + 1)), lines[k])
            case 2 | 3 if equals:
                lines[k] = f"{key} = {random.choice(VALUES)}"
            case 4 if equals:
                lines[k] = f"{random.choice(KEYS)} = {value}"
            case 5 if equals:
                lines[k] = f"{key} = [{value}, {value}]"
            case 6:
                lines.insert(k, f"{random.choice(KEYS)} = {random.choice(VALUES)}")
            case _ if equals:
                lines[k] = f"{key} = {_scaled(value, random)}"
    data = "\n".join(lines).encode()
    return _damaged(data, random) if random.random() < 0.1 else data


def _other_array(array, random):
    """An array of another type, shape or size, or with a wrong number."""
    array = np.array(array)
    if array.dtype.kind == "U":  # changed before
        return array
    match random.integers(6):
        case 0:
            return array.real.astype(random.choice(["f4", "i8", "c16", "U8", ">f8", "?"]))
        case 1:
            return array[..., np.newaxis]
        case 2:
            return np.repeat(array, 2, axis=0) if array.ndim else array
        case 3:
            return np.array(array.T, order="C")
        case 4 if array.size and array.dtype.kind in "fc":
            array.flat[random.integers(array.size)] = random.choice([np.nan, np.inf, -1.0, 1e300])
            return array
        case _:
            return np.empty((0, *array.shape[1:]), array.dtype)


def mutated_model(data, random):
    """Damaged bytes; or entries that fit the hash, but not one another."""
    if random.random() < 0.2:
        return _damaged(data, random)
    with np.load(io.BytesIO(data)) as archive:
        entries = {name: archive[name] for name in archive.files}
    header = json.loads(str(entries.pop("header")))
    del header["hash"]
    values = (None, -1, 3, 10**30, 1e-300, "x", [], [[0, 5, 10**6]], {}, True, float("nan"))
    for _ in range(random.integers(1, 3)):
        name, other = (str(name) for name in random.choice(list(entries), 2))
        inside = header[str(random.choice(["accuracy", "law"]))]
        owner = inside if inside and isinstance(inside, dict) and random.random() < 0.5 else header
        match random.integers(5):
            case 0:
                entries[name], entries[other] = entries[other], entries[name]
            case 1 | 2:
                entries[name] = _other_array(entries[name], random)
            case _:
                owner[str(random.choice(list(owner)))] = values[random.integers(len(values))]
    if random.random() < 0.9:
        header["hash"] = digest(header, entries)
    buffer = io.BytesIO()
    np.savez(buffer, header=np.array(json.dumps(header)), **entries)
    return buffer.getvalue()
