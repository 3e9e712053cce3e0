"""The FMU in other importers than FMPy, which agree with the component; each in a process."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest
from fmu_fixtures import component

IMPORTERS = Path(__file__).parent / "importers"
STEPS = 100  # of 1 s
NAMES = (
    *("A_re", "A_im", "B_re", "B_im", "theta_A", "theta_B"),
    *("input_power", "dissipated_power", "dissipated_energy"),
    *("contact_0_x", "contact_1_v", "contact_0_f", "x_0", "x_1"),
)


@pytest.mark.parametrize(
    ("package", "script", "fmi", "reads_all"),
    [
        ("ecospy", "ecos.py", 2, False),
        ("ecospy", "ecos.py", 3, False),
        ("libcosimpy", "cosim.py", 2, True),  # after every step
    ],
)
def test_final_values_are_those_of_the_component(
    fmus, two_mode_model, package, script, fmi, reads_all
):
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed: pip install 'slipmode[importers]'")
    command = [sys.executable, IMPORTERS / script, fmus[fmi], str(STEPS), *NAMES]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    last = done.stderr.splitlines()[-1] if done.stderr else ""
    if done.returncode and last.startswith("OSError: "):  # a library that it needs
        pytest.skip(f"{package} does not load here: {last}")
    assert done.returncode == 0, done.stderr
    stepped = component(two_mode_model)
    for k in range(STEPS):
        stepped.do_step(float(k), 1.0)
        if reads_all or k == STEPS - 1:
            expected = stepped.outputs()
    found = [float.fromhex(word) for word in done.stdout.splitlines()[-1].split()]
    assert found == pytest.approx([expected[name] for name in NAMES], rel=1e-12, abs=0)
