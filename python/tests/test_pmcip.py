"""The wheel: python -m pytest python/tests."""

import numpy as np
import pmcip
import pytest


def disc(plan):
    """A noisy disc of mean radiance 1."""
    u, _ = plan.points(1)
    inside = (plan.x - 32) ** 2 + (plan.y - 24) ** 2 < 256
    return np.repeat(np.where(inside, 2 * u, 0).astype(np.float32)[:, None], 3, axis=1)


def rendered(**settings):
    film = pmcip.Film(64, 48, spp=16, seed=1, **settings)
    film.render(disc, 16)
    return film


def test_five_lines_render_a_function():
    film = rendered()
    picture = film.resolve()
    assert picture.shape == (48, 64, 3) and picture.dtype == np.float32
    assert abs(picture[..., 0].sum() / (256 * np.pi) - 1) < 0.03
    count = film.count()
    assert count.sum() == 16 * 64 * 48 and count[24, 32] > 2 * count[2, 2]
    assert abs(film.alpha().sum() - 1) < 1e-4 and (film.variance() >= 0).all()


def test_any_guide_has_the_energy_of_the_film():
    film = rendered()
    energy = film.resolve("difference").sum()
    features = np.ones((48, 64, 3), np.float32), np.zeros((48, 64, 3), np.float32), np.ones((48, 64), np.float32)
    for picture in film.guided(), film.guided(*features), film.resolve_guided(np.ones((48, 64, 3), np.float32)):
        assert abs(picture.sum() / energy - 1) < 1e-4


def test_pieces_in_any_order_have_the_same_bits():
    film = pmcip.Film(64, 48, spp=16, seed=1)
    for samples in film.schedule(film.pixels, 16, 2, 8):
        film.begin(samples)
        plans, first = [], 0
        while first < 64 * 48:
            plans.append(film.plan(first, 500))
            first = plans[-1].end
        for plan in reversed(plans):
            film.deliver(plan, disc(plan))
        film.end()
    assert (film.resolve() == rendered().resolve()).all()


def test_arrays_are_not_copied():
    film = pmcip.Film(8, 8)
    film.begin(128)
    plan = film.plan()
    assert plan.x is plan.x and plan.x.dtype == np.float32 and plan.x.flags.c_contiguous
    assert len(plan) == 128 and np.floor(plan.x).max() == 7
    with pytest.raises(ValueError, match="contiguous"):
        film.deliver(plan, np.zeros((3, 128), np.float32).T)
    with pytest.raises(ValueError, match="128 entries"):
        film.deliver(plan, np.zeros((3, 128), np.float32))


def test_labels_keep_islands_apart():
    labels = np.zeros((48, 64), np.uint16)
    labels[:, :30], labels[:, 34:] = 1, 2
    film = rendered(labels=labels)
    assert film.pixels == (labels > 0).sum() and film.count()[labels == 0].sum() == 0
    fair, picture = film.resolve("difference"), film.guided()
    for label in 1, 2:
        assert abs(picture[labels == label].sum() / fair[labels == label].sum() - 1) < 1e-4


def test_a_film_is_saved_and_loaded():
    film = rendered()
    again = pmcip.Film.load(film.save())
    assert again.shape == (48, 64) and (again.resolve() == film.resolve()).all()
    with pytest.raises(ValueError, match="saved film"):
        pmcip.Film.load(film.save()[:-1])


def test_a_kernel_of_ones_own_decides():
    film = pmcip.Film(64, 48)
    alpha = np.zeros((48, 64), np.float32)
    alpha[:, 32:] = 1
    film.begin(64 * 48, alpha)
    plan = film.plan()
    assert plan.x.min() >= 32
    film.deliver(plan, disc(plan))
    film.end()


def test_misuse_is_refused():
    film = pmcip.Film(64, 48)
    with pytest.raises(ValueError, match="begin one first"):
        film.plan()
    film.begin(100)
    plan = film.plan()
    with pytest.raises(ValueError, match="100 entries"):
        film.deliver(plan, np.zeros((99, 3), np.float32))
    film.deliver(plan, np.zeros((100, 3), np.float32))
    with pytest.raises(ValueError, match="delivered once"):
        film.deliver(plan, np.zeros((100, 3), np.float32))
    with pytest.raises(ValueError):
        pmcip.Film(0, 5)
    with pytest.raises(ValueError):
        film.resolve("best")
