"""Arrays by what they hold."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Single = NDArray[np.float32]  # what is kept of every frame; sums are made in double
Complex = NDArray[np.complexfloating[Any, Any]]
Grey = NDArray[np.uint8]  # a picture, (height, width)
Mask = NDArray[np.bool_]
Places = NDArray[np.int64]  # places in another array
