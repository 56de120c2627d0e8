"""What rays through a volume show, by the books and by nobody's program: in float64, with numpy.

The emission and absorption of Drebin, Carpenter & Hanrahan 1988, front to back; trilinear values,
trilinear gradients of central differences, a light at the eye as Blinn 1977 has it. Of a picture
only every `EVERY`th pixel of every `EVERY`th row.
"""

import numpy as np

from .bench_volumes import Volume

TYPES = {"u8": np.uint8, "i16": np.int16, "u16": np.uint16, "f32": np.float32}
EVERY = 8
STEP = 1 / 16
"""The length of a step, in spacings."""
AMBIENT, DIFFUSE, SPECULAR, SHININESS = 0.25, 0.75, 0.15, 32


class Field:
    """A volume between its samples, which are 1 apart."""

    def __init__(self, volume: Volume) -> None:
        """In memory, with the gradients at all samples."""
        samples = np.fromfile(volume.path, TYPES[volume.dtype]).astype(np.float32)
        self.dims = np.array(volume.dims)
        grid = samples.reshape(self.dims[::-1])
        along_z, along_y, along_x = np.gradient(grid)
        parts = (grid, along_x, along_y, along_z)
        self.parts = [np.ascontiguousarray(part).reshape(-1) for part in parts]

    def at(self, places: np.ndarray, wanted: range) -> list[np.ndarray]:
        """Values (part 0) or parts of gradients (1 to 3) at places, a row each."""
        nx, ny, _ = self.dims
        low = np.clip(places.astype(np.int64), 0, self.dims - 2)
        part = places - low
        first = low[:, 0] + nx * (low[:, 1] + ny * low[:, 2])
        sums = [np.zeros(len(places)) for _ in wanted]
        for corner in range(8):
            bits = [corner >> axis & 1 for axis in range(3)]
            weights = [part[:, k] if bit else 1 - part[:, k] for k, bit in enumerate(bits)]
            weight = weights[0] * weights[1] * weights[2]
            number = first + bits[0] + nx * (bits[1] + ny * bits[2])
            for total, which in zip(sums, wanted, strict=True):
                total += weight * self.parts[which][number]
        return sums


def rays(view: dict) -> tuple[np.ndarray, np.ndarray]:
    """Where the eye is, and the direction of each pixel that is looked at."""
    eye, at, up = (np.array(view[name], float) for name in ("from", "at", "up"))
    forward = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    width, height = view["size"]
    tangent = np.tan(np.radians(view["fov"]) / 2)
    x = (2 * (np.arange(0, width, EVERY) + 0.5) - width) / height * tangent
    y = (1 - 2 * (np.arange(0, height, EVERY) + 0.5) / height) * tangent
    directions = forward + x[None, :, None] * right + y[:, None, None] * up
    directions = directions.reshape(-1, 3)
    return eye, directions / np.linalg.norm(directions, axis=1)[:, None]


def picture(field: Field, view: dict, transfer: list) -> np.ndarray:
    """The colours before black; opacities of the transfer function are over one spacing."""
    eye, towards = rays(view)
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([(0 - eye) / towards, (field.dims - 1 - eye) / towards])
    near = np.maximum(ends.min(axis=0).max(axis=1), 0)
    far = ends.max(axis=0).min(axis=1)
    values, *columns = np.array(transfer, float).T
    color, light = np.zeros((len(towards), 3)), np.ones(len(towards))
    going = np.flatnonzero(far > near)
    step = 0
    while len(going):
        begin = near[going] + step * STEP
        long = np.minimum(STEP, far[going] - begin)
        places = eye + (begin + long / 2)[:, None] * towards[going]
        (value,) = field.at(places, range(1))
        red, green, blue, opacity = (np.interp(value, values, column) for column in columns)
        seen = opacity > 0
        own = np.stack([red, green, blue], axis=1)[seen]
        if view["lit"]:
            gradient = np.stack(field.at(places[seen], range(1, 4)), axis=1)
            own = lit(own, gradient, towards[going][seen])
        share = 1 - (1 - opacity[seen]) ** long[seen]
        rows = going[seen]
        color[rows] += (light[rows] * share)[:, None] * own
        light[rows] *= 1 - share
        step += 1
        going = going[(light[going] > 1e-5) & (near[going] + step * STEP < far[going])]
    height = len(range(0, view["size"][1], EVERY))
    return color.reshape(height, -1, 3)


def lit(color: np.ndarray, gradient: np.ndarray, towards: np.ndarray) -> np.ndarray:
    """Colours under the light; without a gradient there is the colour alone."""
    long = np.linalg.norm(gradient, axis=1)
    cosine = np.abs((gradient * towards).sum(axis=1)) / np.where(long > 0, long, 1)
    matt = np.where(long > 0, AMBIENT + DIFFUSE * cosine, 1)
    gloss = np.where(long > 0, SPECULAR * cosine**SHININESS, 0)
    return np.minimum(color * matt[:, None] + gloss[:, None], 1)
