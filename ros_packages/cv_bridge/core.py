"""CvBridge: Image messages as arrays, in the colours that are asked for.

NumPy converts between grey, RGB and BGR, with alpha or without; Pillow packs and unpacks. Bayer
patterns and YUV need OpenCV, which is imported only for them.
"""

from __future__ import annotations

import io
import re
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Picture
from sensor_msgs.msg import CompressedImage, Image

from cv_bridge.aruco import complete

_DEPTHS = {
    "8U": np.uint8, "8S": np.int8, "16U": np.uint16, "16S": np.int16,
    "32S": np.int32, "32F": np.float32, "64F": np.float64,
}  # fmt: skip
_GENERIC = re.compile(r"(8U|8S|16U|16S|32S|32F|64F)(?:C(\d+))?")
_COLOURS = {"mono": "L", "rgb": "RGB", "bgr": "BGR", "rgba": "RGBA", "bgra": "BGRA"}
_COLOUR = re.compile(rf"({'|'.join(sorted(_COLOURS, key=len, reverse=True))})(8|16)")
_FORMATS = {
    "jpg": "JPEG",
    "jpeg": "JPEG",
    "png": "PNG",
    "bmp": "BMP",
    "tiff": "TIFF",
    "tif": "TIFF",
}
_YUV = {"yuv422": "UYVY", "uyvy": "UYVY", "yuv422_yuy2": "YUY2", "yuyv": "YUY2"}
_GREY = np.array((0.299, 0.587, 0.114))  # ITU-R BT.601, as OpenCV's


class CvBridgeError(TypeError):
    """An image cannot be converted as asked."""


class CvBridge:
    """Converts images between messages and arrays of rows, columns and channels."""

    def __init__(self) -> None:
        if (opencv := sys.modules.get("cv2")) is not None:
            complete(opencv)

    def imgmsg_to_cv2(self, img_msg: Image, desired_encoding: str = "passthrough") -> NDArray[Any]:
        """Return a message's image as an array, `(H, W)` or `(H, W, channels)`, in an encoding.

        Raises:
            CvBridgeError: There is no conversion.
        """
        dtype, channels = self.encoding_to_dtype_with_channels(img_msg.encoding)
        kind = np.dtype(dtype).newbyteorder(">" if img_msg.is_bigendian else "<")
        shape = (img_msg.height, img_msg.width, channels)
        strides = (img_msg.step, kind.itemsize * channels, kind.itemsize)
        if len(img_msg.data) < img_msg.step * img_msg.height:
            raise CvBridgeError(f"{len(img_msg.data)} bytes for {img_msg.height} rows of a step")
        view: NDArray[Any] = np.ndarray(shape, kind, img_msg.data, 0, strides)
        image = view.astype(kind.newbyteorder("="))
        if channels == 1:
            image = image[:, :, 0]
        if desired_encoding in ("passthrough", "", img_msg.encoding):
            return image
        return converted(image, img_msg.encoding, desired_encoding)

    def cv2_to_imgmsg(
        self, cvim: NDArray[Any], encoding: str = "passthrough", header: Any = None
    ) -> Image:
        """Return an array as a message.

        Raises:
            CvBridgeError: The array is none of the encoding.
        """
        if not isinstance(cvim, (np.ndarray, np.generic)):
            raise TypeError("Your input type is not a numpy array")
        depth = next((name for name, kind in _DEPTHS.items() if cvim.dtype == kind), None)
        if depth is None:
            raise CvBridgeError(f"images of {cvim.dtype} have no encoding; valid: {_names()}")
        channels = cvim.shape[2] if cvim.ndim == 3 else 1
        own = f"{depth}C{channels}"
        if encoding == "passthrough":
            encoding = own
        elif self.encoding_to_cvtype2(encoding) != self.encoding_to_cvtype2(own):
            raise CvBridgeError(f"encoding specified as {encoding}, but image has type {own}")
        message = Image(height=cvim.shape[0], width=cvim.shape[1], encoding=encoding)
        if header is not None:
            message.header = header
        message.is_bigendian = cvim.dtype.byteorder == ">"
        packed = np.ascontiguousarray(cvim)
        message.data.frombytes(packed.tobytes())
        message.step = packed.nbytes // max(1, cvim.shape[0])
        return message

    def compressed_imgmsg_to_cv2(
        self, cmprs_img_msg: CompressedImage, desired_encoding: str = "passthrough"
    ) -> NDArray[Any]:
        """Return the image of a JPEG, PNG, ... as an array, in BGR unless another is asked for."""
        try:
            picture: Picture.Image = Picture.open(io.BytesIO(bytes(cmprs_img_msg.data)))
            deep = picture.mode.startswith("I")
            if picture.mode not in ("L", "RGB", "RGBA") and not deep:
                picture = picture.convert("RGB")
            pixels = np.array(picture)
        except (OSError, ValueError) as error:
            raise CvBridgeError(f"'{cmprs_img_msg.format}': {error}") from error
        own = "mono16" if deep else {"L": "mono8"}.get(picture.mode, f"{picture.mode.lower()}8")
        if desired_encoding == "passthrough":
            desired_encoding = own if deep else "bgr8"  # as cv2.imdecode does
        return converted(pixels.astype(np.uint16) if deep else pixels, own, desired_encoding)

    def cv2_to_compressed_imgmsg(
        self, cvim: NDArray[Any], dst_format: str = "jpg"
    ) -> CompressedImage:
        """Return a grey or BGR array as a JPEG, PNG, ...

        Raises:
            CvBridgeError: There is no such format.
        """
        if dst_format not in _FORMATS:
            raise CvBridgeError(f"no format '{dst_format}'; valid: {', '.join(_FORMATS)}")
        if not isinstance(cvim, (np.ndarray, np.generic)):
            raise TypeError("Your input type is not a numpy array")
        pixels = cvim if cvim.ndim == 2 else converted(cvim[:, :, :3], "bgr8", "rgb8")
        out = io.BytesIO()
        quality = {"quality": 95} if _FORMATS[dst_format] == "JPEG" else {}  # OpenCV's
        Picture.fromarray(np.ascontiguousarray(pixels)).save(out, _FORMATS[dst_format], **quality)
        message = CompressedImage(format=dst_format)
        message.data.frombytes(out.getvalue())
        return message

    def encoding_to_dtype_with_channels(self, encoding: str) -> tuple[str, int]:
        """Return NumPy's name of an encoding's numbers, and the number of channels.

        Raises:
            CvBridgeError: There is no such encoding.
        """
        if found := _GENERIC.fullmatch(encoding):
            return np.dtype(_DEPTHS[found[1]]).name, int(found[2] or 1)
        if found := _COLOUR.fullmatch(encoding):
            return f"uint{found[2]}", len(_COLOURS[found[1]])
        if encoding.startswith("bayer_"):
            return "uint16" if encoding.endswith("16") else "uint8", 1
        if encoding in _YUV:
            return "uint8", 2
        raise CvBridgeError(f"no encoding '{encoding}'; valid: {_names()}")

    def encoding_to_cvtype2(self, encoding: str) -> int:
        """Return OpenCV's number of an encoding's type."""
        dtype, channels = self.encoding_to_dtype_with_channels(encoding)
        return self.dtype_with_channels_to_cvtype2(dtype, channels)

    def dtype_with_channels_to_cvtype2(self, dtype: str, n_channels: int) -> int:
        """Return OpenCV's number of a type: `depth + 8 * (channels - 1)`."""
        return [*_DEPTHS.values()].index(np.dtype(dtype).type) + 8 * (n_channels - 1)

    def cvtype2_to_dtype_with_channels(self, cvtype: int) -> tuple[str, int]:
        """Return NumPy's name and the number of channels of OpenCV's number of a type."""
        return np.dtype([*_DEPTHS.values()][cvtype % 8]).name, cvtype // 8 + 1


