"""Recordings of millions of samples take bounded memory."""

import subprocess
import sys

import pytest

LONG = """
import resource, sys
from slipmode.runner import load_scene, parse_scene, run

end = 30_000.0
text = load_scene("one-mode").text
text = text[: text.index("[[contact]]")].replace("duration = ", "duration = 30000.0 # ")
text += f"[[contact]]\\nwindow = [0.0, {end}]\\nsamples_per_period = 256\\n"
run("one-mode", sys.argv[1])  # what a run takes anyway
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
recording = run(parse_scene(text, "."), sys.argv[1])
print(recording.samples, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)
"""


@pytest.mark.slow
def test_a_million_contact_samples_in_bounded_memory(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", LONG, tmp_path], capture_output=True, text=True, check=True
    )
    samples, mebibytes = map(float, done.stdout.split()[-2:])
    assert samples > 1e6
    assert mebibytes < 200.0  # two contacts with three doubles a sample would be 70 MiB
