"""What arguments must be. Messages name the argument, the value and the rule, as the library's do."""

from __future__ import annotations

import numbers
import operator
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from ._records import Array

_INT32_MAX = 2**31 - 1
_UINT64_MAX = 2**64 - 1


def whole(name: str, value: Any, least: int, most: int = _INT32_MAX) -> int:
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name}: is {value!r}, but must be a whole number")
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: is {value!r}, but must be a whole number") from None
    if not least <= number <= most:
        raise ValueError(f"{name}: is {number}, but must be from {least} to {most}")
    return number


def real(name: str, value: Any) -> float:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name}: is {value!r}, but must be a number")
    return float(value)


def finite(name: str, value: Any) -> float:
    number = real(name, value)
    if not np.isfinite(number):
        raise ValueError(f"{name}: is {number}, but must be finite")
    return number


def share(name: str, value: Any) -> float:
    number = real(name, value)
    if not 0 <= number < 1:
        raise ValueError(f"{name}: is {number}, but must be at least 0 and less than 1")
    return number


def seed_of(value: Any) -> int:
    return whole("seed", value, 0, _UINT64_MAX)


def threads_of(value: Any) -> int:
    return whole("threads", value, 0, 4096)


def flag(name: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name}: is {value!r}, but must be True or False")
    return bool(value)


def plain(name: str, value: Any) -> Array:
    """An array, but none of which entries are masked: what they stand for is not known here."""
    if isinstance(value, np.ma.MaskedArray) and np.any(value.mask):
        raise ValueError(f"{name}: has masked entries; leave them out, or fill them in")
    try:
        return np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name}: must be an array of numbers: {error}") from None


def _numeric(name: str, value: Any) -> Array:
    array = plain(name, value)
    if array.dtype.kind == "O":
        try:
            array = array.astype(np.float64)
        except TypeError as error:
            raise TypeError(f"{name}: must be an array of numbers: {error}") from None
        except (ValueError, OverflowError) as error:
            raise ValueError(f"{name}: must be an array of numbers: {error}") from None
    if array.dtype.kind not in "fiub":
        raise ValueError(f"{name}: is an array of {array.dtype}, but must be of real numbers")
    return array


def contiguous(array: Array, dtype: Any = None) -> Array:
    """In C order, each number at a multiple of its size, as C++ may look at it."""
    return np.require(array, dtype, ["C", "A"])


def as_float(name: str, value: Any, dtype: Any = None) -> Array:
    """An array of native float32 or float64: of `dtype`, or as it is, or else float64."""
    array = _numeric(name, value)
    if dtype is None:
        native = array.dtype.newbyteorder("=")
        dtype = native if native in (np.float32, np.float64) else np.float64
    made = array.astype(dtype, copy=False)
    if array.dtype.kind in "iu" and array.dtype.itemsize >= made.itemsize:
        # The largest is no float: rounded, it is one too many.
        inside = bool((made < float(np.iinfo(array.dtype).max)).all())
        if not inside or not np.array_equal(made.astype(array.dtype), array):
            raise ValueError(f"{name}: has whole numbers that {np.dtype(dtype)} does not hold exactly")
    return made


def table(name: str, value: Any, dtype: Any = None) -> Array:
    """Points of shape (N, D), one a row, whose rows the library can look at where they are."""
    array = as_float(name, value, dtype)
    if array.ndim != 2:
        hint = "; one dimension is points[:, None]" if array.ndim == 1 else ""
        raise ValueError(f"{name}: has the shape {array.shape}, but must be (N, D), one a row{hint}")
    if array.shape[1] > _INT32_MAX:
        raise ValueError(
            f"{name}: have {array.shape[1]} dimensions, but at most {_INT32_MAX} are supported"
        )
    item = array.itemsize
    in_place = (
        array.flags.aligned
        and array.strides[1] == item
        and array.strides[0] % item == 0
        and array.strides[0] >= array.shape[1] * item
    )
    return array if in_place else contiguous(array)


def samples(X: Any) -> Array:
    """Samples of shape (n_samples, n_features); messages are as scikit-learn has them."""
    if hasattr(X, "toarray") and hasattr(X, "nnz"):
        raise TypeError("X: is a sparse matrix, but must be dense; X.toarray() makes it so")
    array = plain("X", X)
    if array.dtype.kind == "c":
        raise ValueError("Complex data not supported: X must be of real numbers")
    if array.ndim != 2:
        raise ValueError(
            f"X: has the shape {array.shape}, but must be (n_samples, n_features). Reshape your "
            "data: X.reshape(-1, 1) for one feature, X.reshape(1, -1) for one sample"
        )
    for axis, what in enumerate(("sample", "feature")):
        if array.shape[axis] == 0:
            raise ValueError(
                f"Found array with 0 {what}(s) (shape={array.shape}) while a minimum of 1 is required."
            )
    checked = table("X", array)
    if not np.isfinite(checked.sum(dtype=np.float64)) and not np.isfinite(checked).all():
        raise ValueError("X: contains NaN or infinity")
    return checked


