"""BalancedKMeans: what it promises, and scikit-learn's own checks."""

import pickle
import subprocess
import sys

import numpy as np
import pytest

import ccvt
from ccvt import BalancedKMeans

# Of scikit-learn's checks, those that are not passed, and why.
NOT_PASSED = {
    "check_sample_weights_invariance{'kind': 'zeros'}": "compares with the same samples in another "
    "order, by the numbers of the clusters, which depend on it; scikit-learn's KMeans does not pass it "
    "either",
    "check_sample_weights_not_overwritten": "one of 16 samples has the weight of three clusters: no "
    "balanced clusters exist, which an error says",
}


@pytest.fixture
def X():
    return np.random.default_rng(3).normal(size=(600, 5))


def test_clusters_are_equal_and_centred(X):
    model = BalancedKMeans(7, random_state=1).fit(X)
    counts = np.bincount(model.labels_)
    assert counts.max() - counts.min() <= 1
    for k in range(7):
        assert np.allclose(model.cluster_centers_[k], X[model.labels_ == k].mean(axis=0))
    squares = ((X - model.cluster_centers_[model.labels_]) ** 2).sum()
    assert np.isclose(model.inertia_, squares)
    assert model.gap_ < 1e-9 and model.n_iter_ > 0 and model.termination_ == "stable"


def test_weights_prove_the_assignment(X):
    """Each sample's own cluster is the cheapest by weight, up to rounding: predict gives labels_."""
    model = BalancedKMeans(7, random_state=1).fit(X)
    costs = ((X[:, None] - model.cluster_centers_) ** 2).sum(axis=2) - model.weights_
    own = costs[np.arange(len(X)), model.labels_]
    assert (own - costs.min(axis=1)).max() < 1e-6
    assert np.mean(model.predict(X) == model.labels_) > 0.98  # those on borders may differ


def test_predict_by_nearest(X):
    model = BalancedKMeans(7, random_state=1, predict_by="nearest").fit(X)
    distances = model.transform(X)
    assert np.array_equal(model.predict(X), distances.argmin(axis=1))
    assert np.isclose(model.score(X), -((distances.min(axis=1)) ** 2).sum())
    direct = np.sqrt(((X[:, None] - model.cluster_centers_) ** 2).sum(axis=2))
    assert np.allclose(distances, direct)


def test_attributes_of_any_layout(X):
    model = ccvt.BalancedKMeans(7, random_state=0).fit(X)
    expected = model.predict(X)
    model.cluster_centers_ = np.asfortranarray(model.cluster_centers_)
    model.weights_ = np.repeat(model.weights_, 2)[::2]
    assert np.array_equal(model.predict(X), expected)


def test_equal_samples_get_equal_labels(X):
    model = ccvt.BalancedKMeans(4, random_state=0, predict_by="nearest").fit(X)
    model.cluster_centers_ = np.array([[0.0] * X.shape[1], [2.0] * X.shape[1]])
    model.weights_ = np.zeros(2)
    assert model.predict(np.ones((9, X.shape[1]))).tolist() == [0] * 9


def test_capacities(X):
    capacities = [300, 200, 100]
    model = BalancedKMeans(3, random_state=1, capacities=capacities).fit(X)
    assert np.bincount(model.labels_).tolist() == capacities


def test_random_state_and_threads(X):
    first = BalancedKMeans(5, random_state=3, n_jobs=1).fit(X)
    for jobs in [2, -1, None]:
        again = BalancedKMeans(5, random_state=3, n_jobs=jobs).fit(X)
        assert np.array_equal(first.cluster_centers_, again.cluster_centers_)
    for state in [np.random.RandomState, np.random.default_rng]:
        one = BalancedKMeans(5, random_state=state(4)).fit(X)
        same = BalancedKMeans(5, random_state=state(4)).fit(X)
        assert np.array_equal(one.cluster_centers_, same.cluster_centers_)
    assert BalancedKMeans(5).fit(X).cluster_centers_.shape == (5, 5)


@pytest.mark.parametrize("method", ["exact", "pairwise", "lloyd"])
@pytest.mark.parametrize("init", ["k-means++", "random", "array"])
def test_methods_and_starts(X, method, init):
    start = X[:6] if init == "array" else init
    model = BalancedKMeans(6, random_state=1, method=method, init=start).fit(X)
    counts = np.bincount(model.labels_, minlength=6)
    assert (counts == 100).all() == (method != "lloyd")
    assert np.any(model.weights_ != 0) == (method == "exact")
    assert model.n_iter_ > 0


def test_sample_weight(X):
    weight = np.random.default_rng(1).random(len(X))
    model = BalancedKMeans(6, random_state=1).fit(X, sample_weight=weight)
    masses = np.bincount(model.labels_, weight)
    assert np.abs(masses - weight.sum() / 6).max() < weight.max()
    for k in range(6):
        own = model.labels_ == k
        assert np.allclose(model.cluster_centers_[k], np.average(X[own], axis=0, weights=weight[own]))
    squares = ((X - model.cluster_centers_[model.labels_]) ** 2).sum(axis=1)
    assert np.isclose(model.inertia_, squares @ weight)
    assert np.isnan(model.gap_)


