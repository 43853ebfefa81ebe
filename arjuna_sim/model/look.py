"""The look of a world to cameras: its lights, its sky and its fog."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

Rgb = tuple[float, float, float]
AMBIENT: Rgb = (0.4, 0.4, 0.4)
"""SDF's default of a scene's ambient light."""
PIXELS_MAX = 4096
"""Along a side of a picture: as far as OpenGL goes everywhere."""


class LightKind(Enum):
    """The kind of a light, as SDF writes it."""

    DIRECTIONAL = "directional"
    POINT = "point"
    SPOT = "spot"


@dataclass(frozen=True)
class Light:
    """A light of a world.

    Attributes:
        position: In the world [m].
        direction: In which it shines, a unit vector of the world.
        attenuation: Brightness is divided by a + b d + c d^2 at a distance d [m].
        cutoff: Angle from the axis of a spot light's cone to its edge [rad].
        falloff: Exponent by which a spot light grows darker towards its edge.
    """

    kind: LightKind
    position: tuple[float, float, float] = (0.0, 0.0, 10.0)
    direction: tuple[float, float, float] = (0.0, 0.0, -1.0)
    diffuse: Rgb = (1.0, 1.0, 1.0)
    specular: Rgb = (0.1, 0.1, 0.1)
    attenuation: tuple[float, float, float] = (1.0, 0.0, 0.0)
    cutoff: float = 0.8
    falloff: float = 1.0
    casts_shadow: bool = False


SUN = Light(
    *(LightKind.DIRECTIONAL, (0.0, 0.0, 10.0), (-0.5, 0.1, -0.9)),
    *((0.7, 0.7, 0.7), (0.3, 0.3, 0.3)),
)
"""`model://sun`; it casts no shadows, which take three times as long to draw."""


@dataclass(frozen=True)
class Fog:
    """Fog: none up to `start`, all from `end` on [m]."""

    colour: Rgb
    start: float
    end: float


@dataclass(frozen=True)
class Look:
    """The lights, sky and fog of a world.

    Attributes:
        ambient: Light from everywhere; None for a lamp on each camera, as files without lights of
            their own are seen.
        background: Colour of the sky; None for a blue sky.
    """

    lights: tuple[Light, ...] = (SUN,)
    ambient: Rgb | None = None
    background: Rgb | None = None
    fog: Fog | None = None
