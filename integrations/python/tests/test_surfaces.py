"""Unions of solids that overlap, touch or leave a gap, and open surfaces, against volumes in closed form."""

import warnings

import numpy as np
import pytest

manifold3d = pytest.importorskip("manifold3d")


def solid(mesh):
    return manifold3d.Manifold(manifold3d.Mesh64(mesh[0], mesh[1].astype(np.uint64)))


@pytest.mark.parametrize("rise, volume", [(0.008, 1.5), (0.016, 2.0), (0.01601, 2.0)])
def test_boxes_that_overlap_or_touch_are_one_solid(rise, volume):
    from clangor.surfaces import box, union

    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn[:, 0] *= np.linalg.det(turn)
    first = box(np.full(3, 0.008))
    meshes = [((first[0] + [0.0, 0.0, z]) @ turn.T, first[1]) for z in (0.0, rise)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = solid(union(meshes, "body"))
    wanted = volume * 0.016**3
    print(f"{rise} m: volume {found.volume() / wanted - 1.0:.1e} from the boxes', bar 1e-2")
    assert len(found.decompose()) == 1 and found.volume() == pytest.approx(wanted, rel=1e-2)


def test_a_gap_is_bridged_by_a_bar_with_a_warning():
    from clangor.surfaces import box, union

    first = box(np.full(3, 0.008))
    with pytest.warns(UserWarning, match="body 3: 1 of its parts do not touch"):
        found = solid(union([first, (first[0] + [0.03, 0.01, 0.0], first[1])], "body 3"))
    gap, radius = 0.014, 0.004
    bar = found.volume() - 2.0 * 0.016**3
    print("volume of the bar", bar, "of a cylinder", np.pi * radius**2 * gap)
    assert len(found.decompose()) == 1 and 0.5 < bar / (np.pi * radius**2 * gap) < 1.5


def test_an_open_surface_is_its_hull_and_a_flat_one_is_refused():
    from clangor.surfaces import box, closed

    points, faces = box(np.full(3, 0.5))
    assert solid(closed((points, faces[:-1]), "body")).volume() == pytest.approx(1.0)
    with pytest.raises(ValueError, match="body 3: its surface has no volume"):
        closed((points * [1.0, 1.0, 0.0], faces[:4]), "body 3")
