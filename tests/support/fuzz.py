"""Scenes and model files that went wrong in the ways files do; the same seed, the same file."""

import io
import json
import re

import numpy as np

from slipmode.rom.table.model import digest

VALUES = (
    *("0", "-1", "1", "2", "7", "0.5", "-0.0", "1e-30", "1e30", "-1e30", "1e-300", "1e300"),
    *("5e-324", "1e308", "nan", "inf", "-inf", "9223372036854775807", "0x1F", "1" + 400 * "0"),
    *('"jenkins"', '"iwan"', '"sliders"', '"frictional"', "[1, 0]"),
    *("true", "false", '""', '"A"', '"tanh"', '"coulomb"', '"paper"', "'" + 300 * "x" + "'"),
    *('"\\u0000"', '"naïve Ωµ"', "1979-05-27", "07:32:00", "{}", "{A = 1}", "[]", "[[]]"),
    *("[1]", "[0, 1]", "[1.0, 2.0, 3.0]", "[0.0, 0.0, 0.0, 1.0]", "[[0, 1], [1, 2]]"),
    *("[[0, 0.1], [5, 0.9], [5, 0.2]]", "[[5, 1], [0, 1]]", "[nan]", '["a", 1]', "[[0, 1e30]]"),
    *("[[0, 0.98], [10, 1.6]]", "[[0, -1e-30]]", "1e3", "1e6", "1e-6", "0.01", "20.0"),
)
KEYS = ("A", "B", "limit", "alpha", "dof", "vector", "frequency", "k1", "m2", "k_p", "Ω", "''")
KEYS += ("stiffness", "mu", "gap", "contacts", "law")


def _scaled(value, random):
    """A value whose numbers are another factor each, most of them near 1."""
    width = random.choice([0.05, 0.5, 5.0, 50.0])
    return re.sub(
        r"\d+\.?\d*(e-?\d+)?",
        lambda number: repr(float(number[0]) * 10.0 ** random.normal(scale=width)),
        value,
    )


def mutated_scene(text, random):
    """The text with one or a few things changed: lines, keys, values, bytes; as bytes."""
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    for _ in range(random.geometric(0.6)):
        k = int(random.integers(len(lines)))
        key, equals, value = lines[k].partition(" = ")
        match random.integers(12):
            case 0:
                del lines[k]
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
        if not lines:
            break
    data = bytearray("\n".join(lines).encode())
    if data and random.random() < 0.1:
        data[random.integers(len(data))] ^= 1 << int(random.integers(8))
    return bytes(data[: random.integers(len(data) + 1)] if random.random() < 0.02 else data)


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


def _other_array(array, random):
    array = np.array(array)
    match random.integers(8):
        case 0:
            return array.real.astype(random.choice(["f4", "i8", "c16", "U8", ">f8", "?"]))
        case 1:
            return array.reshape(-1)
        case 2:
            return array[..., np.newaxis]
        case 3:
            return array[1:] if array.ndim else array
        case 4:
            return np.concatenate((array, array)) if array.ndim else array
        case 5:
            return np.array(array.T, order="C")
        case 6 if array.size and array.dtype.kind in "fc":
            array.flat[random.integers(array.size)] = random.choice([np.nan, np.inf, -1.0, 1e300])
            return array
        case _:
            return np.empty((0, *array.shape[1:]), array.dtype)


def _inside(value, random):
    """A record somewhere inside a value of lists and records, or None."""
    if isinstance(value, dict) and ("groups" not in value or random.random() < 0.3):
        return value
    entries = value["groups"] if isinstance(value, dict) else value
    if not isinstance(entries, list) or not entries:
        return None
    return _inside(entries[random.integers(len(entries))], random)


def _other_header(header, random):
    header = json.loads(json.dumps(header))
    chosen = _inside(header.get(str(random.choice(["accuracy", "law"]))), random)
    owner = header if chosen is None or random.random() < 0.6 else chosen
    key = str(random.choice(list(owner) or ["none"]))
    values = (None, -1, 0, 3, 10**30, 1e-300, "x", [], [0, 1], [[0, 1]], [[0, 5, 10**6]], {}, True)
    values += (float("nan"), 10**400, [1.0, 2.0, 3.0, 4.0], "coulomb", "jenkins", [[{}, [0]]], 1.5)
    if random.random() < 0.2:
        owner.pop(key, None)
    else:
        owner[key] = values[random.integers(len(values))]
    return header


def mutated_model(data, random):
    """Damaged bytes; or entries that fit the hash, but not one another."""
    if random.random() < 0.2:
        return _damaged(data, random)
    with np.load(io.BytesIO(data)) as archive:
        entries = {name: archive[name] for name in archive.files}
    header = json.loads(str(entries.pop("header")))
    del header["hash"]
    for _ in range(random.integers(1, 3)):
        name, other = (str(name) for name in random.choice(list(entries), 2))
        match random.integers(5):
            case 0:
                del entries[name]
            case 1:
                entries[name], entries[other] = entries[other], entries[name]
            case 2 | 3:
                entries[name] = _other_array(entries[name], random)
            case _:
                header = _other_header(header, random)
    if random.random() < 0.9:
        header["hash"] = digest(header, entries)
    buffer = io.BytesIO()
    np.savez(buffer, header=np.array(json.dumps(header)), **entries)
    return buffer.getvalue()
