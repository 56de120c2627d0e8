"""Analytic fields whose surface is known: value, gradient, and the nearest point of the surface.

All live in the cube from -1 to 1 and are positive inside; the surface is where they are 0. None is
centred or turned like the lattice, so that no symmetry hides an error. Where the nearest point has
no closed form it is found by Newton's method along the gradient, then moved along the surface to
the foot of the perpendicular, in f64. Needs numpy.
"""

from abc import ABC, abstractmethod

import numpy as np

CENTRE = np.array([0.0123, -0.0217, 0.0319])

SLID = 1e-3
"""Distance from which on the nearest point is sought along the surface too."""

POSITIONS = ((0, 0, 0), (1 / 2, 3 / 4, 1 / 4), (1 / 4, 1 / 4, 1 / 2), (3 / 4, 1 / 2, 3 / 4))
"""Of a lattice, in steps along x, y, z: each coordinate in all quarters of a step."""

WINDOW = 0.8
"""Surfaces that leave the cube are judged where no coordinate is beyond this."""


def turned() -> np.ndarray:
    """A rotation about no axis of the lattice, by Rodrigues' formula."""
    x, y, z = axis = np.array([2.0, -1.0, 3.0]) / np.sqrt(14)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = 0.7
    return (
        np.cos(angle) * np.eye(3)
        + np.sin(angle) * cross
        + (1 - np.cos(angle)) * np.outer(axis, axis)
    )


