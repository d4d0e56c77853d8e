"""Balanced k-means, with the conventions of scikit-learn, which need not be installed."""

from __future__ import annotations

import contextlib
import os
import re
from typing import Any, Dict, Iterator, List, Optional, SupportsIndex, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _ccvt, _checks
from ._estimator import Estimator, NotFittedError
from ._progress import listener
from ._records import Array, Iteration
from ._tessellate import Progress, tessellate

_METHODS = ("exact", "pairwise", "lloyd")
_NAMES = {"points": "X", "vectors": "X", "masses": "sample_weight"}


@contextlib.contextmanager
def _own_names(progress: Progress = None) -> Iterator[Progress]:
    """What is wrong with an argument is told by the name that it has here, not in the library.

    Gives the function that is to hear of iterations: what `progress` raises passes as it is.
    """
    raised: List[ValueError] = []

    def heard(record: Iteration) -> Any:
        try:
            return progress(record) if callable(progress) else None
        except ValueError as error:
            raised.append(error)
            raise

    try:
        yield heard if callable(progress) else progress
    except ValueError as error:
        if type(error) is not ValueError or error in raised:  # somebody else's
            raise
        names = "|".join(_NAMES)
        told = re.sub(
            rf"^({names})(?=:)|\b({names})(?=\[)", lambda found: _NAMES[found[0]], str(error)
        )
        raise ValueError(told) from None


