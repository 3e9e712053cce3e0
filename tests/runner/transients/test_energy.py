"""The recorded energy balance: input = contacts + structural damping + what the modes store."""

import numpy as np
import pytest

from slipmode.runner import load_scene, run, shipped_scenes
from slipmode.runner.recording.channels import energy


def columns(channel, *names):
    return [channel.column(name) for name in names]


def integral(power, time):
    return np.append(0.0, np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time)))


def modal_energy(data, natural):
    """Energy of both modes from the recorded amplitudes, and the times."""
    modes, forcing = data.channels["/modes"], data.channels["/forcing"]
    real, imag, omega = (
        np.stack([channel.column(f"{mode}_{name}") for mode in "AB"], axis=1)
        for channel, name in ((modes, "re"), (modes, "im"), (forcing, "frequency"))
    )
    a = real + 1j * imag
    v = np.gradient(a, modes.time, axis=0) + 1j * omega * a
    return np.sum(np.abs(v) ** 2 + np.abs(natural * a) ** 2, axis=1), modes.time


@pytest.fixture(params=["slow time", "full order"])
def recorded(request, shipped_scene, tmp_path):
    """The shipped two-mode scene, and its plan."""
    if request.param == "slow time":
        recording = shipped_scene("two-mode")
    else:
        text = shipped_scenes()["two-mode"].read_text(encoding="utf-8")
        scene = tmp_path / "full.toml"
        scene.write_text(text.replace("tolerance = 1e-3", 'table = "none"'), encoding="utf-8")
        recording = run(scene, tmp_path)
    return recording.read(), recording.plan


def test_the_powers_add_up_and_the_stored_power_is_the_change_of_energy(recorded):
    data, plan = recorded
    channel = data.channels["/energy"]
    assert channel.channel.units == energy().units
    put_in, contacts, structure, stored = columns(
        channel, "input_power", "dissipated_power", "structural_power", "stored_power"
    )
    np.testing.assert_allclose(put_in, contacts + structure + stored, rtol=1e-12, atol=1e-15)
    found, time = modal_energy(data, plan.excited.reduced.frequency)
    change = integral(stored, time) - (found - found[0])
    # relative to the energy put in; measured 4.0e-4 in slow time, 5.2e-5 at full order
    assert np.abs(change).max() < load_scene("two-mode").model.tolerance * put_in.sum()
    assert structure.min() >= 0.0
    assert structure[-1] == pytest.approx(0.42 * put_in[-1], rel=0.05)  # measured 0.4237, 0.4238
    assert abs(stored[-1]) < 5e-3 * put_in[-1]  # steady; measured 2.1e-3, 1.8e-3
