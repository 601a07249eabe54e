"""Bodies, cameras and their silhouettes for tests of the hull: drawn by points, without the package's own renderer."""

import numpy as np

from flycontrol.model.camera_forms import looking_at
from flycontrol.units import mm

SHAPE = (200, 240)
SCALE = 35 / mm
SIZE = 1 / SCALE


def cameras_around(seed, count=3, distance=100 * mm):
    """Projective cameras, no two from nearly the same or opposite sides."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    extra = rng.normal(size=(max(count - 3, 0), 3))
    directions = np.vstack([turn, extra / np.linalg.norm(extra, axis=1, keepdims=True)])[:count]
    target = rng.uniform(-1, 1, 3) * mm
    return [
        looking_at(target, target + distance * way, focal=SCALE * distance, shape=SHAPE, name=f"camera {k + 1}")
        for k, way in enumerate(directions)
    ]


def ellipsoid(seed):
    """A = (3, 3): x^T A x <= 1 about a centre (3,)."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    axes = rng.uniform(0.3, 1.2, 3) * mm
    return turn @ np.diag(axes**-2) @ turn.T, rng.uniform(-0.2, 0.2, 3) * mm


def silhouette_of_ellipsoid(camera, A, centre):
    """Pixels whose lines of sight meet it: |b|^2 - a c >= 0 of a t^2 + 2 b t + c <= 0."""
    rows, columns = camera.shape
    v, u = np.mgrid[:rows, :columns].reshape(2, -1)
    rays = camera.rays(np.stack([u, v], axis=1).astype(float))
    away = rays.origin - centre
    a = np.einsum("ni,ij,nj->n", rays.direction, A, rays.direction)
    b = np.einsum("ni,ij,nj->n", rays.direction, A, away)
    c = np.einsum("ni,ij,nj->n", away, A, away) - 1
    return (b * b - a * c >= 0).reshape(rows, columns)


def blobs(seed, shape=SHAPE):
    """A ragged mask: thresholded smooth noise near the middle, specks and holes included."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=shape)
    spectrum = np.fft.rfft2(noise)
    f = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1])[None])
    smooth = np.fft.irfft2(spectrum * np.exp(-((f * 12) ** 2)), shape)
    v, u = np.mgrid[: shape[0], : shape[1]]
    hill = np.hypot(v - shape[0] / 2, u - shape[1] / 2) / 55
    return smooth / smooth.std() > hill**2 - 0.5


def codes(indices):
    """One whole number a voxel, sorted, for comparing sets of voxels."""
    x, y, z = np.asarray(indices, dtype=np.int64).T
    return np.sort(((x + 2**15 << 16) + y + 2**15 << 16) + z + 2**15)


def same(one, other):
    return np.array_equal(codes(one), codes(other))


def within(part, whole):
    return bool(np.isin(codes(part), codes(whole)).all())


def brute_force(masks, cameras, size, box, slack=0.0, views=0):
    """Indices of all voxels of a box that stay, by looking at every one and at every distance."""
    from scipy.ndimage import distance_transform_edt

    grid = np.stack(np.meshgrid(*[np.arange(a, b) for a, b in zip(box.low, box.high, strict=True)], indexing="ij"), -1)
    grid = grid.reshape(-1, 3)
    off, far = np.zeros(len(grid), int), np.zeros(len(grid), bool)
    for mask, camera in zip(masks, cameras, strict=True):
        distance = distance_transform_edt(~mask)
        pixels = camera.project((grid + 0.5) * size)
        seen = camera.sees(pixels)
        u, v = np.floor(np.where(seen[:, None], pixels, 0) + 0.5).astype(int).T
        away = np.where(seen, distance[v, u], np.inf)
        off += away > 0
        far |= away > slack
    return grid[~far & (off <= views)] if views else grid[off == 0]