def test_equal_sample_weights_count_as_none(X):
    plain = BalancedKMeans(6, random_state=1).fit(X)
    weighted = BalancedKMeans(6, random_state=1).fit(X, sample_weight=np.full(len(X), 2.5))
    assert np.array_equal(plain.labels_, weighted.labels_)
    assert np.isclose(weighted.inertia_, 2.5 * plain.inertia_)


def test_weight_zero_is_as_if_left_out(X):
    weight = np.ones(len(X))
    weight[::3] = 0
    model = BalancedKMeans(6, random_state=1).fit(X, sample_weight=weight)
    plain = BalancedKMeans(6, random_state=1).fit(X[weight > 0])
    assert np.array_equal(model.cluster_centers_, plain.cluster_centers_)
    assert np.array_equal(model.labels_[weight > 0], plain.labels_)
    nearest = model.transform(X[::3]).argmin(axis=1)
    assert np.array_equal(model.labels_[::3], nearest)


def test_refused_sample_weights(X):
    for weight, text in [(-1, "entry 0 is -1.0"), (np.nan, "entry 0 is nan"), (0, "0 are above 0")]:
        with pytest.raises(ValueError, match=f"sample_weight: {text}"):
            BalancedKMeans(3).fit(X, sample_weight=np.full(len(X), weight))
    heavy = np.ones(len(X))
    heavy[7] = 400
    with pytest.raises(ValueError, match=r"sample_weight\[7\] is 400.*capacity"):
        BalancedKMeans(3).fit(X, sample_weight=heavy)
    with pytest.raises(ValueError, match="init: an array cannot be given with sample_weight"):
        BalancedKMeans(3, init=X[:3]).fit(X, sample_weight=np.arange(len(X)))


def test_names_of_arguments(X):
    model = BalancedKMeans(3, random_state=1).fit(X)
    far = X.copy()
    far[5, 2] = 1e200
    for refused in (BalancedKMeans(3).fit, model.predict):
        with pytest.raises(ValueError, match=r"^X: coordinate 2 of X\[5\] is 1e\+200"):
            refused(far)

    class Own(ValueError):
        pass

    def stop(_):
        raise Own("points: mine")

    with pytest.raises(ValueError, match="mine") as raised:
        BalancedKMeans(3, progress=stop).fit(X)
    assert raised.type is Own


def test_pickle_and_clone(X):
    model = BalancedKMeans(6, random_state=1).fit(X)
    copy = pickle.loads(pickle.dumps(model))
    assert np.array_equal(copy.predict(X), model.predict(X))
    assert copy.get_params() == model.get_params()


@pytest.mark.parametrize("parameters, text", [
    ({"n_clusters": 0}, "n_clusters: is 0"),
    ({"n_clusters": 601}, "n_samples=600, but must be at least n_clusters=601"),
    ({"method": "fast"}, "method: is 'fast', but must be one of exact, pairwise, lloyd"),
    ({"init": "best"}, "init: is 'best', but must be one of k-means"),
    ({"init": np.zeros((2, 5))}, r"init: has the shape \(2, 5\), but must be \(8, 5\)"),
    ({"capacities": [1, 2]}, "capacities"),
    ({"capacities": [75] * 8, "method": "lloyd"}, "capacities: method='lloyd' does not keep any"),
    ({"n_init": 0}, "n_init: is 0"),
    ({"effort": -1}, "effort: is -1"),
    ({"max_iter": -1}, "max_iter: is -1"),
    ({"tol": 1.0}, "tol"),
    ({"gap": 1.0}, "gap"),
    ({"train_sample": 0}, "train_sample: is 0"),
    ({"train_sample": 5}, "train_sample"),
    ({"train_sample": 100, "method": "lloyd"}, "train_sample is 100: it must be 0 but for exact"),
    ({"n_jobs": 0}, "n_jobs: is 0"),
    ({"predict_by": "x"}, "predict_by: is 'x'"),
    ({"random_state": -1}, "random_state: is -1"),
])  # fmt: skip
def test_refused(X, parameters, text):
    with pytest.raises(ValueError, match=text):
        BalancedKMeans(**parameters).fit(X)


def test_refused_samples(X):
    model = BalancedKMeans(3)
    for bad, text in [(X[:, 0], "Reshape your data"), (X[:0], "0 sample"), (X[:, :0], "0 feature"),
                      (X * np.nan, "NaN")]:  # fmt: skip
        with pytest.raises(ValueError, match=text):
            model.fit(bad)
    with pytest.raises(ValueError, match="not fitted yet"):
        model.predict(X)
    with pytest.raises(ValueError, match="X has 2 features, but BalancedKMeans is expecting 5"):
        model.fit(X).predict(X[:, :2])
    with pytest.raises(ValueError, match=r"sample_weight: has the shape \(3,\)"):
        model.fit(X, sample_weight=[1, 2, 3])


