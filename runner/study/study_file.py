"""Reading a study file (TOML): a scene, what varies in it, and the outputs of each sample."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import log
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal

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
from slipmode.runner.scene.toml_table import (
    Content,
    get,
    refuse_given,
    refuse_if,
    required,
    section_of,
)
from slipmode.runner.scene.values import (
    FINITE,
    NON_NEGATIVE,
    POSITIVE,
    between,
    choice,
    number,
)
from slipmode.runner.study.sample_outputs import Curve, Outputs
from slipmode.runner.study.scene_keys import check_key, declared, with_value

DISTRIBUTIONS = {
    "uniform": ("low", "high"),
    "loguniform": ("low", "high"),
    "normal": ("mean", "deviation"),
    "lognormal": ("median", "sigma"),
}
_MANY = 10**7  # samples are kept as columns in memory: 80 MB each at this number
_AT_LEAST_ONE = replace(between(1, _MANY), text=">= 1")


@dataclass(frozen=True, kw_only=True)
class VaryTable:
    """A key of the scene that varies: by values, a range, or a distribution."""

    key: str
    values: Any = None
    from_: float | None = None
    to: float | None = None
    points: Annotated[int | None, _AT_LEAST_ONE] = None
    spacing: Literal["linear", "log"] = "linear"
    distribution: Annotated[str | None, choice(*DISTRIBUTIONS)] = None
    low: float | None = None
    high: float | None = None
    mean: float | None = None
    deviation: float | None = None
    median: float | None = None
    sigma: float | None = None


@dataclass(frozen=True, kw_only=True)
class Sampling:
    """How values are combined: a method, the number of samples of distributions, and a seed."""

    method: Literal["grid", "list", "sobol", "latin-hypercube", "saltelli"] | None = None
    samples: Annotated[int, _AT_LEAST_ONE] = 1
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class CurveTable:
    """A frequency response curve of each sample."""

    mode: str
    from_: Annotated[float, POSITIVE]
    to: Annotated[float, POSITIVE]
    points: Annotated[int, between(2, _MANY)]


@dataclass(frozen=True, kw_only=True)
class OutputsTable:
    """What is computed of each sample."""

    steady: bool = False
    resonance: Any = None
    curve: CurveTable | None = None
    peak: bool = False
    times: Annotated[tuple[float, ...], NON_NEGATIVE] = ()
    recording: bool = False
    dofs: tuple[int, ...] = ()


@dataclass(frozen=True)
class Choose:
    """The rule for the best value of a key: the one with the least quantile of an output."""

    key: str
    output: str
    quantile: Annotated[float, between(0, 1)] = 0.95


@dataclass(frozen=True, kw_only=True)
class StudyFile:
    """The file of a study."""

    title: str = ""
    scene: str
    set: Any = None
    vary: tuple[VaryTable, ...] = ()
    sampling: Sampling
    outputs: OutputsTable
    choose: Choose | None = None


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
    given = parse_toml(text)
    file: StudyFile = section_of(StudyFile).read(given)
    beside = path.parent / file.scene
    original = load_scene(beside if beside.is_file() else file.scene)
    assert original.path is not None  # `load_scene` sets it
    content, folder = parse_toml(original.text), original.path.parent.resolve()
    content = _set({} if file.set is None else file.set, content)
    scene = read_scene(content, folder, original.text)
    refuse_if(not file.vary, "vary: nothing varies; give [[vary]] with a key and its values")
    varied = tuple(
        _varied(each, f"vary[{k}]", given["vary"][k], content) for k, each in enumerate(file.vary)
    )
    keys = [each.key for each in varied]
    for key in keys:
        refuse_if(keys.count(key) > 1, f"vary: {key!r} is varied twice")
    outputs = _outputs(file.outputs, scene)
    if file.choose is not None:
        _check_choose(file.choose, varied, outputs)
    return Study(
        title=file.title or path.stem,
        name=path.stem,
        scene=scene,
        content=content,
        folder=folder,
        varied=varied,
        sampling=_sampling(file.sampling, given, varied),
        outputs=outputs,
        choose=file.choose,
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


def _varied(table: VaryTable, path: str, given: Content, content: Content) -> Varied:
    check_key(f"{path}.key", table.key, content)
    ways: list[str] = [way for way in ("values", "from", "distribution") if way in given]
    one = f"{path}.values: give one of values, from (to, points), and distribution"
    refuse_if(len(ways) != 1, one)
    way, own = ways[0], ways
    if way == "from":
        own = [*own, "to", "points"]
    elif way == "distribution":
        own = [*own, *DISTRIBUTIONS[table.distribution or ""]]
    for key in own:
        refuse_if(key not in given, f"{path}.{key}: is missing")
    own = [*own, "spacing"] if way == "from" else own
    for key in given:
        reason = f"must be left out with {way}; allowed: {', '.join(own)}"
        refuse_if(key not in ("key", *own), f"{path}.{key}: {reason}")
    if way == "from":
        whole = declared(table.key).kind.words == "integer"
        return Varied(table.key, _range(table, path, whole=whole))
    if way == "distribution":
        return Varied(table.key, _distribution(table, path))
    listed = isinstance(table.values, list) and bool(table.values)
    refuse_if(not listed, f"{path}.values: must be a list of at least one value")
    return Varied(table.key, tuple(copy.deepcopy(table.values)))


def _range(table: VaryTable, path: str, *, whole: bool) -> tuple[float, ...]:
    first, last, points = table.from_, table.to, table.points
    assert first is not None and last is not None and points is not None  # `_varied` checks it
    logarithmic = table.spacing == "log"
    positive = first > 0.0 and last > 0.0
    refuse_if(logarithmic and not positive, f'{path}.spacing: "log" needs from > 0 and to > 0')
    space = np.geomspace if logarithmic else np.linspace
    values = space(first, last, points).tolist()
    if not whole:
        return tuple(values)
    integral = all(value.is_integer() for value in values)
    refuse_if(not integral, f"{path}.points: must give integers, which this key takes")
    return tuple(int(value) for value in values)


def _distribution(table: VaryTable, path: str) -> Distribution:
    name = table.distribution or ""
    first, second = DISTRIBUTIONS[name]
    positive = POSITIVE if name in ("loguniform", "lognormal") else FINITE
    a = number(positive).read(f"{path}.{first}", getattr(table, first))
    rule = FINITE if second == "high" else POSITIVE
    b = number(rule).read(f"{path}.{second}", getattr(table, second))
    above = f"{path}.{second}: must be above {first} = {a:g}, got {b:g}"
    refuse_if(second == "high" and b <= a, above)
    # hardly meant: times or by a million
    size = f"{path}.{second}: is the deviation of the logarithm; must be below 13.8"
    refuse_if(name == "lognormal" and b > log(1e6), size)
    return Distribution(name, (a, b))


def _sampling(table: Sampling, given: Content, varied: tuple[Varied, ...]) -> Sampling:
    random = [each.key for each in varied if isinstance(each.values, Distribution)]
    lengths = [len(each.values) for each in varied if not isinstance(each.values, Distribution)]
    method = table.method or ("sobol" if random else "grid")
    of, combines = f'sampling.method: "{method}"', method in ("grid", "list")
    values = f"{of} needs values; {''.join(random[:1])} has a distribution"
    refuse_if(bool(random) and combines, values)
    distribution = f'{of} needs a key with a distribution; or use "grid"'
    refuse_if(not random and not combines, distribution)
    refuse_if(method == "saltelli" and bool(lengths), f"{of} needs distributions of all keys")
    if random:
        required("sampling.samples", get(given, "sampling.samples"))
    else:
        points = "needs a distribution; a grid has all its points"
        refuse_given(given, "sampling", ("samples", "seed"), points)
    different = method == "list" and len(set(lengths)) > 1
    refuse_if(different, f"{of} needs as many values of each key, got {lengths}")
    factors = [table.samples, *(lengths[:1] if method == "list" else lengths)]
    size = float(np.prod(factors, dtype=float))
    refuse_if(size > _MANY, f"sampling.samples: must be at most 1e7 in all, got {size:g}")
    return replace(table, method=method)


def _outputs(table: OutputsTable, scene: Scene) -> Outputs:
    modes = tuple(scene.modes.numbers)
    resonance = [] if table.resonance is None else table.resonance
    valid = isinstance(resonance, list) and set(map(str, resonance)) <= set(modes)
    valid = valid and bool(resonance or table.resonance is None)
    refuse_if(not valid, f"outputs.resonance: must be a list of modes of {', '.join(modes)}")
    curve, unit = table.curve, scene.units.per_frequency
    range_of_curve = None
    if curve is not None:
        choice(*modes).read("outputs.curve.mode", curve.mode)
        range_of_curve = Curve(curve.mode, unit * curve.from_, unit * curve.to, curve.points)
    most = f"outputs.times: must be at most run.duration = {scene.run.duration:g}"
    refuse_if(max(table.times, default=0.0) > scene.run.duration, most)
    outputs = Outputs(
        steady=table.steady,
        resonance=tuple(mode for mode in modes if mode in resonance),
        curve=range_of_curve,
        peak=table.peak,
        times=table.times,
        recording=table.recording,
        dofs=table.dofs,
        mistuned=bool(scene.mistuning),
    )
    given = [kind for kind in (*Outputs.KINDS, "dofs") if getattr(outputs, kind)]
    alone = f"outputs: of a mistuned disk must be curve alone, got {', '.join(given) or 'none'}"
    refuse_if(outputs.mistuned and given != ["curve"], alone)
    empty = f"outputs: is empty; give one of {', '.join(Outputs.KINDS)}"
    refuse_if(not any(getattr(outputs, kind) for kind in Outputs.KINDS), empty)
    return outputs


def _check_choose(choose: Choose, varied: tuple[Varied, ...], outputs: Outputs) -> None:
    listed = [each.key for each in varied if not isinstance(each.values, Distribution)]
    none = "choose.key: must be a key that is varied by values, but there is none"
    refuse_if(not listed, none)
    choice(*listed).read("choose.key", choose.key)
    choice(*outputs.single_numbers).read("choose.output", choose.output)