def sample_weights(value: Any, count: int) -> Optional[Array]:
    if value is None:
        return None
    weights = as_float("sample_weight", value, np.float64)
    if weights.ndim == 0:
        weights = np.full(count, weights)
    if weights.shape != (count,):
        raise ValueError(
            f"sample_weight: has the shape {weights.shape}, but must be ({count},): one a sample"
        )
    good = np.isfinite(weights) & (weights >= 0)
    if not good.all():
        first = int(np.argmin(good))
        raise ValueError(
            f"sample_weight: entry {first} is {weights[first]}, but must be finite and at least 0"
        )
    return weights


def vector(name: str, value: Any) -> Array:
    array = as_float(name, value, np.float64)
    if array.ndim != 1:
        raise ValueError(f"{name}: has the shape {array.shape}, but must have one dimension")
    return contiguous(array)


def indices(name: str, value: Any, ndim: int = 1) -> Array:
    """Whole numbers, as int32."""
    array = plain(name, value)
    if array.ndim != ndim or array.dtype.kind not in "iuf":
        raise ValueError(
            f"{name}: is an array of {array.dtype} of shape {array.shape}, but must hold whole "
            f"numbers in {ndim} dimension{'s' if ndim > 1 else ''}"
        )
    good = (array >= -_INT32_MAX) & (array <= _INT32_MAX)
    if array.dtype.kind == "f":
        good &= array == np.floor(array)
    if not good.all():
        where = np.unravel_index(int(np.argmin(good)), array.shape)
        raise ValueError(
            f"{name}: entry {', '.join(str(i) for i in where)} is {array[where]}, but must be a "
            "whole number below 2147483648"
        )
    return contiguous(array, np.int32)


def shades(name: str, values: Array) -> Array:
    """Grey values of float32 in [0, 1], of what has shape (height, width)."""
    outside = ~((values >= 0) & (values <= np.float32(1.0001)))
    if outside.any():
        row, column = np.argwhere(outside)[0]
        raise ValueError(
            f"{name}: entry ({row}, {column}) is {values[row, column]}, but floats must be from "
            "0 (black) to 1 (white)"
        )
    return contiguous(np.minimum(values, np.float32(1)), np.float32)


def domain_of(box: Any, periodic: Any, dimension: int) -> Tuple[Optional[Array], List[bool]]:
    """Both corners, and of each dimension whether it is periodic."""
    along = np.asarray(periodic)
    if along.dtype != np.bool_ or along.shape not in [(), (dimension,)]:
        raise ValueError(
            f"periodic: is {periodic!r}, but must be True, False, or one of these for each of the "
            f"{dimension} dimensions"
        )
    flags = [bool(one) for one in np.broadcast_to(along, dimension)]
    if box is None:
        if any(flags):
            raise ValueError("periodic: needs a box, the bounds of one period")
        return None, flags
    corners = as_float("box", box, np.float64)
    if corners.shape != (2, dimension):
        raise ValueError(
            f"box: has the shape {corners.shape}, but must be (2, {dimension}): the lower corner and "
            "the upper one"
        )
    return contiguous(corners), flags


def dtype_of(dtype: Any) -> np.dtype[Any]:
    try:
        made = np.dtype(dtype)
    except TypeError:
        raise TypeError(f"dtype: is {dtype!r}, but must be float32 or float64") from None
    if made not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise ValueError(f"dtype: is {made}, but must be float32 or float64")
    return made


def run_options(
    *,
    seed: Any,
    threads: Any,
    until: Any = None,
    max_iterations: Any = None,
    energy_tolerance: Any = 0.0,
    time_limit: Any = 0.0,
    preset: Any = None,
) -> Dict[str, Any]:
    options: Dict[str, Any] = {
        "seed": seed_of(seed),
        "threads": threads_of(threads),
        "energy_tolerance": real("energy_tolerance", energy_tolerance),
        "time_limit": real("time_limit", time_limit),
    }
    if until is not None:
        options["until"] = str(until)
    if max_iterations is not None:
        options["max_iterations"] = whole("max_iterations", max_iterations, 0)
    if preset is not None:
        options["preset"] = str(preset)
    return options
