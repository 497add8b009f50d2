"""Lists of numbers from files: columns with units, grids, and matrices as SciPy writes them; and what is refused."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from proofmass import read_graph, simulate, write_graph
from proofmass.blocks.declaration.problem import ModelError

HEAD = 'name = "t"\nrate = "1 kHz"\nsamples = 30\nprobes = ["table.output"]\nwires = ["ramp.output -> table.{}"]\n'
RAMP = '[blocks.ramp]\nkind = "Sine"\namplitude = 3.0\nfrequency = "40 Hz"\n'
CURVE = '[blocks.table]\nkind = "LookUpTable"\noutput_unit = "N"\n'


def written(folder: Path, text: str, **files: str) -> Path:
    for name, content in files.items():
        (folder / name.replace("_csv", ".csv").replace("_mtx", ".mtx")).write_text(content, encoding="utf-8")
    path = folder / "graph.toml"
    path.write_text(text, encoding="utf-8")
    return path


def curve(values: str, breakpoints: str = "[-1.0, 1.0]") -> str:
    keys = f"breakpoints = {breakpoints}\n"
    return HEAD.format("input") + RAMP + CURVE + keys + f"values = {values}\n"


def test_columns_with_units_against_interp(tmp_path: Path) -> None:
    rows = "x, force [mN]\n-2, 500\n0, -100\n1.5, 2500\n"
    force, x = ('{ file = "curve.csv", column = "' + head + '" }' for head in ("force", "x"))
    path = written(tmp_path, curve(force, x), curve_csv=rows)
    graph = read_graph(path)
    assert graph.blocks["table"].values == (0.5, -0.1, 2.5)
    inputs = 3.0 * np.sin(2.0 * np.pi * 40.0 * np.arange(30) * 1e-3)
    expected = np.interp(inputs, [-2.0, 0.0, 1.5], [0.5, -0.1, 2.5])
    assert simulate(graph)["table.output"].values == pytest.approx(expected, abs=1e-12)
    (tmp_path / "curve.csv").unlink()
    copy = tmp_path / "copy.toml"
    copy.write_text(write_graph(graph), encoding="utf-8")
    assert read_graph(copy).blocks["table"] == graph.blocks["table"]


def test_a_grid(tmp_path: Path) -> None:
    keys = "".join(
        f'{key} = {{ file = "grid.csv", part = "{part}" }}\n'
        for key, part in (
            ("first_breakpoints", "first column"),
            ("second_breakpoints", "first row"),
            ("values", "rest"),
        )
    )
    text = HEAD.format("first").replace('table.first"]', 'table.first", "ramp.output -> table.second"]')
    path = written(
        tmp_path, text + RAMP + '[blocks.table]\nkind = "SurfaceTable"\n' + keys,
        grid_csv=",10,20,30\n-1,1,2,3\n1,4,5,6\n",
    )  # fmt: skip
    table = read_graph(path).blocks["table"]
    assert table.first_breakpoints == (-1.0, 1.0)
    assert table.second_breakpoints == (10.0, 20.0, 30.0)
    assert table.values == (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)


@pytest.mark.parametrize("layout", ["full", "sparse"])
def test_matrices_as_scipy_writes_them(tmp_path: Path, layout: str) -> None:
    stiffness = np.array([[5.0, -1.5, 0.0], [-1.5, 4.0, -1.0], [0.0, -1.0, 3.0]])
    entry = np.array([[1.0, 0.0], [0.0, 2.0], [0.5, -0.25]])
    names = {"mass": 1e-8 * np.eye(3), "damping": 1e-7 * stiffness, "stiffness": stiffness, "entry": entry}
    for name, matrix in names.items():
        held = matrix if layout == "full" else scipy.sparse.coo_array(matrix)
        scipy.io.mmwrite(tmp_path / f"{name}.mtx", held, precision=17)
    (tmp_path / "readout.csv").write_text("1,0,0\n0,0,1\n")
    keys = "".join(f'{name} = {{ file = "{name}.mtx" }}\n' for name in names) + 'readout = { file = "readout.csv" }\n'
    sizes = "input_size = 2\noutput_size = 2\nmodes = 3\n"
    text = 'name = "m"\nrate = "100 kHz"\n[blocks.model]\nkind = "ModalReducedOrderModel"\n' + sizes + keys
    model = read_graph(written(tmp_path, text)).blocks["model"]
    for name, matrix in {**names, "readout": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])}.items():
        assert getattr(model, name) == tuple(matrix.ravel()), name


@pytest.mark.parametrize(
    ("values", "rows", "words"),
    [
        ('{ file = "none.csv", column = "y" }', "x,y\n1,2\n", "there is no file none.csv"),
        ('{ file = "../curve.csv" }', "x,y\n1,2\n", "outside the folder"),
        ('{ file = "curve.csv", column = "yy" }', "x,y\n1,2\n", "no such column"),
        ('{ file = "curve.csv", colum = "y" }', "x,y\n1,2\n", "did you mean column?"),
        ('{ file = "curve.csv", part = "middle" }', "x,y\n1,2\n", "there is no part"),
        ('{ file = "curve.csv", column = "y", part = "rest" }', "x,y\n1,2\n", "do not go together"),
        ('{ file = "curve.csv", column = "y" }', "x,y\n1\n", "in row 2 curve.csv has 1 cells where the first has 2"),
        ('{ file = "curve.csv", column = "y" }', "x,y\n1,two\n", "in row 2 of curve.csv"),
        ('{ file = "curve.csv", column = "y" }', "x,y [V]\n1,2\n", "in row 2 of curve.csv"),
        ('{ file = "curve.csv", column = "y" }', "x,y\n", "holds 0 numbers"),
        ('{ file = "curve.csv" }', "", "holds no values"),
        ('{ file = "curve.csv" }', "%%MatrixMarket matrix array complex general\n1 1\n1 2\n", "complex and general"),
        ('{ file = "curve.csv" }', "%%MatrixMarket matrix array real general\n2 1\n1\n", "too few rows or too many"),
        ('{ file = "curve.csv" }', "%%MatrixMarket matrix array real general\nx\n", "whose size must lie"),
        ('{ file = "curve.csv" }', "%%MatrixMarket matrix array real general\n1 1\nx\n", "holds no values"),
        ('{ file = "curve.csv" }', "%%MatrixMarket matrix coordinate real general\n1 1 1\n2 1 5\n", "out of range"),
        ('{ file = "curve.csv" }', "%%MatrixMarket matrix array real general\n1000 1000\n", "whose size must lie"),
        (
            '{ file = "curve.csv" }',
            "%%MatrixMarket vector array real general\n1 1\n1\n",
            "not a matrix of",
        ),
        ('{ file = "curve.csv" }', "%%MatrixMarket matrix coordinate real general\n1 2 1\n1 1\n", "one entry a row"),
        (
            '{ file = "curve.csv", part = "rest" }',
            "%%MatrixMarket matrix array real general\n1 1\n1\n",
            "no column",
        ),
        ('{ file = "curve.csv" }', '"a"b,2\n', "curve.csv is not CSV"),
        ('{ file = "curve.csv" }', "1," * (1 << 19) + "1\n", "curve.csv is larger than 1 MiB"),
        ('{ file = "' + "a" * 300 + '" }', "1\n", "cannot be read: File name too long"),
    ],
)
def test_what_cannot_be_read_is_refused_at_its_line(tmp_path: Path, values: str, rows: str, words: str) -> None:
    path = written(tmp_path, curve(values), curve_csv=rows)
    with pytest.raises(ModelError) as caught:
        read_graph(path)
    assert words in str(caught.value)
    assert "graph.toml:14: blocks.table.values" in str(caught.value)
    assert len(caught.value.problems) == 1


def matrix_is_refused(folder: Path, rest: str, words: str) -> None:
    path = written(folder, curve('{ file = "curve.csv" }'), curve_csv=f"%%MatrixMarket matrix {rest}")
    with pytest.raises(ModelError, match=words):
        read_graph(path)


@pytest.mark.defect("S855", before="read as 1 by 1, whatever else the row of sizes says", after="refused")
@pytest.mark.parametrize(
    "rest",
    [
        "array real general\n1 x 1\n5\n",
        "array real general\n1 1 9\n5\n",
        "coordinate real general\n1 1\n1 1 5\n",
        "coordinate real general\n1 1 10000000001\n1 1 5\n",
    ],
)
def test_a_matrix_has_the_sizes_of_its_layout(tmp_path: Path, rest: str) -> None:
    """Matrix Market: height and width, and of one that is given by coordinates the number of entries."""
    matrix_is_refused(tmp_path, rest, "a matrix whose size")


@pytest.mark.defect("S858", before="entries beyond the square stood in places of others", after="refused")
@pytest.mark.parametrize(
    "rest", ["array real symmetric\n3 2\n1\n2\n3\n4\n5\n", "coordinate real symmetric\n2 3 1\n1 3 5\n"]
)
def test_a_symmetric_matrix_is_square(tmp_path: Path, rest: str) -> None:
    matrix_is_refused(tmp_path, rest, "is said to be symmetric")


@pytest.mark.defect("S879", before="the last of two entries at one place was taken", after="refused")
@pytest.mark.parametrize(
    "rest",
    [
        "coordinate real general\n2 2 2\n1 1 5\n1 1 0\n",
        "coordinate real symmetric\n2 2 2\n1 2 5\n2 1 7\n",
    ],
)
def test_a_matrix_has_one_entry_at_each_place(tmp_path: Path, rest: str) -> None:
    matrix_is_refused(tmp_path, rest, "has two entries at row")


def test_a_file_that_may_not_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, opened = written(tmp_path, curve('{ file = "curve.csv" }'), curve_csv="1,2\n"), Path.open

    def forbidden(file: Path, *arguments: Any) -> Any:
        if file.suffix == ".csv":
            raise PermissionError(13, "Permission denied")
        return opened(file, *arguments)

    monkeypatch.setattr(Path, "open", forbidden)  # root may read everything
    with pytest.raises(ModelError, match=r"curve\.csv cannot be read: Permission denied"):
        read_graph(path)


def test_a_file_that_is_no_text(tmp_path: Path) -> None:
    path = written(tmp_path, curve('{ file = "curve.csv" }'))
    (tmp_path / "curve.csv").write_bytes("1,2°\n".encode("latin-1"))
    with pytest.raises(ModelError, match=r"curve\.csv is not UTF-8 text"):
        read_graph(path)
