"""DOFs that a scene names by node and direction, as the program that made the structure does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from slipmode.rom.errors import SlipmodeError
from slipmode.rom.structure.structure import Structure
from slipmode.runner.scene.toml_table import Table

if TYPE_CHECKING:
    from slipmode.runner.scene.sections import Scene


@dataclass(frozen=True)
class NodeDof:
    """A node, and a direction "x", "y", "z", "rx", "ry" or "rz"."""

    node: int
    direction: str

    def dof(self, key: str, structure: Structure) -> int:
        """Its DOF in a structure; a refusal names the key."""
        if structure.labels is None:
            raise SlipmodeError(f"{key}: the matrices name no nodes; give DOFs")
        try:
            return structure.labels.dof(self.node, self.direction)
        except SlipmodeError as error:
            raise SlipmodeError(f"{key}: {error}") from None


def read_contacts(table: Table, key: str) -> tuple[tuple[int | str, ...], ...] | None:
    """[[node, direction], ...] or [[node, node, direction], ...]; None if the key is absent."""
    if key not in table:
        return None
    rows = table.rows(key, "[node, direction] or [node, node, direction]")
    for row in rows:
        if len(row) not in (2, 3) or not isinstance(row[-1], str) or not _whole(row[:-1]):
            raise table.error(
                key, f"must be [node, direction] or [node, node, direction], got {list(row)}"
            )
    return rows


def read_nodes(table: Table, key: str) -> tuple[NodeDof, ...]:
    """[[node, direction], ...]; none if the key is absent."""
    rows = table.rows(key, "[node, direction]") if key in table else ()
    for row in rows:
        if len(row) != 2 or not isinstance(row[1], str) or not _whole(row[:1]):
            raise table.error(key, f"must be [node, direction], got {list(row)}")
    return tuple(NodeDof(int(node), str(direction)) for node, direction in rows)


def located(scene: Scene, structure: Structure) -> Scene:
    """The scene with DOFs where it names nodes."""
    forcing = {
        mode: replace(each, pattern=each.pattern.dof(f"forcing.{mode}", structure))
        if isinstance(each.pattern, NodeDof)
        else each
        for mode, each in scene.forcing.items()
    }
    named = tuple(node.dof("output.nodes", structure) for node in scene.output.nodes)
    if len({*scene.output.elastic, *named}) < len(scene.output.elastic) + len(named):
        raise SlipmodeError("output.nodes: DOFs must be distinct, those of output.elastic too")
    output = replace(scene.output, elastic=scene.output.elastic + named, nodes=())
    return replace(scene, forcing=forcing, output=output)


def _whole(values: tuple[int | str, ...]) -> bool:
    return all(isinstance(value, int) and not isinstance(value, bool) for value in values)