def test_scikit_learns_checks():
    """Its whole suite; checks that it skips, for want of pandas, are said by name."""
    from sklearn.utils.estimator_checks import check_estimator

    failed = {}
    ran = 0
    for estimator, check in check_estimator(BalancedKMeans(), generate_only=True):
        name = getattr(check, "func", check).__name__
        keywords = getattr(check, "keywords", {})
        try:
            check(estimator)
            ran += 1
        except Exception as error:  # noqa: BLE001: whatever a check raises is a failure
            if type(error).__name__ == "SkipTest":
                print("skipped:", name, error)
                continue
            failed[f"{name}{keywords or ''}"] = error
    print(f"{ran} checks passed, {len(failed)} did not")
    assert set(failed) == set(NOT_PASSED), failed
    assert ran >= 35 and len(NOT_PASSED) <= 3


def test_in_a_pipeline(X):
    from sklearn.base import clone
    from sklearn.model_selection import GridSearchCV
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    pipeline = make_pipeline(StandardScaler(), BalancedKMeans(4, random_state=0))
    assert np.bincount(pipeline.fit_predict(X)).tolist() == [150] * 4
    search = GridSearchCV(BalancedKMeans(random_state=0), {"n_clusters": [2, 5]}, cv=2).fit(X)
    assert search.best_params_ == {"n_clusters": 5}
    assert clone(search.best_estimator_).get_params() == search.best_estimator_.get_params()


WITHOUT = """
import sys
sys.modules["sklearn"] = None
import numpy as np
import ccvt
from ccvt import BalancedKMeans
X = np.random.default_rng(3).normal(size=(600, 5))
model = BalancedKMeans(6, random_state=1)
assert repr(model) == "BalancedKMeans(n_clusters=6, random_state=1)", repr(model)
assert "method" in model.get_params()
labels = model.fit_predict(X)
assert np.bincount(labels).tolist() == [100] * 6
assert model.set_params(n_clusters=3).n_clusters == 3
assert model.fit_transform(X).shape == (600, 3)
try:
    model.set_params(clusters=3)
except ValueError as error:
    assert "Invalid parameter 'clusters'" in str(error)
else:
    sys.exit("set_params takes anything")
try:
    BalancedKMeans().predict(X)
except ValueError as error:
    assert "not fitted yet" in str(error)
else:
    sys.exit("predict before fit")
import pickle
assert (pickle.loads(pickle.dumps(model)).labels_ == model.labels_).all()
print(*labels)
"""


def test_without_scikit_learn(X):
    run = subprocess.run([sys.executable, "-c", WITHOUT], check=True, capture_output=True, text=True)
    expected = BalancedKMeans(6, random_state=1).fit_predict(X)
    assert np.array_equal(np.array(run.stdout.split(), dtype=int), expected)


def test_import_is_light():
    code = "import sys, ccvt; assert 'sklearn' not in sys.modules and 'tqdm' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
    assert ccvt.BalancedKMeans is BalancedKMeans


@pytest.mark.parametrize("weights", [None, "given"])
def test_what_progress_raises_passes_as_it_is(X, weights):
    error = ValueError("points: of the user")

    def raising(record):
        raise error

    weight = None if weights is None else np.random.default_rng(1).random(len(X))
    with pytest.raises(ValueError) as caught:
        BalancedKMeans(4, progress=raising).fit(X, sample_weight=weight)
    assert caught.value is error and str(error) == "points: of the user"


@pytest.mark.parametrize("weights", [None, "given"])
def test_a_fit_that_fails_leaves_the_last_one(X, weights):
    weight = None if weights is None else np.random.default_rng(1).random(len(X))

    def interrupting(record):
        raise KeyboardInterrupt

    model = BalancedKMeans(4, random_state=1).fit(X)
    before, labels = dict(vars(model)), model.predict(X)
    for wider, arguments in [(X[:, :3], {"progress": interrupting}), (X[:2], {"progress": None})]:
        with pytest.raises((KeyboardInterrupt, ValueError)):
            model.set_params(**arguments).fit(wider, sample_weight=weight)
        assert model.n_features_in_ == 5
        assert np.array_equal(model.predict(X), labels)
    assert all(vars(model)[name] is before[name] for name in before)
    unfitted = BalancedKMeans(4)
    with pytest.raises(ValueError):
        unfitted.fit(X[:2])
    assert not hasattr(unfitted, "n_features_in_")


def test_time_limit():
    points = np.random.default_rng(3).normal(size=(4000, 3))
    soon = BalancedKMeans(40, random_state=1, time_limit=1e-9)
    model = soon.fit(points)
    assert model.termination_ == "time_limit"
    assert (np.bincount(model.labels_) == 100).all()
    with pytest.raises(RuntimeError, match="cancelled"):
        soon.fit(points, sample_weight=np.linspace(1, 2, 4000))
    assert BalancedKMeans(40, random_state=1, time_limit=1e6).fit(points).termination_ == "stable"
    with pytest.raises(ValueError, match="time_limit"):
        BalancedKMeans(40, time_limit=-1).fit(points)
