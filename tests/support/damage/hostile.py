"""Arrays and archives that claim more than they contain, or unpack to more than is reasonable."""

import io
import zipfile

import numpy as np

MIB = 1024 * 1024


def claiming(shape, kind="<f8"):
    """Bytes of an .npy file whose header claims a shape, with a kilobyte of zeros."""
    file = io.BytesIO()
    header = {"descr": kind, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(file, header)
    return file.getvalue() + bytes(1024)


def zeros(mib):
    """Bytes of an .npy file of so many MiB of zeros, in parts."""
    yield claiming((mib * MIB // 8,))[:-1024]
    for _ in range(mib):
        yield bytes(MIB)


def rewritten(path, target, **members):
    """A zip archive with other members, each as bytes or as parts of bytes, strongly compressed.

    "__" in their names stands for "/", and .npy is added.
    """
    others = {f"{name.replace('__', '/')}.npy": content for name, content in members.items()}
    packed = {"compression": zipfile.ZIP_DEFLATED, "compresslevel": 1}
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(target, "w", **packed) as archive:
        for name in source.namelist():
            if name not in others:
                archive.writestr(name, source.read(name))
        for name, content in others.items():
            with archive.open(name, "w") as member:
                for part in [content] if isinstance(content, bytes) else content:
                    member.write(part)
    return target
