"""Contacts gathered into as few patches as given motions need, with the error."""

import numpy as np
import pytest

from slipmode import rom

N = 12  # facets along a side


def interface():
    """A unit square on another, 0 above it, matching; its contacts and dofs."""
    x, y = np.meshgrid(np.linspace(0, 1, N + 1), np.linspace(0, 1, N + 1), indexing="ij")
    plane = np.stack((x.ravel(), y.ravel(), np.zeros(x.size)), axis=1)
    number = np.arange(x.size).reshape(x.shape)
    facets = np.stack(
        [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1
    ).reshape(-1, 4)
    nodes = np.concatenate((plane, plane))
    dofs = np.arange(nodes.size).reshape(-1, 3)
    pairs = rom.contact_pairs(
        nodes, dofs, facets, facets[:, ::-1] + len(plane), tolerance=1e-3, tangent=[1, 0, 0]
    )
    return pairs, plane


def shape(move):
    """Of all DOFs, where the lower square alone moves, by (nodes, 3)."""
    return np.concatenate((move, np.zeros_like(move))).ravel()


def motions(plane):
    """One is a shear along x; the other is felt near a corner alone, across the interface."""
    along, near = np.zeros_like(plane), np.zeros_like(plane)
    along[:, 1] = plane[:, 0]
    near[:, 2] = np.exp(-8.0 * np.hypot(plane[:, 0], plane[:, 1]))
    return np.column_stack((shape(along), shape(near)))


def test_a_motion_that_is_the_same_everywhere_needs_one_patch():
    pairs, plane = interface()
    found = rom.motion_patches(pairs, shape(np.full_like(plane, 0.3)), 1e-3)
    assert set(found.patch) == {0}
    np.testing.assert_allclose([found.variation, found.error], 0.0, atol=1e-14)


def test_a_shear_is_cut_across_and_not_along():
    """Strips of three columns of the 13, a twelfth apart: no fewer are within a tenth."""
    pairs, plane = interface()
    found = rom.motion_patches(pairs, motions(plane)[:, 0], 0.1)
    gathered = pairs.gathered(found.patch)
    assert len(gathered.area) == 5
    np.testing.assert_allclose(gathered.position[:, 1], 0.5, atol=1e-12)
    assert found.variation[0] == pytest.approx(1 / 12, rel=0.2)


@pytest.mark.parametrize("tolerance", [0.5, 0.2, 0.05])
def test_patches_move_as_their_contacts_within_the_tolerance(tolerance):
    pairs, plane = interface()
    shapes = motions(plane)
    found = rom.motion_patches(pairs, shapes, tolerance)
    gathered = pairs.gathered(found.patch)
    fine = (pairs.W.T @ shapes).reshape(len(pairs.area), 3, 2)
    coarse = (gathered.W.T @ shapes).reshape(len(gathered.area), 3, 2)
    off = np.linalg.norm(fine - coarse[found.patch], axis=1)
    size = np.linalg.norm(fine, axis=1)
    np.testing.assert_allclose(off.max(axis=0) / size.max(axis=0), found.variation, rtol=1e-9)
    assert found.variation.max() <= tolerance
    energy = [pairs.area @ size**2, gathered.area @ np.linalg.norm(coarse, axis=1) ** 2]
    np.testing.assert_allclose(energy[1] / energy[0], 1.0 - found.error**2, rtol=1e-9)


def test_patches_are_small_where_a_motion_varies():
    pairs, plane = interface()
    found = rom.motion_patches(pairs, motions(plane)[:, 1], 0.1)
    gathered = pairs.gathered(found.patch)
    distance = np.linalg.norm(gathered.position, axis=1)
    near, far = gathered.area[distance < 0.3], gathered.area[distance > 0.7]
    assert near.max() < 0.1 * far.max()
    assert len(gathered.area) < 0.5 * len(pairs.area)


def test_contacts_at_one_place_are_told_apart():
    pairs, plane = interface()
    shapes = motions(plane)[:, :1]
    same = rom.ContactPairs(
        **{name: getattr(pairs, name) for name in pairs.__dataclass_fields__}
        | {"position": np.zeros_like(pairs.position)}
    )
    assert rom.motion_patches(same, shapes, 1e-3).variation[0] <= 1e-3


@pytest.mark.parametrize(
    ("shapes", "tolerance", "complaint"),
    [
        (np.ones(5), 0.1, r"^shapes: must be finite .* \(1014, motions\), got shape \(5,\)"),
        (np.full(1014, np.nan), 0.1, r"^shapes: must be finite"),
        (np.eye(1014, 2) * [1.0, 0.0], 0.1, r"^shapes: motion 1 moves no contact"),
        (np.ones(1014), 0.0, r"^tolerance: must be above 0, at most 1, got 0.0"),
        (np.ones(1014), 1.5, r"^tolerance: must be above 0, at most 1, got 1.5"),
    ],
)
def test_bad_input_is_named(shapes, tolerance, complaint):
    with pytest.raises(rom.SlipmodeError, match=complaint):
        rom.motion_patches(interface()[0], shapes, tolerance)
