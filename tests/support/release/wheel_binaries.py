"""What a shared library shows and needs, whatever system it is for."""

from dataclasses import dataclass

import lief


@dataclass(frozen=True)
class Binary:
    """A shared library: `newest` is the newest version of glibc, or macOS, that it asks for."""

    platform: str
    exported: frozenset[str]
    needed: frozenset[str]
    newest: tuple[int, ...]
    paths: tuple[str, ...]


MACHINES = {
    "X86_64": "x86_64",
    "AMD64": "x86_64",
    "AARCH64": "aarch64",
    "ARM64": "aarch64",
}


def inspect(content):
    """Read a library, given as bytes."""
    found = lief.parse(content)
    header = found.header
    if isinstance(found, lief.ELF.Binary):
        asked = {
            tuple(map(int, version.name.removeprefix("GLIBC_").split(".")))
            for library in found.symbols_version_requirement
            for version in library.get_auxiliary_symbols()
        }
        return Binary(
            f"{MACHINES[header.machine_type.name]}-linux",
            frozenset(s.name for s in found.exported_symbols),
            frozenset(found.libraries),
            max(asked),
            tuple(e.name for e in found.dynamic_entries if e.tag.name in ("RPATH", "RUNPATH")),
        )
    if isinstance(found, lief.PE.Binary):
        return Binary(
            f"{MACHINES[header.machine.name]}-windows",
            frozenset(e.name for e in found.get_export().entries),
            frozenset(i.name for i in found.imports),
            (),
            (),
        )
    return Binary(
        f"{MACHINES[header.cpu_type.name]}-darwin",
        frozenset(s.name.removeprefix("_") for s in found.exported_symbols),
        frozenset(library.name for library in found.libraries),
        tuple(found.build_version.minos),
        tuple(rpath.path for rpath in found.rpaths),
    )
