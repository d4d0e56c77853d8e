"""Who hears how a run goes."""

from __future__ import annotations

import contextlib
import importlib
from typing import Any, Callable, Iterator, Optional, Tuple

from ._records import Iteration

Fields = Tuple[Any, ...]
Listener = Optional[Callable[[Fields], Any]]


def _bar() -> Any:
    try:
        tqdm = importlib.import_module("tqdm.auto").tqdm
    except ImportError:
        raise ImportError(
            "progress: True draws a bar with tqdm, which is not installed: install it, or give a "
            "function"
        ) from None
    return tqdm(total=100, unit="%", bar_format="{l_bar}{bar}| {elapsed}<{remaining}{postfix}")


@contextlib.contextmanager
def listener(progress: Any) -> Iterator[Listener]:
    """What the library is to call: for None and False nothing, for True a bar, else `progress`."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        bar = _bar()

        def draw(fields: Fields) -> None:
            record = Iteration._make(fields)
            bar.update(round(100 * record.progress, 1) - bar.n)
            bar.set_postfix_str(f"energy {record.energy:.6g}", refresh=False)

        with bar:
            yield draw
    elif callable(progress):
        yield lambda fields: progress(Iteration._make(fields))
    else:
        raise TypeError(f"progress: is {progress!r}, but must be a function, True or None")
