# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What users give, brought into the form that the extension module takes, or refused by a line."""

from __future__ import annotations

import json
import math
from typing import Any, Mapping, Optional, Sequence

import numpy as np

from sightline._sightline import InputError


def array(
    where: str, value: Any, shape: Sequence[Optional[int]], finite: bool = True
) -> np.ndarray:
    """`value` as doubles of that shape; None in it stands for any length."""
    try:
        out = np.array(value, dtype=np.float64, order="C", copy=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"{where}: is no array of numbers ({error})") from None
    fits = out.ndim == len(shape) and all(s in (None, n) for s, n in zip(shape, out.shape))
    if not fits:
        wanted = ", ".join("n" if s is None else str(s) for s in shape)
        raise InputError(f"{where}: has shape {out.shape}, must be ({wanted})")
    if finite and not np.isfinite(out).all():
        raise InputError(f"{where}: holds a number that is not finite")
    return out


def whole(where: str, value: Any, least: int, most: int) -> int:
    """`value` as a whole number within limits."""
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not is_whole or not least <= value <= most:
        raise InputError(f"{where}: is {value!r}, must be a whole number from {least} to {most}")
    return int(value)


def toml(where: str, value: Any) -> str:
    """A value as a study's file would write it."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        if isinstance(value, float) and not math.isfinite(value):
            return "nan" if math.isnan(value) else ("inf" if value > 0 else "-inf")
        return repr(value)
    if isinstance(value, (str, bytes)) or hasattr(value, "__fspath__"):
        text = value.decode() if isinstance(value, bytes) else str(value)
        return json.dumps(text, ensure_ascii=False)
    if isinstance(value, Mapping):
        pairs = (f"{json.dumps(str(key))} = {toml(where, each)}" for key, each in value.items())
        return "{" + ", ".join(pairs) + "}"
    if isinstance(value, (list, tuple, range, np.ndarray)):
        return "[" + ", ".join(toml(where, v) for v in value) + "]"
    raise InputError(f"{where}: is of type {type(value).__name__}, which a file cannot hold")


def settings(where: str, values: Optional[Mapping[str, Any]], prefix: str = "") -> list[str]:
    """Keys and values as the program's option --set takes them: "table.key=value"."""
    if values is None:
        return []
    if not isinstance(values, Mapping):
        raise InputError(f"{where}: is of type {type(values).__name__}, must map keys to values")
    return [f"{prefix}{key}={toml(f'{where}[{key!r}]', value)}" for key, value in values.items()]
