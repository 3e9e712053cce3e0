"""An Abaqus deck as that of the Brake-Reuss beam, small: two lapped bars and two bolts.

A bolt is a washer above and one below, tied to the bars on meshes that do not match, whose mean
motions are equal but for the direction of its axis.
"""

from pathlib import Path

import numpy as np

# cells, lower corner, upper corner [m]
BARS = {
    "bots": ((12, 2, 2), (0.0, 0.0, -0.01), (0.12, 0.02, 0.0)),
    "tops": ((12, 2, 2), (0.06, 0.0, 0.0), (0.18, 0.02, 0.01)),
}
BOLTS = (0.075, 0.105)  # x of their axes [m]
WASHER = 0.006  # half its width [m]
_CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)


def write_lapped_deck(path: Path) -> Path:
    """The deck; each body is written in a frame of its own, turned by a quarter."""
    lines, nodes, cells = ["*Heading", "**"], 0, 0
    joints: list[str] = []
    bodies = dict(BARS)
    for k, x in enumerate(BOLTS):
        for side, z in (("above", 0.01), ("below", -0.012)):
            low = (x - WASHER, 0.01 - WASHER, z)
            bodies[f"{side}{k}"] = ((2, 2, 1), low, (x + WASHER, 0.01 + WASHER, z + 0.002))
    for name, (count, low, high) in bodies.items():
        axes = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, count, strict=True)]
        places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        number = np.arange(len(places)).reshape([n + 1 for n in count]) + nodes + 1
        hexes = np.stack(
            [number[tuple(slice(c, c - 1 or None) for c in corner)] for corner in _CORNERS], -1
        )
        order = np.arange(hexes[..., 0].size).reshape(count) + cells + 1
        # x' along y, y' along -x, seen from the origin of the frame
        lines += ["*System", "1., 0., 0., 1., 1., 0.", "0., 0., 0."]
        local = np.stack((places[:, 1], 1.0 - places[:, 0], places[:, 2]), axis=1)
        own = range(nodes + 1, nodes + 1 + len(places))
        lines += [
            "*Node",
            *(
                f"{n}, {x:.12g}, {y:.12g}, {z:.12g}"
                for n, (x, y, z) in zip(own, local, strict=True)
            ),
        ]
        lines += ["*Element, type=C3D8R"]
        lines += [
            f"{e}, " + ", ".join(map(str, corners))
            for e, corners in zip(order.ravel(), hexes.reshape(-1, 8), strict=True)
        ]
        for face, layer in (("S1", order[:, :, 0]), ("S2", order[:, :, -1])):
            lines += [f"*Elset, elset=_{name}_{face}", *(f"{e}," for e in layer.ravel())]
            lines += [f"*Surface, type=ELEMENT, name={name}_{face}", f"_{name}_{face}, {face}"]
        nodes, cells = nodes + len(places), cells + order.size
    for name, face in (("bots", "S2"), ("tops", "S1")):
        joints += [f"*Surface, type=ELEMENT, name={name}", f"_{name}_{face}, {face}"]
    lines += ["*System"]
    for k, x in enumerate(BOLTS):
        for side, facing, bar, outer in (
            ("above", "S1", "tops_S2", "S2"),
            ("below", "S2", "bots_S1", "S1"),
        ):
            nodes += 1
            lines += ["*Node", f"{nodes}, {x}, 0.01, 0.", f"*Nset, nset={side}{k}", f"{nodes},"]
            joints += [
                f"*Coupling, ref node={side}{k}, surface={side}{k}_{outer}",
                "*Distributing",
            ]
            joints += ["*Tie, adjust=yes", f"{side}{k}_{facing}, {bar}"]
        for direction in (1, 2, 4, 5, 6):
            joints += ["*Equation", "2", f"above{k}, {direction}, 1., below{k}, {direction}, -1."]
    lines += joints
    lines += ["*Material, name=STEEL", "*Density", "7800.,", "*Elastic", " 2e+11, 0.3"]
    lines += ["*Step", "*Substructure Load Case", "*Cload"]
    lines += [
        f"{side}{k}, 3, {f}" for k in range(2) for side, f in (("above", -1.0), ("below", 1.0))
    ]
    path.write_text("\n".join([*lines, "*End Step", ""]))
    return path