def _names() -> str:
    return f"{', '.join(f'{name}8, {name}16' for name in _COLOURS)}, {', '.join(_DEPTHS)} (C1, ...)"


def converted(image: NDArray[Any], given: str, wanted: str) -> NDArray[Any]:
    """Return an image in another encoding.

    Raises:
        CvBridgeError: There is no conversion.
    """
    bridge = CvBridge()
    dtype, channels = bridge.encoding_to_dtype_with_channels(wanted)
    if given.startswith("bayer_") or given in _YUV:
        image, given = _by_opencv(image, given)
    colours, source = _COLOUR.fullmatch(wanted), _COLOUR.fullmatch(given)
    if colours and source:
        image = _recoloured(image, _COLOURS[source[1]], _COLOURS[colours[1]])
    elif (1 if image.ndim == 2 else image.shape[2]) != channels:
        raise CvBridgeError(f"there is no conversion from {given} to {wanted}")
    return _scaled(image, np.dtype(dtype))


def _scaled(image: NDArray[Any], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return an image of another type; whole numbers of 8 and 16 bits have one full scale."""
    kinds = image.dtype.name, dtype.name
    if kinds == ("uint8", "uint16"):
        return image.astype(np.uint16) * 257
    if kinds == ("uint16", "uint8"):
        return np.rint(image / 257.0).astype(np.uint8)
    if np.issubdtype(dtype, np.integer) and not np.issubdtype(image.dtype, np.integer):
        limits = np.iinfo(dtype)
        image = np.clip(np.rint(image), limits.min, limits.max)
    return image.astype(dtype)


def _recoloured(image: NDArray[Any], given: str, wanted: str) -> NDArray[Any]:
    """Return an image with other channels, each named by a letter."""
    if given == wanted:
        return image
    if wanted == "L":
        weights = np.array([_GREY["RGB".index(c)] if c in "RGB" else 0.0 for c in given])
        grey: NDArray[Any] = np.rint(image @ weights).astype(image.dtype)
        return grey
    opaque = np.full(image.shape[:2], np.iinfo(image.dtype).max, image.dtype)
    of = {"L": image} if given == "L" else {c: image[:, :, i] for i, c in enumerate(given)}
    return np.dstack([of.get(c, opaque if c == "A" else of.get("L", opaque)) for c in wanted])


def _by_opencv(image: NDArray[Any], given: str) -> tuple[NDArray[Any], str]:
    """Return a Bayer or YUV image in BGR, and its encoding then."""
    try:
        import cv2
    except ModuleNotFoundError as error:
        raise CvBridgeError(
            f"'{given}' needs OpenCV: pip install opencv-python-headless"
        ) from error
    bits = "16" if image.dtype == np.uint16 else "8"
    if given in _YUV:
        return cv2.cvtColor(image, getattr(cv2, f"COLOR_YUV2BGR_{_YUV[given]}")), "bgr8"
    # the message names the first row's colours, OpenCV those from the second row and column on
    first = given.removeprefix("bayer_").rstrip("0123456789")
    name = {"rggb": "BG", "bggr": "RG", "gbrg": "GR", "grbg": "GB"}[first]
    return cv2.cvtColor(image, getattr(cv2, f"COLOR_Bayer{name}2BGR")), f"bgr{bits}"
