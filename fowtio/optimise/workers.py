"""Who evaluates the designs: this process's threads, or a Dask cluster; the same chunks either way, so the same results."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from fowtio.errors import ModelError


@contextmanager
def workers(jobs: int = 1, cluster: str | None = None) -> Iterator[Callable]:
    """Give a function that maps another over chunks of designs, in order.

    jobs threads of this process, each with one thread of linear algebra; or the workers of a Dask cluster by its address. Raises
    ModelError when a library is not installed or the cluster does not answer.
    """
    try:
        from joblib import Parallel, delayed, parallel_config
        from threadpoolctl import threadpool_limits
    except ImportError as error:
        raise ModelError(f'sharing the work needs joblib and threadpoolctl ({error}); install them with: pip install "fowtio[design]"') from None

    def spread(judge, chunks):
        return Parallel()(delayed(judge)(chunk) for chunk in chunks)

    with threadpool_limits(1):
        if cluster is None:
            with parallel_config("threading", n_jobs=jobs):
                yield spread
            return
        with _client(cluster), parallel_config("dask"):
            yield spread


@contextmanager
def _client(address: str):
    try:
        from dask.distributed import Client
    except ImportError:
        raise ModelError('a Dask cluster needs dask; install it with: pip install "fowtio[cluster]"') from None
    try:
        client = Client(address, timeout=5)
    except (OSError, ValueError) as error:
        raise ModelError(f"no Dask cluster at {address}: {error}") from None
    with client:
        client.run(_one_thread)
        yield client


def _one_thread() -> None:
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)
