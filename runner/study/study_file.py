"""Reading a study file (TOML): a scene, what varies in it, and the outputs of each sample."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field
from math import log
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from slipmode.rom.arrays import Floats
from slipmode.rom.errors import SlipmodeError, naming
from slipmode.rom.short_repr import short_repr
from slipmode.rom.storage.code_digest import code_digest
from slipmode.rom.storage.text import read_text
from slipmode.rom.structure.files import source_files
from slipmode.runner.scene.scene import load_scene, parse_toml, read_scene
from slipmode.runner.scene.sections import Scene
from slipmode.runner.scene.toml_table import Key, Section, Table
from slipmode.runner.scene.values import (
    FINITE,
    NON_NEGATIVE,
    POSITIVE,
    Kind,
    Rule,
    anything,
    between,
    boolean,
    choice,
    integer,
    integers,
    number,
    numbers,
    text,
)
from slipmode.runner.study.sample_outputs import Curve, Outputs
from slipmode.runner.study.scene_keys import Content, check_key, declared, get, with_value

DISTRIBUTIONS = {
    "uniform": ("low", "high"),
    "loguniform": ("low", "high"),
    "normal": ("mean", "deviation"),
    "lognormal": ("median", "sigma"),
}
_MANY = 10**7  # samples are kept as columns in memory: 80 MB each at this number
_AT_LEAST_ONE = Rule(">= 1", lambda value: 1 <= value <= _MANY)


def _key(name: str, kind: Kind, default: Any = None) -> Key:
    return Key(name, kind, "-", default, "")


# fmt: off
STUDY = Section("", "", (
    _key("title", text(), ""),
    _key("scene", text(), MISSING),
    _key("set", anything(), {}),
    Section("vary", "", (
        _key("key", text(), MISSING),
        _key("values", anything()),
        _key("from", number(), MISSING),
        _key("to", number(), MISSING),
        _key("points", integer(_AT_LEAST_ONE), MISSING),
        _key("spacing", choice("linear", "log"), "linear"),
        _key("distribution", choice(*DISTRIBUTIONS)),
        *(_key(name, number(), MISSING)
          for name in dict.fromkeys(name for names in DISTRIBUTIONS.values() for name in names)),
    ), is_array=True),
    Section("sampling", "", (
        _key("method", choice("grid", "list", "sobol", "latin-hypercube", "saltelli")),
        _key("samples", integer(_AT_LEAST_ONE), MISSING),
        _key("seed", integer(), 0),
    )),
    Section("outputs", "", (
        _key("steady", boolean(), False),
        _key("resonance", anything()),
        Section("curve", "", (
            _key("mode", text(), MISSING),
            _key("from", number(POSITIVE), MISSING),
            _key("to", number(POSITIVE), MISSING),
            _key("points", integer(between(2, _MANY)), MISSING),
        )),
        _key("peak", boolean(), False),
        _key("times", numbers(NON_NEGATIVE)),
        _key("recording", boolean(), False),
        _key("dofs", integers(), []),
    )),
    Section("choose", "", (
        _key("key", text(), MISSING),
        _key("output", text(), MISSING),
        _key("quantile", number(between(0, 1)), 0.95),
    )),
))
# fmt: on


@dataclass(frozen=True)
class Distribution:
    """A distribution of a value, by name and parameters: see `DISTRIBUTIONS`."""

    name: str
    parameters: tuple[float, float]

    def quantile(self, part: Floats) -> Floats:
        """Return the values below which parts (n,) of the distribution lie."""
        first, second = self.parameters
        match self.name:
            case "uniform":
                frozen: Any = scipy.stats.uniform(first, second - first)
            case "loguniform":
                frozen = scipy.stats.loguniform(first, second)
            case "normal":
                frozen = scipy.stats.norm(first, second)
            case _:
                frozen = scipy.stats.lognorm(second, scale=first)
        return np.asarray(frozen.ppf(part), dtype=float)


@dataclass(frozen=True)
class Varied:
    """A key of the scene, and its values one by one or their distribution."""

    key: str
    values: tuple[Any, ...] | Distribution


@dataclass(frozen=True)
class Sampling:
    """How values are combined: a method, the number of samples of distributions, and a seed."""

    method: str
    samples: int
    seed: int


@dataclass(frozen=True)
class Choose:
    """The rule for the best value of a key: the one with the least quantile of an output."""

    key: str
    output: str
    quantile: float


@dataclass(frozen=True)
class Study:
    """A study as its file has it."""

    title: str
    name: str
    scene: Scene  # With the values that the study sets, without those that it varies
    content: Content = field(repr=False)  # The same scene, as parsed
    folder: Path  # The folder of the scene's files
    varied: tuple[Varied, ...]
    sampling: Sampling
    outputs: Outputs
    choose: Choose | None
    text: str = field(repr=False)  # The TOML source

    __repr__ = short_repr

    @property
    def digest(self) -> str:
        """A hash of everything that the results depend on, files of the scene included."""
        parts = (self.varied, self.sampling, self.outputs)
        code = code_digest(*(f"slipmode.{package}" for package in ("rom", "fmu", "runner")))
        words = [code, self.content, repr(parts)]
        found = hashlib.sha256(json.dumps(words, default=str, sort_keys=True).encode())
        for path in self._files():
            found.update(f"{path.name} {path.stat().st_size}".encode())
            with path.open("rb") as file:
                found.update(hashlib.file_digest(file, "sha256").digest())
        return found.hexdigest()[:32]

    def _files(self) -> list[Path]:
        """Return the files that scenes of the study read, in a fixed order."""
        found = []
        for key in ("structure.matrices", "structure.mass", "preload.vector", "model.file"):
            names = [get(self.content, key)]
            for each in self.varied:
                if each.key == key and not isinstance(each.values, Distribution):
                    names += each.values
            for name in names:
                if isinstance(name, str):
                    found += source_files(self.folder / name)
        return found


def load_study(path: str | PathLike[str]) -> Study:
    """Read a study; its scene is a shipped one, or a file in the same folder.

    Raises SlipmodeError, naming the file and the key that is refused.
    """
    path = Path(path)
    if not path.exists():
        raise SlipmodeError(f"{path}: no such study file")
    text = read_text(path, only_unicode=True)
    with naming(path):
        return _study(text, path)


def _study(text: str, path: Path) -> Study:
    root = Table(parse_toml(text), STUDY)
    sampling_table, outputs_table = root["sampling"], root["outputs"]
    name = root["scene"]
    file = path.parent / name
    original = load_scene(file if file.is_file() else name)
    assert original.path is not None  # `load_scene` sets it
    content, folder = parse_toml(original.text), original.path.parent.resolve()
    content = _set(root["set"], content)
    scene = read_scene(content, folder, original.text)
    tables = root["vary"]
    if not tables:
        raise root.error("vary", "nothing varies; give [[vary]] with a key and its values")
    varied = tuple(_varied(each, f"vary[{k}]", content) for k, each in enumerate(tables))
    keys = [each.key for each in varied]
    for key in keys:
        if keys.count(key) > 1:
            raise root.error("vary", f"{key!r} is varied twice")
    outputs = _outputs(outputs_table, scene)
    return Study(
        title=root["title"] or path.stem,
        name=path.stem,
        scene=scene,
        content=content,
        folder=folder,
        varied=varied,
        sampling=_sampling(sampling_table, varied),
        outputs=outputs,
        choose=_choose(root["choose"], varied, outputs) if "choose" in root else None,
        text=text,
    )


def _set(values: Any, content: Content) -> Content:
    if not isinstance(values, Mapping):
        raise SlipmodeError('set: must be a table of keys of the scene, "run.step" = 0.1')
    for key, value in values.items():
        if isinstance(value, Mapping):
            raise SlipmodeError(
                f'set: keys with dots must be quoted, "{key}.{next(iter(value), "")}"'
            )
        check_key("set", key, content)
        content = with_value(content, key, value)
    return content


def _varied(table: Table, name: str, content: Content) -> Varied:
    key = table["key"]
    check_key(f"{name}.key", key, content)
    ways = [way for way in ("values", "from", "distribution") if way in table]
    if len(ways) != 1:
        raise table.error("values", "give one of values, from (to, points), and distribution")
    way, own = ways[0], (*ways,)
    if way == "from":
        own += ("to", "points", "spacing")
    elif way == "distribution":
        own += DISTRIBUTIONS[table["distribution"]]
    for other in table:
        if other not in ("key", *own):
            raise table.error(other, f"must be left out with {way}; allowed: {', '.join(own)}")
    if way == "from":
        return Varied(key, _range(table, whole=declared(key).kind.words == "integer"))
    if way == "distribution":
        return Varied(key, _distribution(table))
    values = table["values"]
    if not isinstance(values, list) or not values:
        raise table.error("values", "must be a list of at least one value")
    return Varied(key, tuple(copy.deepcopy(values)))


def _range(table: Table, *, whole: bool) -> tuple[float, ...]:
    first, last = table["from"], table["to"]
    logarithmic = table["spacing"] == "log"
    if logarithmic and not (first > 0.0 and last > 0.0):
        raise table.error("spacing", '"log" needs from > 0 and to > 0')
    space = np.geomspace if logarithmic else np.linspace
    values = space(first, last, table["points"]).tolist()
    if not whole:
        return tuple(values)
    if not all(value.is_integer() for value in values):
        raise table.error("points", "must give integers, which this key takes")
    return tuple(int(value) for value in values)


def _distribution(table: Table) -> Distribution:
    name = table["distribution"]
    first, second = DISTRIBUTIONS[name]
    positive = POSITIVE if name in ("loguniform", "lognormal") else FINITE
    a = table.read(first, number(positive))
    b = table.read(second, number(FINITE if second == "high" else POSITIVE))
    if second == "high" and b <= a:
        raise table.error(second, f"must be above {first} = {a:g}, got {b:g}")
    if name == "lognormal" and b > log(1e6):  # hardly meant: times or by a million
        raise table.error(second, "is the deviation of the logarithm; must be below 13.8")
    return Distribution(name, (a, b))


def _sampling(table: Table, varied: tuple[Varied, ...]) -> Sampling:
    random = [each for each in varied if isinstance(each.values, Distribution)]
    lengths = [len(each.values) for each in varied if not isinstance(each.values, Distribution)]
    method = table["method"] or ("sobol" if random else "grid")
    if random and method in ("grid", "list"):
        raise table.error("method", f'"{method}" needs values; {random[0].key} has a distribution')
    if not random and method not in ("grid", "list"):
        raise table.error("method", f'"{method}" needs a key with a distribution; or use "grid"')
    if method == "saltelli" and lengths:
        raise table.error("method", '"saltelli" needs distributions of all keys')
    for key in ("samples", "seed"):
        if key in table and not random:
            raise table.error(key, "needs a distribution; a grid has all its points")
    samples = table["samples"] if random else 1
    if method == "list" and len(set(lengths)) > 1:
        raise table.error("method", f'"list" needs as many values of each key, got {lengths}')
    size = float(np.prod([samples, *(lengths[:1] if method == "list" else lengths)], dtype=float))
    if size > _MANY:
        raise table.error("samples", f"must be at most 1e7 in all, got {size:g}")
    return Sampling(method, samples, table["seed"])


def _outputs(table: Table, scene: Scene) -> Outputs:
    modes = tuple(scene.modes.numbers)
    resonance = table["resonance"]
    if resonance is not None and not (
        isinstance(resonance, list) and resonance and set(map(str, resonance)) <= set(modes)
    ):
        raise table.error("resonance", f"must be a list of modes of {', '.join(modes)}")
    curve = None
    if "curve" in table:
        part, unit = table["curve"], scene.units.per_frequency
        mode = part.read("mode", choice(*modes))
        curve = Curve(mode, unit * part["from"], unit * part["to"], part["points"])
    times = table["times"] or ()
    if times and max(times) > scene.run.duration:
        raise table.error("times", f"must be at most run.duration = {scene.run.duration:g}")
    outputs = Outputs(
        steady=table["steady"],
        resonance=tuple(mode for mode in modes if mode in (resonance or ())),
        curve=curve,
        peak=table["peak"],
        times=times,
        recording=table["recording"],
        dofs=table["dofs"],
        mistuned=bool(scene.mistuning),
    )
    given = [kind for kind in (*Outputs.KINDS, "dofs") if getattr(outputs, kind)]
    if outputs.mistuned and given != ["curve"]:
        raise SlipmodeError(
            f"outputs: of a mistuned disk must be curve alone, got {', '.join(given) or 'none'}"
        )
    if not any(getattr(outputs, kind) for kind in Outputs.KINDS):
        raise SlipmodeError(f"outputs: is empty; give one of {', '.join(Outputs.KINDS)}")
    return outputs


def _choose(table: Table, varied: tuple[Varied, ...], outputs: Outputs) -> Choose:
    listed = [each.key for each in varied if not isinstance(each.values, Distribution)]
    if not listed:
        raise table.error("key", "must be a key that is varied by values, but there is none")
    key = table.read("key", choice(*listed))
    return Choose(key, table.read("output", choice(*outputs.single_numbers)), table["quantile"])
