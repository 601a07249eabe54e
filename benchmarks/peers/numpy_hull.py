"""NumPy on the visual hull of a lattice: planes ANDed along its axes, or every voxel projected, survivors only."""

import base64

import numpy as np
import stopwatch


def bits(text, shape):
    count = int(np.prod(shape))
    return np.unpackbits(np.frombuffer(base64.b64decode(text), np.uint8), count=count).reshape(shape).astype(bool)


def wrong_voxels(problem, found):
    """How many voxels differ from the reference, for indices (N, 3) or a dense volume."""
    n = problem["edge"]
    dense = found
    if found.dtype != bool:
        dense = np.zeros((n, n, n), bool)
        dense[tuple(found.T)] = True
    return int(np.count_nonzero(dense != bits(problem["reference"], (n, n, n))))


def projected(problem, masks):
    """Slab by slab; a voxel that one view rejects is not projected into the next one."""
    n, P = problem["edge"], np.array(problem["matrices"])
    y, z = (axis.ravel() for axis in np.indices((n, n)))
    kept = []
    for x in range(n):
        left = np.stack([np.full(n * n, x), y, z, np.ones(n * n, int)])
        for matrix, mask in zip(P, masks, strict=True):
            u, v, w = matrix @ left
            u, v = np.floor(u / w + 0.5).astype(int), np.floor(v / w + 0.5).astype(int)
            inside = (u >= 0) & (v >= 0) & (u < mask.shape[1]) & (v < mask.shape[0])
            left = left[:, inside][:, mask[v[inside], u[inside]]]
        kept.append(left[:3].T)
    return np.concatenate(kept)


def measure(problem):
    n = problem["edge"]
    if "planes" in problem:
        xy, xz, yz = (bits(text, (n, n)) for text in problem["planes"])

        def dense():
            return xy[:, :, None] & xz[:, None, :] & yz[None, :, :]

        ways = {"list of voxels": lambda: np.argwhere(dense()), "dense volume, not listed": dense}
    else:
        masks = [bits(text, shape) for text, shape in zip(problem["masks"], problem["shapes"], strict=True)]
        ways = {"list of voxels": lambda: projected(problem, masks)}
    for use, way in ways.items():
        error = wrong_voxels(problem, way())
        yield {"use": use, "setting": "", "setup_s": 0.0, "error": error, **stopwatch.timed(way, fewest=3)}


if __name__ == "__main__":
    stopwatch.main("numpy", measure)
