"""Temperatures that are found from modes when an effect reads them."""

import numpy as np
import pytest

from plant_model.side_by_side import _in_modes, _Temperatures

GENERATOR = np.random.default_rng(1)
TO_NODES, MODES = GENERATOR.normal(size=(3, 2, 5, 5)), GENERATOR.normal(size=(3, 2, 5))


@pytest.mark.parametrize(
    "read",
    [
        lambda t: t[..., 2],
        lambda t: t[..., [0, 3, 3]],
        lambda t: t[..., 1:4],
        lambda t: t[:, 0, None],
        lambda t: 2.0 * t - t**2,
        lambda t: t @ np.arange(10.0).reshape(5, 2),
        lambda t: np.mean(t, axis=-1),
        lambda t: np.zeros((len(t), *t.shape)),
    ],
)
def test_whatever_reads_them_gets_what_an_array_of_all_gives(read):
    whole = np.einsum("srnm,srm->srn", TO_NODES, MODES)
    np.testing.assert_allclose(read(_Temperatures(TO_NODES, MODES)), read(whole), atol=1e-12)


@pytest.mark.parametrize("heated", [[], [3], [0, 1, 4], [0, 1, 2, 3, 4]])
def test_heat_of_few_nodes_moves_modes_as_that_of_all(heated):
    heat = np.zeros((3, 2, 5))
    heat[..., heated] = GENERATOR.normal(size=(3, 2, len(heated)))
    expected = np.einsum("srn,srnm->srm", heat, TO_NODES)
    np.testing.assert_allclose(_in_modes(heat, TO_NODES), expected, atol=1e-12)