class Field(ABC):
    """A function with a surface."""

    euler: int | None = None
    """The surface's V - E + F within the cube, where it is known."""
    components: int | None = None
    area: float | None = None
    volume: float | None = None
    thickness = np.inf
    """With samples further apart than this a lattice cannot see the surface."""
    closed = True
    """Whether it stays within the cube; if not, it is judged within `WINDOW`."""
    smooth = True
    """Whether value and surface are smooth. Creases, or walls as thin as cells, have no order."""
    surface_rms = 1e-5
    """Of the diameter: the RMS distance of whole surfaces to which tools are timed."""
    order_sizes: tuple[int, ...] = ()
    """Lattices that its orders are seen on beside those that tools are timed on.

    On each the errors are those of all `POSITIONS` of the lattice together.
    """

    @abstractmethod
    def value(self, points: np.ndarray) -> np.ndarray:
        """The field at points of shape (m, 3)."""

    @abstractmethod
    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The nearest points of the surface, NaN if none was found, and the unit normals there."""

    def judged(self, points: np.ndarray) -> np.ndarray:
        """Which points count."""
        if self.closed:
            return np.ones(len(points), bool)
        return (np.abs(points) <= WINDOW).all(axis=1)

    def sample(self, n: int, dtype: type, moved: tuple[float, ...] = (0, 0, 0)) -> np.ndarray:
        """n³ samples, indexed z, y, x, slice by slice, of a lattice moved by so much along x, y, z."""
        axis = np.linspace(-1, 1, n)
        plane = np.empty((n * n, 3))
        plane[:, 0], plane[:, 1] = np.tile(axis + moved[0], n), np.repeat(axis + moved[1], n)
        samples = np.empty((n, n, n), dtype)
        for k, z in enumerate(axis + moved[2]):
            plane[:, 2] = z
            samples[k] = self.value(plane).reshape(n, n)
        return samples

    def cloud(self, count: int) -> np.ndarray:
        """Points spread evenly over the surface: chance ones near it, each moved to it.

        Even as far as the band they come from is everywhere as wide: to its width by the radius of
        curvature, 1 %, and not along creases.
        """
        random = np.random.default_rng(1)
        found, width = [], 0.01
        while sum(map(len, found)) < count:
            points = random.uniform(-1, 1, (1 << 18, 3))
            points = points[np.abs(self.distance_estimate(points)) < width]
            foot, _ = self.nearest(points)
            found.append(foot[np.isfinite(foot).all(axis=1) & self.judged(foot)])
        return np.concatenate(found)[:count]

    def distance_estimate(self, points: np.ndarray) -> np.ndarray:
        """The signed distance to the first order; here the value is one."""
        return self.value(points)


class Smooth(Field):
    """A field with a gradient, whose nearest points are found by steps."""

    @abstractmethod
    def slopes(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Value and gradient."""

    def value(self, points: np.ndarray) -> np.ndarray:
        """The first of `slopes`."""
        return self.slopes(points)[0]

    def distance_estimate(self, points: np.ndarray) -> np.ndarray:
        """Value by slope."""
        value, gradient = self.slopes(points)
        return value / np.maximum(np.linalg.norm(gradient, axis=1), 1e-12)

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """From the points themselves."""
        return self.nearest_from(points, points)

    def nearest_from(self, points: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Newton, then twice: along the tangent plane towards the point, and Newton again.

        Points nearer than `SLID` are not moved along: there Newton's foot is the nearest point to
        a millionth of the distance.
        """
        foot, normal, lost = self._newton(start)
        for _ in range(2):
            away = points - foot
            far = np.flatnonzero(lost | (length(away) > SLID))
            if len(far) == 0:
                break
            along = away[far] - normal[far] * dot(away[far], normal[far])[:, None]
            tried, tried_normal, failed = self._newton(foot[far] + along)
            shorter = length(points[far] - tried) < length(away[far])
            better = ~failed & (lost[far] | shorter)
            foot[far[better]], normal[far[better]] = tried[better], tried_normal[better]
            lost[far[better]] = False
        foot[lost] = np.nan
        return foot, normal

    def _newton(self, start: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where it ends, the normal there, and whether that is not on the surface."""
        foot, normal = start.copy(), np.zeros_like(start)
        active = np.arange(len(start))
        for _ in range(8):
            value, gradient = self.slopes(foot[active])
            slope = np.maximum(length(gradient), 1e-12)
            normal[active] = -gradient / slope[:, None]
            step = np.clip(value / slope, -0.1, 0.1)
            moving = np.abs(step) > 1e-11
            active = active[moving]
            if len(active) == 0:
                break
            foot[active] += step[moving, None] * normal[active]
        lost = np.zeros(len(start), bool)
        lost[active] = True
        return foot, normal, lost


class Sphere(Field):
    """The signed distance of a sphere."""

    euler, components = 2, 1
    radius = 0.7
    area, volume = 4 * np.pi * radius**2, 4 / 3 * np.pi * radius**3
    order_sizes = (48, 96)  # the normals of finer ones are off by rounding alone

    def value(self, points: np.ndarray) -> np.ndarray:
        """Radius less distance."""
        return self.radius - length(points - CENTRE)

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Along the ray from the centre."""
        normal = unit(points - CENTRE)
        return CENTRE + self.radius * normal, normal


class Torus(Field):
    """The signed distance of a torus."""

    euler, components = 0, 1
    radius, tube = 0.55, 0.22
    area, volume = 4 * np.pi**2 * radius * tube, 2 * np.pi**2 * radius * tube**2

    def value(self, points: np.ndarray) -> np.ndarray:
        """Radius of the tube less distance to its middle."""
        return self.tube - length(points - self._middle(points))

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Along the ray from the middle of the tube."""
        middle = self._middle(points)
        normal = unit(points - middle)
        return middle + self.tube * normal, normal

    def _middle(self, points: np.ndarray) -> np.ndarray:
        own = (points - CENTRE) @ turned()
        own[:, 2] = 0
        return CENTRE + self.radius * unit(own) @ turned().T


class Shell(Field):
    """A hollow sphere with a thin wall: the distance to its middle is what makes the field."""

    euler, components = 4, 2
    smooth = False
    radius, thickness = 0.65, 0.05
    _radii = np.array([radius - thickness / 2, radius + thickness / 2])
    area, volume = 4 * np.pi * (_radii**2).sum(), 4 / 3 * np.pi * (_radii[1] ** 3 - _radii[0] ** 3)

    def value(self, points: np.ndarray) -> np.ndarray:
        """Half the wall less distance to its middle."""
        return self.thickness / 2 - np.abs(length(points - CENTRE) - self.radius)

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """On the nearer of the two spheres."""
        ray, outside = unit(points - CENTRE), length(points - CENTRE) >= self.radius
        return CENTRE + self._radii[outside.astype(int), None] * ray, np.where(
            outside[:, None], ray, -ray
        )


class Drilled(Field):
    """The signed distance of a box less a cylinder: flat faces, a curved one, creases."""

    euler, components = 0, 1
    smooth = False
    half, radius = np.array([0.55, 0.45, 0.4]), 0.25
    thickness = half[1] - radius
    area = 8 * (half * np.roll(half, 1)).sum() + 2 * np.pi * radius * (2 * half[2] - radius)
    volume = 8 * half.prod() - 2 * np.pi * radius**2 * half[2]

    def value(self, points: np.ndarray) -> np.ndarray:
        """The distance to the nearest of all faces, with a sign."""
        own = (points - CENTRE) @ turned()
        inside = (np.abs(own) <= self.half).all(axis=1) & (length(own[:, :2]) >= self.radius)
        distance = length(own - self._nearest(own)[0])
        return np.where(inside, distance, -distance)

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """On the nearest of all faces, with the normal of that face."""
        foot, normal = self._nearest((points - CENTRE) @ turned())
        return CENTRE + foot @ turned().T, normal @ turned().T

    def cloud(self, count: int) -> np.ndarray:
        """Chance points on each face by its area: those near a crease would move onto it."""
        random = np.random.default_rng(1)
        turn, height = 2 * np.pi * self.radius, 2 * self.half[2]
        sides = 4 * self.half.prod() / self.half
        share = np.array([turn * height, *np.repeat(sides, 2)])
        face = random.choice(7, size=2 * count, p=share / share.sum())
        own = random.uniform(-self.half, self.half, (2 * count, 3))
        angle = random.uniform(0, 2 * np.pi, 2 * count)
        ring = self.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        own[face == 0, :2] = ring[face == 0]
        for n in range(6):
            axis, side = divmod(n, 2)
            own[face == n + 1, axis] = (2 * side - 1) * self.half[axis]
        hole = (face > 4) & (length(own[:, :2]) < self.radius)
        return CENTRE + own[~hole][:count] @ turned().T

    def _nearest(self, own: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        around = unit(own * (1, 1, 0))
        wall = self.radius * around
        wall[:, 2] = np.clip(own[:, 2], -self.half[2], self.half[2])
        best, normal, least = wall, -around, length(own - wall)
        for axis in range(3):
            for side in (-1.0, 1.0):
                face = np.clip(own, -self.half, self.half)
                if axis == 2:  # these have the hole
                    hole = length(face[:, :2]) < self.radius
                    face[hole] = self.radius * around[hole]
                face[:, axis] = side * self.half[axis]
                distance = length(own - face)
                nearer = distance < least
                least = np.where(nearer, distance, least)
                best = np.where(nearer[:, None], face, best)
                normal = np.where(nearer[:, None], side * np.eye(3)[axis], normal)
        return best, normal


class Gyroid(Smooth):
    """sin x cos y + sin y cos z + sin z cos x by its typical slope, nearly a distance."""

    closed = False
    wave = 2 * np.pi
    order_sizes = (48, 96)  # as of the sphere

    def slopes(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Cyclic in x, y, z."""
        angle = self.wave * (points - CENTRE)
        sin, cos = np.sin(angle), np.cos(angle)
        after, before = [1, 2, 0], [2, 0, 1]
        scale = 1 / (1.5 * self.wave)
        value = dot(sin, cos[:, after])
        gradient = self.wave * (cos * cos[:, after] - sin * sin[:, before])
        return scale * value, scale * gradient


class MarschnerLobb(Smooth):
    """The test signal of Marschner and Lobb (1994): waves close to what 40³ samples can hold."""

    euler, components = 1, 1  # a height over the square: the value falls along z everywhere
    closed = False
    depth, frequency = 0.25, 6.0
    # The crests of its waves lie flat: errors depend on where slices cut them. Normals beside them
    # have their order late: the cubic's from 256³ to 384³ 3.4, from 512³ to 768³ 4.1.
    surface_rms, order_sizes = 1e-4, (384, 512, 640, 768)

    def slopes(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Density less its middle value."""
        x, y, z = points.T
        radius = np.hypot(x, y)
        angle = 2 * np.pi * self.frequency * np.cos(np.pi * radius / 2)
        scale = 1 / (2 * (1 + self.depth))
        value = scale * (1 - np.sin(np.pi * z / 2) + self.depth * (1 + np.cos(angle))) - 0.5
        # sin(πr/2)/r has a limit at 0, which `sinc` knows
        swing = np.pi / 2 * np.sinc(radius / 2)
        around = scale * self.depth * np.sin(angle) * np.pi**2 * self.frequency * swing
        along = -scale * np.pi / 2 * np.cos(np.pi * z / 2)
        return value, np.stack([around * x, around * y, along], axis=1)


class Metaballs(Smooth):
    """Gaussians: four that flow together and one apart."""

    euler, components = 4, 2
    middles = CENTRE + np.array(
        [
            [-0.45, -0.3, -0.2],
            [-0.1, -0.35, 0.1],
            [0.2, -0.1, -0.1],
            [0.45, 0.1, 0.2],
            [-0.35, 0.5, 0.3],
        ]
    )
    width, level = 0.25, 0.5

    def slopes(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Their sum, less the level."""
        value = np.full(len(points), -self.level)
        gradient = np.zeros_like(points)
        for middle in self.middles:
            away = points - middle
            ball = np.exp(-dot(away, away) / self.width**2)
            value += ball
            gradient -= (2 / self.width**2 * ball)[:, None] * away
        return self.width * value, self.width * gradient


FIELDS: dict[str, type[Field]] = {
    "sphere": Sphere,
    "torus": Torus,
    "gyroid": Gyroid,
    "marschner-lobb": MarschnerLobb,
    "metaballs": Metaballs,
    "shell": Shell,
    "drilled": Drilled,
}
"""All of them by the names that the table gives them."""


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Row by row."""
    return np.einsum("ij,ij->i", a, b)


def length(vectors: np.ndarray) -> np.ndarray:
    """Row by row."""
    return np.sqrt(np.einsum("ij,ij->i", vectors, vectors))


def unit(vectors: np.ndarray) -> np.ndarray:
    """Row by row; 0 stays 0."""
    return vectors / np.maximum(length(vectors), 1e-300)[:, None]
