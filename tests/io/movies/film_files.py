"""Writes one film of C cameras, (N, C, rows, columns), in every format that is read back."""

from pathlib import Path

import numpy as np
from binary_files import write_matlab5, write_matlab73
from PIL import Image


def write_stills(folder, film, ending, *, first=0, name="frame{}"):
    """A folder for each camera; numbers without leading zeros, so that their order is that of their values."""
    for c in range(film.shape[1]):
        camera = folder / f"cam{c + 1}"
        camera.mkdir(parents=True)
        for k, image in enumerate(film[:, c]):
            Image.fromarray(image).save(camera / f"{name.format(first + k)}{ending}")
    return [folder]


def write_flat(folder, film, name="cam{c}_{k}.png"):
    folder.mkdir()
    for c in range(film.shape[1]):
        for k, image in enumerate(film[:, c]):
            Image.fromarray(image).save(folder / name.format(c=c + 1, k=k))
    return [folder]


def write_pages(folder, film, **options):
    folder.mkdir()
    for c in range(film.shape[1]):
        first, *rest = [Image.fromarray(image) for image in film[:, c]]
        first.save(folder / f"cam{c + 1}.tif", save_all=True, append_images=rest, **options)
    return [folder]


def write_npy(folder, film):
    folder.mkdir()
    np.save(folder / "film.npy", film)
    return [folder / "film.npy"]


def write_npy_cameras(folder, film):
    folder.mkdir()
    for c in range(film.shape[1]):
        np.save(folder / f"cam{c + 1}.npy", film[:, c])
    return [folder]


def write_npz(folder, film, **others):
    folder.mkdir()
    np.savez_compressed(folder / "film.npz", film=film, calibration=np.zeros((11, 3)), **others)
    return [folder / "film.npz"]


def write_npz_cameras(folder, film):
    folder.mkdir()
    np.savez(folder / "film.npz", **{f"cam{c + 1}": film[:, c] for c in range(film.shape[1])})
    return [folder / "film.npz"]


def write_packed(folder, masks):
    folder.mkdir()
    np.savez_compressed(folder / "masks.npz", masks_packed=np.packbits(masks, axis=-1), fps=8000.0)
    return [folder / "masks.npz"]


def write_packed_whole(folder, masks):
    folder.mkdir()
    flat = masks.reshape(*masks.shape[:2], -1)
    np.savez(folder / "masks.npz", masks_packed=np.packbits(flat, axis=-1), mask_shape=np.array(masks.shape[2:]))
    return [folder / "masks.npz"]


def write_packed_npy(folder, masks):
    folder.mkdir()
    np.save(folder / "masks_packed.npy", np.packbits(masks, axis=-1))
    return [folder / "masks_packed.npy"]


def sparse_frames(film, background, mask):
    """Rows, columns and values of the pixels of each frame (K, 3), as `find` lists them in MATLAB, from 1."""
    tables = []
    for image, there in zip(film, mask, strict=True):
        columns, rows = np.nonzero(there.T)
        tables.append(np.stack([rows + 1, columns + 1, image[rows, columns]], axis=1).astype(np.uint16))
    return tables


def write_sparse(path, tables, meta, version):
    if version == "7.3":
        frames = [{"indIm": table} for table in tables]
        return write_matlab73(path, {"frames": frames if len(frames) > 1 else frames[0], "metaData": meta})
    frames = np.empty((len(tables), 1), dtype=[("indIm", object)])
    for k, table in enumerate(tables):
        frames[k, 0]["indIm"] = table
    return write_matlab5(path, {"frames": frames, "metaData": meta}, compressed=True)


def write_sparse_film(folder, film, background, version):
    """What differs from the background (rows, columns), a file for each camera, beside a calibration."""
    folder.mkdir()
    for c in range(film.shape[1]):
        tables = sparse_frames(film[:, c], background, film[:, c] != background)
        meta = {"bg": background, "frameSize": np.array([background.shape]), "startFrame": -40, "frameRate": 20000.0}
        write_sparse(folder / f"mov1_cam{c + 1}_sparse.mat", tables, meta, version)
    write_matlab5(folder / "wand_easyWandData.mat", {"easyWandData": {"coefs": np.zeros((11, 3))}})
    return [folder]


def files_of(inputs):
    """All files under what was written, in order."""
    paths = [Path(path) for path in inputs]
    return [
        file for path in paths for file in ([path] if path.is_file() else sorted(path.rglob("*"))) if file.is_file()
    ]
