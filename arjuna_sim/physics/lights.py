"""Lights, sky and fog of a world as MuJoCo draws them."""

from __future__ import annotations

import math
from typing import Any

import mujoco

from arjuna_sim.model.look import LightKind, Look

_SKY, _HORIZON = (0.4, 0.6, 0.9), (0.9, 0.9, 0.9)
_ABOVE = 20.0  # how far from the origin the sun stands [m]
_SHADED = 10.0  # how far about the origin it casts shadows at least [m]: their edge is stippled


def add_look(spec: Any, look: Look) -> None:
    """Add a world's lights, sky and fog to a spec; `set_reach` completes them.

    OpenGL draws directional lights and cones: a point light is a cone all round.
    """
    visual, kinds = spec.visual, mujoco.mjtLightType
    for light in look.lights:
        is_sun, is_spot = (light.kind is each for each in (LightKind.DIRECTIONAL, LightKind.SPOT))
        high = [-_ABOVE * part for part in light.direction]
        spec.worldbody.add_light(
            type=kinds.mjLIGHT_DIRECTIONAL if is_sun else kinds.mjLIGHT_SPOT,
            pos=high if is_sun else light.position,  # shadows are cast from there
            dir=light.direction,
            diffuse=light.diffuse,
            specular=light.specular,
            attenuation=light.attenuation,
            cutoff=math.degrees(light.cutoff) if is_spot else 180.0,
            exponent=light.falloff if is_spot else 0.0,
            castshadow=light.casts_shadow and (is_sun or is_spot),
        )
    # A finer shadow takes three times as long to draw without a GPU [pixels a side].
    visual.quality.shadowsize = 1024
    if look.ambient is not None:
        visual.headlight.ambient = look.ambient
        visual.headlight.diffuse = visual.headlight.specular = (0.0, 0.0, 0.0)
    flat = look.background if look.fog is None else look.fog.colour
    spec.add_texture(
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=flat or _SKY,
        rgb2=flat or _HORIZON,
        width=64,
        height=384,
    )
    visual.rgba.fog = (0.0,) * 4 if look.fog is None else (*look.fog.colour, 1.0)


def set_reach(model: Any, look: Look) -> None:
    """Set how far a compiled model's shadows and fog reach, which MuJoCo counts in its extent."""
    model.vis.map.shadowclip = max(1.0, _SHADED / model.stat.extent)
    if look.fog is not None:
        model.vis.map.fogstart = look.fog.start / model.stat.extent
        model.vis.map.fogend = look.fog.end / model.stat.extent
