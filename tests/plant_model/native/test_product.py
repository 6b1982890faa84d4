"""A network times temperatures in C, beside the matrix; and the bound of how fast it decays."""

import ctypes

import numpy as np
import pytest

from fmu_packaging.native.compilers import STRICT, run_compiler, write_sources
from plant_model.machine_file import read_machine
from plant_model.native.generate import program
from plant_model.native.product import LANES, Place, Product
from plant_model.network import Network, effects_in_force
from plant_model.parameters import FloatArray, Values
from tests.plant_model.native.conftest import NUMBERS

SHIPPED = (
    "jig_borer_lumps",
    "lathe",
    pytest.param("jig_borer", marks=pytest.mark.long),
    pytest.param("belt_spindle", marks=pytest.mark.long),
)


def any_graph(rng: np.random.Generator) -> tuple[int, set[Place]]:
    """Return nodes and edges: chains and rings at some distance, hubs, and others at random."""
    nodes = int(rng.integers(1, 60))
    edges = set[Place]()
    for _ in range(int(rng.integers(0, 4))):
        apart, first = int(rng.integers(1, 6)), int(rng.integers(0, nodes))
        edges |= {(i, i + apart) for i in range(first, nodes - apart)}
    for hub in rng.integers(0, nodes, int(rng.integers(0, 4))).tolist():
        first, count = (int(rng.integers(0, most)) for most in (nodes, 8 * LANES))
        side = range(first, min(nodes, first + count))
        edges |= {(min(i, hub), max(i, hub)) for i in side if i != hub}
    pairs = rng.integers(0, nodes, (int(rng.integers(0, 20)), 2)).tolist()
    return nodes, edges | {(min(pair), max(pair)) for pair in pairs if pair[0] != pair[1]}


@pytest.mark.long
def test_a_product_is_that_of_the_matrix(compiler, tmp_path):
    rng = np.random.default_rng(7)
    graphs = [any_graph(rng) for _ in range(24)]
    products = [Product(nodes, sorted(edges)) for nodes, edges in graphs]
    texts = [p.text.replace("equations_product", f"p{k}") for k, p in enumerate(products)]
    declared = [text[text.index("void") : text.index("{")].strip() + ";" for text in texts]
    source = "\n".join(['#include "formulas.h"', *declared, *texts])
    write_sources(tmp_path, {"products.c": source, "formulas.h": program()["formulas.h"]})
    flags = ("-O3", "-fPIC", "-shared", "-o", "products.so", "products.c")
    run_compiler([*compiler, *STRICT, *flags], tmp_path)
    library = ctypes.CDLL(str(tmp_path / "products.so"))
    for k, ((nodes, edges), product) in enumerate(zip(graphs, products, strict=True)):
        matrix = np.diag(rng.normal(size=nodes))
        for i, j in edges:
            matrix[i, j] = matrix[j, i] = rng.normal()
        entries = np.array([matrix[place] if place else 0.0 for place in product.entries] or [0.0])
        share, values, last, before, found = rng.normal(size=(5, nodes))
        summed, weight = before.copy(), rng.normal()
        rows = (np.diag(matrix).copy(), entries, share, values, last)
        numbers = [row.ctypes.data_as(NUMBERS) for row in (*rows, found, summed)]
        getattr(library, f"p{k}")(*numbers[:5], ctypes.c_double(weight), *numbers[5:])
        assert np.allclose(found, share * (matrix @ values) - last, rtol=1e-12, atol=1e-12), k
        assert np.allclose(summed, before + weight * values, rtol=1e-12, atol=1e-12), k


@pytest.mark.parametrize("name", SHIPPED)
def test_no_mode_decays_faster_than_the_bound(name, library_of):
    """It must hold, and it is to be better than Gershgorin's."""
    machine = read_machine(name)
    values = Values(machine.parameters)
    network = Network(machine, values, effects_in_force(machine, values))
    library = library_of(machine)
    library.core_fastest.restype = ctypes.c_double
    library.core_fastest.argtypes = [ctypes.c_void_p, NUMBERS]
    nominal = [entry.value for entry in machine.parameters.values() if entry.calibrate]
    core = library.core_new((ctypes.c_double * max(1, len(nominal)))(*nominal), 0)
    for share in (0.0, 0.2, 1.0):
        inputs = [entry.low + share * (entry.high - entry.low) for entry in machine.inputs]
        given = {e.name: np.array([x]) for e, x in zip(machine.inputs, inputs, strict=True)}
        matrix = network.conductances(given)[0][0]
        bound = library.core_fastest(core, (ctypes.c_double * len(inputs))(*inputs))
        assert fastest(matrix, network.capacity[0]) <= bound * (1.0 + 1e-12)
        assert bound < 2.0 * np.max(np.diag(matrix) / network.capacity[0])
    library.core_free(core)


def fastest(matrix: FloatArray, capacity: FloatArray) -> float:
    """Return the largest eigenvalue of a network [1/s]."""
    root = np.sqrt(capacity)
    return float(np.linalg.eigvalsh(matrix / np.outer(root, root))[-1])
