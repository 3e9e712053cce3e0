"""Contacts gathered into as few patches as given motions need, with the error."""

import numpy as np
import pytest

from slipmode import rom

N = 12  # facets along a side


def interface():
    """A unit square on another, 0 above it, matching; its contacts, and places of its nodes."""
    x, y = np.meshgrid(np.linspace(0, 1, N + 1), np.linspace(0, 1, N + 1), indexing="ij")
    plane = np.stack((x.ravel(), y.ravel(), np.zeros(x.size)), axis=1)
    number = np.arange(x.size).reshape(x.shape)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    facets = np.stack(corners, axis=-1).reshape(-1, 4)
    nodes = np.concatenate((plane, plane))
    pairs = rom.contact_pairs(
        *(nodes, np.arange(nodes.size).reshape(-1, 3), facets, facets[:, ::-1] + len(plane)),
        tolerance=1e-3,
        tangent=[1, 0, 0],
    )
    return pairs, plane


PAIRS, PLANE = interface()


def shape(move):
    """Of all DOFs, where the lower square alone moves, by (nodes, 3)."""
    return np.concatenate((move, np.zeros_like(move))).ravel()


ALONG, NEAR = np.zeros_like(PLANE), np.zeros_like(PLANE)
ALONG[:, 1] = PLANE[:, 0]  # a shear along x
NEAR[:, 2] = np.exp(-8.0 * np.hypot(PLANE[:, 0], PLANE[:, 1]))  # near a corner alone
SHAPES = np.column_stack((shape(ALONG), shape(NEAR)))


@pytest.mark.oracle
def test_patches_are_cut_where_a_motion_varies():
    """None if it is uniform; a shear into strips across it, of three columns of the 13."""
    uniform = rom.motion_patches(PAIRS, shape(np.full_like(PLANE, 0.3)), 1e-3)
    assert set(uniform.patch) == {0}
    np.testing.assert_allclose([uniform.variation, uniform.error], 0.0, atol=1e-14)
    shear = PAIRS.gathered(rom.motion_patches(PAIRS, SHAPES[:, 0], 0.1).patch)
    assert len(shear.area) == 5
    np.testing.assert_allclose(shear.position[:, 1], 0.5, atol=1e-12)
    corner = PAIRS.gathered(rom.motion_patches(PAIRS, SHAPES[:, 1], 0.1).patch)
    distance = np.linalg.norm(corner.position, axis=1)
    assert corner.area[distance < 0.3].max() < 0.1 * corner.area[distance > 0.7].max()


@pytest.mark.oracle
@pytest.mark.parametrize("tolerance", [0.5, 0.05])
def test_the_stated_deviations_are_those_of_the_contacts_from_their_patches(tolerance):
    """By hand: the largest one, and the energy 1 - error^2 that springs keep."""
    found = rom.motion_patches(PAIRS, SHAPES, tolerance)
    gathered = PAIRS.gathered(found.patch)
    fine = (PAIRS.W.T @ SHAPES).reshape(len(PAIRS.area), 3, 2)
    coarse = (gathered.W.T @ SHAPES).reshape(len(gathered.area), 3, 2)
    off = np.linalg.norm(fine - coarse[found.patch], axis=1)
    size = np.linalg.norm(fine, axis=1)
    np.testing.assert_allclose(off.max(axis=0) / size.max(axis=0), found.variation, rtol=1e-9)
    assert found.variation.max() <= tolerance
    energy = [PAIRS.area @ size**2, gathered.area @ np.linalg.norm(coarse, axis=1) ** 2]
    np.testing.assert_allclose(energy[1] / energy[0], 1.0 - found.error**2, rtol=1e-9)
