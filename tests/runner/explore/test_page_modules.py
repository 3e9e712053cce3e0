"""Modules of the page without a browser, by Node."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from slipmode import runner

NODE = shutil.which("node")
PAGE = Path(runner.__file__).parent / "explore" / "page"

pytestmark = pytest.mark.skipif(NODE is None, reason="needs Node")


@pytest.fixture
def evaluate(tmp_path):
    """Returns the value of an expression of JavaScript, with modules of the page."""
    package = tmp_path / "node_modules" / "page"
    package.mkdir(parents=True)
    exports = {"type": "module", "exports": {"./*": "./*.js"}}
    (package / "package.json").write_text(json.dumps(exports))
    for module in PAGE.glob("*.js"):
        shutil.copy(module, package)
    (package / "uplot.js").write_text("export default class {}")

    def value(module, names, expression):
        script = f"import {{ {names} }} from 'page/{module}';"
        script += f"console.log(JSON.stringify({expression}));"
        command = [NODE, "--input-type=module", "-e", script]
        done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=True)
        return json.loads(done.stdout)

    return value


def branches(*rows_of_each):
    """Rows of branches with one mode, all stable: frequency and amplitude."""
    rows = [(f, a, 1, k) for k, each in enumerate(rows_of_each) for f, a in each]
    return json.dumps({"rows": np.array(rows).ravel().tolist(), "width": 4, "count": len(rows)})


WHOLE = [(1.0, 0.1), (1.5, 2.0), (2.0, 0.2)]
UP_TO_THE_TABLE = [(1.0, 0.1), (1.5, 2.0), (1.6, 3.0)]
ISOLA = [(1.3, 2.0), (1.5, 2.5), (1.4, 1.8), (1.3, 2.0)]


@pytest.mark.parametrize(
    ("given", "cut"),
    [
        ([WHOLE], False),
        ([WHOLE[::-1]], False),
        ([WHOLE, ISOLA], False),
        ([UP_TO_THE_TABLE], True),
        ([WHOLE, UP_TO_THE_TABLE], True),
        ([UP_TO_THE_TABLE[::-1], WHOLE], True),
        ([[(1.3, 2.0), (1.6, 2.0)]], True),
        ([], True),
    ],
)
def test_a_curve_that_leaves_the_table_is_named(evaluate, given, cut):
    assert evaluate("branches", "isCut", f"isCut({branches(*given)}, [1.0, 2.0])") is cut


def test_time_begins_at_0_before_the_first_step(evaluate):
    shown = evaluate("chart", "Chart", "Chart.prototype.range.call({}, 'x', 0, 0)")
    assert shown == [0, 1]
    assert evaluate("chart", "Chart", "Chart.prototype.range.call({}, 'x', 1, 3)") == [1, 3]
