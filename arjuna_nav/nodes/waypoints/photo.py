"""A picture at each waypoint."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from PIL import Image as Picture
from sensor_msgs.msg import Image

from arjuna_core.config import fixed, param
from arjuna_core.errors import ConfigError
from arjuna_core.files.whole_file import write_atomically
from arjuna_core.pixels import pixels
from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode

_FORMATS = "png", "jpg", "jpeg", "bmp", "tif", "tiff", "webp", "ppm", "pgm"


@dataclass(frozen=True)
class PhotoConfig:
    """Parameters of a picture."""

    enabled: bool = param(True, "Whether to take one.")
    image_topic: str = fixed("/camera/color/image_raw", "The camera's topic.")
    save_dir: str = param(
        "/tmp/waypoint_images",  # noqa: S108 - Nav2's default
        "Folder of the pictures, below your home, the working folder or /tmp; your own.",
        path=True,
    )
    image_format: str = param("png", "Their format.", choices=_FORMATS)


class PhotoAtWaypoint:
    """Saves the newest picture as `<waypoint>_<second>.<format>`; fails where there is none.

    Args:
        config: Which camera, and where to.
        node: In its `configure`.

    Raises:
        ConfigError: The folder is another user's, or not below the user's home, the working
            folder or /tmp.

    Source: nav2_waypoint_follower, PhotoAtWaypoint.
    """

    Config: ClassVar[type[Any]] = PhotoConfig

    def __init__(self, config: Any, node: ManagedNode) -> None:
        self._config, self._log = config, node.get_logger()
        self._folder = _own_folder(config.save_dir) if config.enabled else Path()
        self._newest: Any | None = None
        self._taken = False
        self.problem = ""
        node.subscribe(Image, config.image_topic, self._on_image, qos.SENSOR_SUBSCRIPTION)

    def _on_image(self, message: Any) -> None:
        self._newest = message

    def start(self, pose: Any, index: int, now: float) -> None:
        if not self._config.enabled:
            self._taken = True
            return
        path = self._folder / f"{index}_{pose.header.stamp.sec}.{self._config.image_format}"
        try:
            write_atomically(path, self._encoded())
        except (OSError, ValueError) as error:
            self._taken, self.problem = False, f"no picture in {path}: {error}"
        else:
            self._taken = True
            self._log.info(f"picture at waypoint {index}: {path}")

    def tick(self, now: float) -> bool | None:
        return self._taken

    def _encoded(self) -> bytes:
        """Return the newest picture as a file's bytes.

        Raises:
            ValueError: None has come, or it is in an encoding that is not known.
        """
        seen = self._newest
        if seen is None:
            raise ValueError(f"no image has come on {self._config.image_topic}")
        image = pixels(seen.encoding, seen.height, seen.width, seen.step, bytes(seen.data))
        data = io.BytesIO()
        Picture.fromarray(image).save(
            data, Picture.registered_extensions()[f".{self._config.image_format}"]
        )
        return data.getvalue()


def _own_folder(path: str) -> Path:
    """Return a folder of the user's below home, the working folder or /tmp.

    Raises:
        ConfigError: It lies elsewhere, or is another user's.
    """
    folder = Path(path).expanduser().resolve()
    roots = Path.home(), Path.cwd(), Path("/tmp")  # noqa: S108 - where Nav2's default is
    if not any(folder.is_relative_to(root.resolve()) for root in roots):
        problem = f"lies neither below {' nor '.join(map(str, roots))}"
    elif folder.exists() and folder.stat().st_uid != os.getuid():
        problem = "is another user's"
    else:
        return folder
    raise ConfigError(f"save_dir '{path}' {problem}; set it to a folder of yours, as ~/pictures")