def _processors() -> int:
    """Those for this process, where the system tells."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class BalancedKMeans(Estimator):
    """K-means with clusters of given sizes: equal ones, but for one, by default.

    Follows scikit-learn's conventions; scikit-learn need not be installed.

    Parameters
    ----------
    n_clusters : int, default 8
    random_state : int, RandomState, Generator or None, default None
        What fixes the random choices. None: fresh ones each time.
    n_jobs : int or None, default None
        Threads; None and -1: one per processor, -2: one less, ... Any number gives identical bits.
    capacities : array_like of int, shape (n_clusters,), optional
        How many samples each cluster gets, summing to their number. With `sample_weight`: how much
        weight, summing to all of it.
    method : {"exact", "pairwise", "lloyd"}, default "exact"
        ``"exact"``: the cheapest assignment that keeps the capacities, proved to be so; ``"pairwise"``:
        only exchanges between two clusters are looked at; ``"lloyd"``: plain k-means, without
        capacities.
    init : {"k-means++", "random"} or array_like of shape (n_clusters, n_features)
    n_init : "auto" or int, default "auto"
        Seedings tried on a sample; the best one is used.
    effort : int or None, default None
        Codebooks bred from the seedings on a sample. None: as many as pay.
    max_iter : int, default 10000
    tol : float, default 0
        Stops when an iteration lowers the inertia by less than this share of it.
    time_limit : float, default 0
        Seconds after which training ends with what it has reached; 0: no limit. RuntimeError where
        samples weigh differently and nothing is reached in them.
    gap : float, default 0
        ``"exact"``, which alone may have one, ends when the assignment is proved to cost at most this
        share too much.
    train_sample : int or None, default None
        ``"exact"`` trains on so many samples, drawn at random; all of them then move the centres once
        and are assigned: for millions of samples, of which a cluster needs some hundred. None: on
        all.
    predict_by : {"weight", "nearest"}, default "weight"
        What `predict` does. ``"weight"``: the least squared distance minus the cluster's weight, by
        which samples like those of the training fill clusters evenly; ``"nearest"``: the nearest
        centre. With other methods than ``"exact"`` weights are 0, and both are the same.
    progress : callable or bool, optional
        Called after each iteration with an :class:`Iteration`; False stops training. True draws a
        bar with tqdm.

    Attributes
    ----------
    cluster_centers_ : ndarray of float64, shape (n_clusters, n_features)
    labels_ : ndarray of int32, shape (n_samples,)
        Of the samples that were fitted.
    inertia_ : float
        Sum of squared distances of these to their centres, times their weights if they have some.
    n_iter_ : int
    weights_ : ndarray of float64, shape (n_clusters,)
        Of the clusters, for `predict`.
    gap_ : float
        No assignment that keeps the capacities has an inertia below (1 - gap_) * inertia_, for the
        same centres. 0 for other methods than ``"exact"``; NaN where samples weigh differently.
    termination_ : str
        How training ended: ``"stable"``, ``"iteration_limit"``, ...
    n_features_in_ : int

    Notes
    -----
    With a `sample_weight`, samples of weight 0 are not trained with, and get the nearest cluster.
    Where the others do not weigh the same, clusters have equal weight as nearly as whole samples
    allow: by less than the heaviest sample, which may not be heavier than a cluster. This is
    :func:`tessellate` with masses; `method`, `init`, `n_init`, `effort`, `gap` and `train_sample`
    do not count then, and weights of clusters are 0.

    Examples
    --------
    >>> import numpy as np
    >>> from ccvt import BalancedKMeans
    >>> X = np.random.default_rng(1).normal(size=(1000, 4))
    >>> model = BalancedKMeans(10, random_state=0).fit(X)
    >>> np.bincount(model.labels_).tolist()
    [100, 100, 100, 100, 100, 100, 100, 100, 100, 100]
    >>> model.predict(X[:5]).shape
    (5,)
    """

    def __init__(
        self,
        n_clusters: SupportsIndex = 8,
        *,
        random_state: Any = None,
        n_jobs: Optional[SupportsIndex] = None,
        capacities: Optional[ArrayLike] = None,
        method: str = "exact",
        init: Union[str, ArrayLike] = "k-means++",
        n_init: Union[SupportsIndex, str] = "auto",
        effort: Optional[SupportsIndex] = None,
        max_iter: SupportsIndex = 10_000,
        tol: float = 0.0,
        time_limit: float = 0.0,
        gap: float = 0.0,
        train_sample: Optional[SupportsIndex] = None,
        predict_by: str = "weight",
        progress: Progress = None,
    ) -> None:
        self.n_clusters = n_clusters
        self.random_state = random_state
        self.n_jobs = n_jobs
        self.capacities = capacities
        self.method = method
        self.init = init
        self.n_init = n_init
        self.effort = effort
        self.max_iter = max_iter
        self.tol = tol
        self.time_limit = time_limit
        self.gap = gap
        self.train_sample = train_sample
        self.predict_by = predict_by
        self.progress = progress

    def fit(
        self, X: ArrayLike, y: Any = None, sample_weight: Optional[ArrayLike] = None
    ) -> "BalancedKMeans":
        """Finds the clusters.

        Parameters
        ----------
        X : array_like of shape (n_samples, n_features)
            float32 and float64 are used where they are, and must not be changed meanwhile; others are
            converted.
        y : ignored
        sample_weight : array_like of shape (n_samples,), optional
            See the notes of the class.

        Returns
        -------
        self
        """
        fitted = {name: value for name, value in vars(self).items() if name.endswith("_")}
        try:
            self._fit(X, sample_weight)
        except BaseException:
            # As the last fit that ended left it.
            for name in [name for name in vars(self) if name.endswith("_")]:
                delattr(self, name)
            vars(self).update(fitted)
            raise
        return self

    def _fit(self, X: Any, sample_weight: Any) -> None:
        checked = self._checked(X, fitting=True)
        clusters = _checks.whole("n_clusters", self.n_clusters, 1)
        if len(checked) < clusters:
            raise ValueError(
                f"X: n_samples={len(checked)}, but must be at least n_clusters={clusters}"
            )
        self._predicts_by_weight()
        weights = _checks.sample_weights(sample_weight, len(checked))
        if weights is None:
            self._fit_codebook(checked, clusters)
        else:
            self._fit_weighted(checked, clusters, weights)

    def fit_predict(
        self, X: ArrayLike, y: Any = None, sample_weight: Optional[ArrayLike] = None
    ) -> Array:
        """`fit`, and then `labels_`.

        Parameters
        ----------
        X, y, sample_weight
            As for :meth:`fit`.

        Returns
        -------
        ndarray of int32, shape (n_samples,)
        """
        return self.fit(X, y, sample_weight).labels_

    def fit_transform(
        self, X: ArrayLike, y: Any = None, sample_weight: Optional[ArrayLike] = None
    ) -> Array:
        """`fit`, and then `transform` of the same samples.

        Parameters
        ----------
        X, y, sample_weight
            As for :meth:`fit`.

        Returns
        -------
        ndarray of float64, shape (n_samples, n_clusters)
        """
        return self.fit(X, y, sample_weight).transform(X)

    def _fit_codebook(self, X: Array, clusters: int) -> None:
        options = self._codebook_options()
        start: Optional[Array] = None
        if isinstance(self.init, str):
            options["init"] = self.init
        else:
            start = _checks.table("init", self.init, np.float64)
            if start.shape != (clusters, X.shape[1]):
                raise ValueError(
                    f"init: has the shape {start.shape}, but must be ({clusters}, {X.shape[1]})"
                )
        with _own_names(self.progress) as progress, listener(progress) as heard:
            found = _ccvt.train_codebook(X, clusters, start, options, heard)
        summary = found["summary"]
        self.cluster_centers_: Array = found["codewords"]
        self.weights_: Array = found["weights"]
        self.labels_: Array = found["codes"]
        self.inertia_: float = summary["energy"]
        self.n_iter_: int = summary["iterations"]
        self.gap_: float = summary["gap"]
        self.termination_: str = summary["termination"]

    def _codebook_options(self) -> Dict[str, Any]:
        if self.method not in _METHODS:
            raise ValueError(f"method: is {self.method!r}, but must be one of {', '.join(_METHODS)}")
        options: Dict[str, Any] = {
            "method": self.method,
            "max_iter": _checks.whole("max_iter", self.max_iter, 0),
            "tol": _checks.share("tol", self.tol),
            "time_limit": _checks.real("time_limit", self.time_limit),
            "gap": _checks.share("gap", self.gap),
            "seed": self._seed(),
            "threads": self._threads(),
        }
        if self.n_init != "auto":
            options["n_init"] = _checks.whole("n_init", self.n_init, 1)
        if self.effort is not None:
            options["effort"] = _checks.whole("effort", self.effort, 0)
        if self.train_sample is not None:
            options["train_sample"] = _checks.whole("train_sample", self.train_sample, 1)
        if self.capacities is not None:
            if self.method == "lloyd":
                raise ValueError("capacities: method='lloyd' does not keep any")
            options["capacities"] = _checks.indices("capacities", self.capacities)
        return options

    def _fit_weighted(self, X: Array, clusters: int, weights: Array) -> None:
        """Trains with the samples that have a weight; the others then go to the nearest centre."""
        heavy = weights > 0
        if np.count_nonzero(heavy) < clusters:
            raise ValueError(
                f"sample_weight: {np.count_nonzero(heavy)} are above 0, but must be at least "
                f"n_clusters={clusters}"
            )
        trained, masses = (X, weights) if heavy.all() else (X[heavy], weights[heavy])
        if self.capacities is None and (masses == masses[0]).all():
            self._fit_codebook(trained, clusters)
            self.inertia_ *= float(masses[0])
        else:
            self._fit_masses(trained, clusters, masses)
        if len(trained) < len(X):
            labels = self._encode(X, False)
            labels[heavy] = self.labels_
            self.labels_ = labels

    def _fit_masses(self, X: Array, clusters: int, weights: Array) -> None:
        if not isinstance(self.init, str):
            raise ValueError("init: an array cannot be given with sample_weight")
        with _own_names(self.progress) as progress:
            found: Any = tessellate(
                X,
                clusters,
                masses=weights,
                capacities=self.capacities,
                seed=self._seed(),
                threads=self._threads(),
                max_iterations=_checks.whole("max_iter", self.max_iter, 0),
                energy_tolerance=self.tol,
                time_limit=self.time_limit,
                progress=progress,
            )
        self.cluster_centers_ = found.sites.astype(np.float64)
        self.weights_ = np.zeros(clusters)
        self.labels_ = found.owners
        self.inertia_ = found.summary.energy
        self.n_iter_ = found.summary.iterations
        self.gap_ = float("nan")
        self.termination_ = found.summary.termination

    def predict(self, X: ArrayLike, sample_weight: Any = None) -> Array:
        """The cluster of each sample, by `predict_by`.

        Parameters
        ----------
        X : array_like of shape (n_samples, n_features)
        sample_weight : ignored

        Returns
        -------
        ndarray of int32, shape (n_samples,)
        """
        checked = self._checked(X)
        return self._encode(checked, self._predicts_by_weight())

    def _encode(self, X: Array, weighted: bool) -> Array:
        centres = _checks.table("cluster_centers_", self.cluster_centers_, np.float64)
        weights = _checks.vector("weights_", self.weights_)
        with _own_names():
            return _ccvt.encode(X, centres, weights, weighted, self._threads())

    def transform(self, X: ArrayLike) -> Array:
        """The distance of each sample to each centre.

        Parameters
        ----------
        X : array_like of shape (n_samples, n_features)

        Returns
        -------
        ndarray of float64, shape (n_samples, n_clusters)
        """
        checked = self._checked(X)
        distances = np.empty((len(checked), len(self.cluster_centers_)))
        for k, centre in enumerate(self.cluster_centers_):
            distances[:, k] = np.linalg.norm(checked - centre, axis=1)
        return distances

    def score(self, X: ArrayLike, y: Any = None, sample_weight: Optional[ArrayLike] = None) -> float:
        """Minus the sum of squared distances of samples to the centres that `predict` gives them.

        Parameters
        ----------
        X : array_like of shape (n_samples, n_features)
        y : ignored
        sample_weight : array_like of shape (n_samples,), optional

        Returns
        -------
        float
        """
        checked = self._checked(X)
        weights = _checks.sample_weights(sample_weight, len(checked))
        squares = ((checked - self.cluster_centers_[self.predict(checked)]) ** 2).sum(axis=1)
        return -float(squares.sum() if weights is None else squares @ weights)

    def get_feature_names_out(self, input_features: Any = None) -> Array:
        """Names of the columns that :meth:`transform` gives.

        Parameters
        ----------
        input_features : ignored

        Returns
        -------
        ndarray of str, shape (n_clusters,)
        """
        self._require_fit()
        name = type(self).__name__.lower()
        return np.array([f"{name}{k}" for k in range(len(self.cluster_centers_))], dtype=object)

    def _predicts_by_weight(self) -> bool:
        if self.predict_by not in ("weight", "nearest"):
            raise ValueError(f"predict_by: is {self.predict_by!r}, but must be weight or nearest")
        return self.predict_by == "weight"

    def _require_fit(self) -> None:
        if not hasattr(self, "cluster_centers_"):
            raise NotFittedError(
                f"This {type(self).__name__} instance is not fitted yet. Call 'fit' with appropriate "
                "arguments before using this estimator."
            )

    def _checked(self, X: Any, fitting: bool = False) -> Array:
        """Samples as the library takes them; messages are as scikit-learn has them."""
        if not fitting:
            self._require_fit()
        if hasattr(self, "_check_feature_names"):
            self._check_feature_names(X, reset=fitting)
        checked = _checks.samples(X)
        if fitting:
            self.n_features_in_ = checked.shape[1]
        elif checked.shape[1] != self.n_features_in_:
            raise ValueError(
                f"X has {checked.shape[1]} features, but {type(self).__name__} is expecting "
                f"{self.n_features_in_} features as input"
            )
        return checked

    def _seed(self) -> int:
        state = self.random_state
        if state is None:
            return int.from_bytes(os.urandom(8), "little")
        if isinstance(state, np.random.RandomState):
            return int(state.randint(2**31 - 1))
        if isinstance(state, np.random.Generator):
            return int(state.integers(2**63))
        return _checks.whole("random_state", state, 0, 2**64 - 1)

    def _threads(self) -> int:
        if self.n_jobs is None:
            return 0
        jobs = _checks.whole("n_jobs", self.n_jobs, -4096, 4096)
        if jobs == 0:
            raise ValueError("n_jobs: is 0, but must be None, a number of threads, or negative")
        return jobs if jobs > 0 else max(1, _processors() + 1 + jobs)
