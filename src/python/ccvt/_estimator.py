"""What estimators have in common: scikit-learn's base classes, or, where it is missing, their part."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any, Dict, List

if TYPE_CHECKING:

    class NotFittedError(ValueError, AttributeError): ...

    class Estimator:
        def get_params(self, deep: bool = True) -> Dict[str, Any]: ...
        def set_params(self, **params: Any) -> Any: ...

else:
    try:
        from sklearn.base import BaseEstimator, ClusterMixin, TransformerMixin
        from sklearn.exceptions import NotFittedError

        class Estimator(TransformerMixin, ClusterMixin, BaseEstimator):
            pass

    except ImportError:

        class NotFittedError(ValueError, AttributeError):
            """An estimator is used before it is fitted."""

        class Estimator:
            """What scikit-learn's base classes do, without it."""

            _estimator_type = "clusterer"

            @classmethod
            def _names(cls) -> List[str]:
                return sorted(name for name in inspect.signature(cls.__init__).parameters
                              if name != "self")  # fmt: skip

            def get_params(self, deep: bool = True) -> Dict[str, Any]:
                return {name: getattr(self, name) for name in self._names()}

            def set_params(self, **params: Any) -> Any:
                for name, value in params.items():
                    if name not in self._names():
                        raise ValueError(
                            f"Invalid parameter {name!r} for estimator {self}. Valid parameters are: "
                            f"{self._names()!r}."
                        )
                    setattr(self, name, value)
                return self

            def __repr__(self) -> str:
                defaults = {name: parameter.default for name, parameter
                            in inspect.signature(type(self).__init__).parameters.items()}  # fmt: skip
                changed = [f"{name}={value!r}" for name, value in self.get_params().items()
                           if repr(value) != repr(defaults[name])]  # fmt: skip
                return f"{type(self).__name__}({', '.join(changed)})"
