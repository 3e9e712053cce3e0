"""Structures, drawn and stated, and writers of their matrices in the files of programs.

Writers are pyyeti (OUTPUT4), scipy.io (Matrix Market, MATLAB 4 and 5), h5py (MATLAB 7.3), NumPy,
and functions here that follow the manuals: Harwell-Boeing with Fortran
formats, DMIG in small, large and free fields, OUTPUT4 with words of 64 bits, Abaqus, CalculiX.
Each returns the file and arguments of `load_structure`.
"""

import struct

import numpy as np
import pytest
import scipy.io
import scipy.sparse

LENGTH, EI = 0.1, 20.0  # of an element [m], [N m^2]


def beam(nodes):
    """Stiffness and mass of a clamped beam with DOFs w, theta at each free node."""
    h = LENGTH
    element = (EI / h**3) * np.array(
        [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
         [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
    )  # fmt: skip
    K = np.zeros((2 * nodes + 2, 2 * nodes + 2))
    for k in range(nodes):
        K[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += element
    return K[2:, 2:], np.diag(np.tile([0.05, 0.0], nodes))


def translations(nodes):
    """Exact stiffness of the translations, and their mass."""
    x = LENGTH * np.arange(1, nodes + 1)
    a, b = np.minimum.outer(x, x), np.maximum.outer(x, x)
    return np.linalg.inv(a**2 * (3 * b - a) / (6 * EI)), 0.05 * np.eye(nodes)


class Drawn:
    """A structure of some nodes with one to three directions, some DOFs perhaps without mass."""

    def __init__(self, seed):
        self.random = random = np.random.default_rng(seed)
        nodes = random.choice(np.arange(1, 90000), int(random.integers(2, 6)), replace=False)
        self.labels = [(int(n), k) for n in np.sort(nodes) for k in (1, 2, 3)[: seed % 3 + 1]]
        size = self.size = len(self.labels)
        K = random.standard_normal((size, size)) * (random.random((size, size)) < 0.6)
        self.K = np.array([[float(f"{v:.3e}") for v in row] for row in 1e5 * (K @ K.T)])
        self.K += np.diag(1e3 + np.ceil(abs(self.K).sum(axis=1)))
        mass = np.round(random.uniform(0.5, 2.0, size), 3)
        if random.random() < 0.4:
            mass[random.integers(1, size)] = 0.0
        self.M = np.diag(mass)
        self.path = None

    def draw(self, *choices):
        return choices[int(self.random.integers(len(choices)))]

    def triangle(self, matrix, upper=False):
        rows, columns = np.nonzero(np.triu(matrix) if upper else np.tril(matrix))
        return [(int(r), int(c), float(matrix[r, c])) for r, c in zip(rows, columns, strict=True)]


def pyyeti_op4(drawn, folder):
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    names = drawn.draw(("KGG", "MGG"), ("KAA", "MAA"), ("KXX", "MXX"))
    matrices = dict(zip(names, (drawn.K, drawn.M), strict=True))
    if drawn.draw(True, False):  # EXTSEOUT writes these, and more
        others = {n: drawn.random.random((drawn.size, 3)) for n in ("PA", "MUG1", "MES1", "KELM")}
        others["K4" + names[0][1:]] = drawn.K
        others["MEE1"] = drawn.random.random((drawn.size, drawn.size))
        matrices = others | matrices
    path = folder / drawn.draw("a.op4", "A.OP4")
    op4.write(
        str(path),
        matrices,
        binary=drawn.draw(True, False),
        sparse=drawn.draw("dense", "bigmat", "nonbigmat"),
        endian=drawn.draw("<", ">"),
        digits=16,
    )
    return path, {}


def op4_of_64_bits(drawn, folder):
    """Nastran with ILP-64 (MODE=I8): all words have eight bytes."""

    def record(content):
        return struct.pack("<i", len(content)) + content + struct.pack("<i", len(content))

    content, size = b"", drawn.size
    for name, matrix in (("KGG", drawn.K), ("MGG", drawn.M)):
        content += record(struct.pack("<4q", size, size, 6, 2) + name.encode().ljust(16))
        for column in range(size):
            content += record(struct.pack(f"<3q{size}d", column + 1, 1, size, *matrix[column]))
        content += record(struct.pack("<3qd", size + 1, 1, 1, 1.0))
    (folder / "long.op4").write_bytes(content)
    return folder / "long.op4", {}


def nastran_number(value, width):
    """The most digits that fit in a field; in small fields without the letter of the exponent."""
    for digits in range(width, 0, -1):
        word = f"{value:.{digits}E}"
        mantissa, exponent = word.split("E")
        word = (
            f"{mantissa}{int(exponent):+d}" if width == 8 else f"{mantissa}D{int(exponent):+03d}"
        )
        if len(word) <= width:
            return word
    raise AssertionError(value)


def dmig(drawn, folder):
    """The bulk data of Nastran's Quick Reference Guide, in one of its three kinds of field."""
    width = drawn.draw(8, 16, 0)

    def line(first, *words):
        if width == 0:
            return ",".join([first, *(str(word) for word in words)])
        star = "*" if width == 16 else ""
        return f"{first + star:8}" + "".join(f"{word:>{width}}" for word in words)

    def value(v):
        return nastran_number(v, width) if width else f"{v:.12e}"

    lines = ["$TITLE   = \xe9prouvette", "GRID           7       0      0.      0.      0."]
    for name, matrix in (("KAAX", drawn.K), ("K4AAX", drawn.K), ("MAAX", drawn.M)):
        lines.append(f"DMIG    {name:8}{0:8}{6:8}{2:8}{0:8}{'':16}{drawn.size:8}")
        for column in range(drawn.size):
            head = [name, *drawn.labels[column], ""]
            for row, _, v in (e for e in drawn.triangle(matrix) if e[1] == column):
                entry = [*drawn.labels[row], value(v), ""]
                if not head:
                    lines.append(line("" if width else "+", *entry))
                elif width == 16:
                    lines += [line("DMIG", *head), line("", *entry)]
                else:
                    lines.append(line("DMIG", *head, *entry))
                head = []
    lines.append(f"DMIG    PAX     {0:8}{9:8}{2:8}{0:8}{'':16}{1:8}")
    lines.append(f"DMIG    PAX     {1:8}{0:8}{'':8}{drawn.labels[0][0]:8}{1:8}     1.0")
    path = folder / drawn.draw("b.pch", "B.PCH")
    path.write_text("\n".join(lines) + "\n", encoding="latin-1")
    return path, {"rtol": 1e-2 if width == 8 else 1e-9}


def matrix_market(drawn, folder):
    for name, matrix in (("k", drawn.K), ("m", drawn.M)):
        stored = drawn.draw(scipy.sparse.coo_array, np.asarray)(matrix)
        path, symmetry = folder / f"{name}.mtx", drawn.draw("symmetric", "general")
        scipy.io.mmwrite(path, stored, "\n aus M\xfcnchen", symmetry=symmetry, precision=17)
        text = path.read_text(encoding="utf-8")
        head, _, body = text.partition("\n")
        changed = text.replace("e+", "D+"), text.replace("e+", "+"), text.replace("\n", "\r\n")
        text = drawn.draw(text, *changed, f"\n{head.lower()}\n{body}\n% end\n")
        encoding = drawn.draw("utf-8", "utf-8-sig", "utf-16", "latin-1")
        path.write_bytes(text.encode(encoding, "replace"))
    return folder / "k.mtx", {"mass": folder / "m.mtx"}


def harwell_boeing(drawn, folder):
    """The users' guide of the collection: any width, with E or D, and right-hand sides."""

    def block(words, count, width):
        rows = [words[k : k + count] for k in range(0, len(words), count)]
        return ["".join(str(word).rjust(width) for word in row) for row in rows]

    for name, matrix in (("k", drawn.K), ("m", drawn.M)):
        symmetric = drawn.draw(True, False)
        stored = scipy.sparse.csc_array(np.tril(matrix) if symmetric else matrix)
        stored.sort_indices()
        width, digits, letter = drawn.draw((25, 16, "E"), (26, 16, "D"), (24, 16, "E"))
        per_line, scale = drawn.draw(1, 2, 3, 4), drawn.draw("", "1P", "1P,")
        ints = drawn.draw(5, 8, 10, 14)
        sides = [1.0] * drawn.size if drawn.draw(True, False) else []
        values, right = (
            block([f"{v:.{digits}E}".replace("E", letter) for v in each], per_line, width)
            for each in (stored.data, sides)
        )
        pointers, rows = block(stored.indptr + 1, 4, ints), block(stored.indices + 1, 5, ints)
        cards = [len(pointers), len(rows), len(values), len(right)]
        form = f"({scale}{per_line}{letter}{width}.{digits})"
        counts = (drawn.size, drawn.size, stored.nnz, 0)
        head = [
            "Steifigkeit f\xfcr ANSYS".ljust(72) + f"{name.upper():8}",
            "".join(f"{v:14}" for v in [sum(cards), *cards]),
            f"{'RSA' if symmetric else 'RUA':14}" + "".join(f"{v:14}" for v in counts),
            f"{f'(4I{ints})':16}{f'(5I{ints})':16}{form:20}{form:20}",
        ]
        head += [f"{'F':14}{1:14}{0:14}"] if right else []
        text = "\n".join([*head, *pointers, *rows, *values, *right]) + "\n"
        (folder / f"{name}.rsa").write_text(text, encoding="latin-1")
    return folder / "k.rsa", {"mass": folder / "m.rsa"}


def workspace(drawn):
    """Variables as users have them: names of the matrices, and others."""
    k, m = drawn.draw(("K", "M"), ("Kglobal", "Mglobal"), ("stiffnessMatrix", "massMatrix"))
    modes, mesh = (drawn.random.random((drawn.size, n)) for n in (drawn.size, drawn.size + 3))
    return k, m, {"dt": 0.1, "Modes": modes, "mesh": mesh, "D": np.diag(1.0 + mesh[:, 0])}


def matlab(drawn, folder):
    k, m, others = workspace(drawn)
    store = drawn.draw(scipy.sparse.csc_array, np.asarray)
    matrices, arguments = {k: store(drawn.K), m: store(drawn.M)}, {}
    kind = drawn.draw("4", "5", "struct", "names")
    if kind == "struct":
        matrices = {"sys": matrices | {"name": "blade"}, "note": "steel"}
    elif kind == "names":
        others |= {"K2": drawn.K, "M2": drawn.M}
        arguments = {"names": {"stiffness": k, "mass": m}}
    compressed, form = drawn.draw(True, False), "4" if kind == "4" else "5"
    scipy.io.savemat(folder / "w.mat", matrices | others, form == "5", form,
                     do_compression=compressed)  # fmt: skip
    return folder / "w.mat", arguments


def matlab_73(drawn, folder):
    """HDF5 after 512 bytes of text, with transposed arrays and structs as groups."""
    h5py = pytest.importorskip("h5py")
    k, m, others = workspace(drawn)
    path = folder / "v73.mat"
    with h5py.File(path, "w", userblock_size=drawn.draw(0, 512)) as file:
        place = file.create_group("sys") if drawn.draw(True, False) else file
        for name, matrix in ((k, drawn.K), (m, drawn.M)):
            if drawn.draw(True, False):
                stored, group = scipy.sparse.csc_array(matrix), place.create_group(name)
                group.attrs["MATLAB_sparse"] = np.uint64(drawn.size)
                group["data"] = stored.data
                group["ir"], group["jc"] = stored.indices.astype("u8"), stored.indptr.astype("u8")
            else:
                place[name] = matrix.T
        for name, value in others.items():
            file[name] = np.atleast_2d(value).T
        file["text"] = np.frombuffer(b"s\0t\0e\0", dtype="u2").reshape(-1, 1)
    if h5py.File(path).userblock_size:
        with path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
    return path, {}


def numpy_files(drawn, folder):
    k, m, others = workspace(drawn)
    kind = drawn.draw("npz", "npy", "sparse")
    if kind == "npz":
        np.savez(folder / "w.npz", **{k: drawn.K, m: drawn.M}, **others)
        return folder / "w.npz", {}
    for name, matrix in (("k", drawn.K), ("m", drawn.M)):
        if kind == "npy":
            np.save(folder / f"{name}.npy", matrix)
        else:
            scipy.sparse.save_npz(folder / f"{name}.npz", scipy.sparse.csr_array(matrix))
    ending = "npy" if kind == "npy" else "npz"
    return folder / f"k.{ending}", {"mass": folder / f"m.{ending}"}


def abaqus_generated(drawn, folder):
    """*MATRIX OUTPUT, FORMAT=MATRIX INPUT or COORDINATE, with a comment in some encoding."""
    labelled, between = drawn.draw(True, False), drawn.draw(", ", ",  ", " ")
    for name, matrix in (("STIF2", drawn.K), ("MASS2", drawn.M)):
        lines = ["** Laufradschaufel, gro\xdf", "*MATRIX INPUT, NAME=A"]
        entries = drawn.triangle(matrix, upper=drawn.draw(True, False))
        if not labelled and not matrix[-1, -1]:
            entries.append((drawn.size - 1, drawn.size - 1, 0.0))
        for r, c, v in entries:
            places = [*drawn.labels[r], *drawn.labels[c]] if labelled else [r + 1, c + 1]
            word = f"{v:.15e}".replace("e", drawn.draw("e", "D"))
            lines.append(between.join([*map(str, places), word]))
        encoding = drawn.draw("latin-1", "utf-8", "utf-8-sig")
        (folder / f"job_{name}.mtx").write_bytes("\n".join(lines).encode(encoding))
    return folder / "job_STIF2.mtx", {}


def abaqus_substructure(drawn, folder):
    """*SUBSTRUCTURE MATRIX OUTPUT, OUTPUT FILE=USER DEFINED."""
    nodes = sorted({node for node, _ in drawn.labels})
    directions = [k for node, k in drawn.labels if node == nodes[0]]
    lines = ["** GENERATION OF SUBSTRUCTURE Z1", f"*USER ELEMENT, NODES={len(nodes):8}, LINEAR"]
    lines.append("** ELEMENT NODES")
    lines += ["**  " + ",".join(map(str, nodes[k : k + 4])) for k in range(0, len(nodes), 4)]
    lines.append(", ".join(map(str, directions)))
    for kind, matrix in (("STIFFNESS", drawn.K), ("MASS", drawn.M)):
        lines.append(drawn.draw("*MATRIX,TYPE=", "*MATRIX, TYPE=") + kind)
        for row in range(drawn.size):
            words = [f"{v:.14e}" for v in matrix[row, : row + 1]]
            parts = [", ".join(words[k : k + 4]) for k in range(0, len(words), 4)]
            lines += [f"{part}," for part in parts[:-1]] + parts[-1:]
    (folder / "z1.mtx").write_text("\n".join(lines) + "\n")
    return folder / "z1.mtx", {}


def calculix(drawn, folder):
    for ending, matrix in (("sti", drawn.K), ("mas", drawn.M)):
        places = np.tril_indices(drawn.size)  # the diagonal is written whole
        rows = (
            f"{r + 1} {c + 1} {matrix[r, c]:.16e}\n"
            for r, c in zip(*places, strict=True)
            if r == c or matrix[r, c]
        )
        (folder / f"job.{ending}").write_text("".join(rows))
    (folder / "job.dof").write_text("".join(f"{n}.{k}\n" for n, k in drawn.labels))
    return folder / "job.sti", {}


WRITERS = (
    pyyeti_op4, op4_of_64_bits, dmig, matrix_market, harwell_boeing, matlab, matlab_73,
    numpy_files, abaqus_generated, abaqus_substructure, calculix,
)  # fmt: skip
