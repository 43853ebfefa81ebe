"""Which sensor model a configuration names."""

from __future__ import annotations

from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.sensors.beam_model import BeamModel
from arjuna_slam.amcl.sensors.likelihood_field import (
    LikelihoodField,
    LikelihoodFieldProb,
    SensorModel,
)
from arjuna_slam.matching.map_field import MapField


def make_sensor(field: MapField, config: AmclConfig) -> SensorModel:
    """Return the sensor model that the configuration names."""
    if config.laser_model_type == "likelihood_field":
        return LikelihoodField(field, config)
    if config.laser_model_type == "beam":
        return BeamModel(field, config)
    return LikelihoodFieldProb(field, config)
