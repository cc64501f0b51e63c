"""Many renders from one job file."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from . import _sunstone
from ._errors import RenderWarning


class Result(NamedTuple):
    """What has become of a job."""

    #: Its place among the jobs of the file, from 0; this is no tuple to be searched.
    index: int  # type: ignore[assignment]
    #: What it is called; the jobs of a sweep share it.
    name: str
    #: The values of the sweep, by the names of its axes.
    values: dict[str, Any]
    #: Where the image is, as a path from the current folder.
    output: str
    #: Why there is no image, if there is none.
    error: str | None
    #: How long it took, from its scene to its file; None if it has not been rendered.
    seconds: float | None
    #: The SHA-256 of the image's file, or of its files in turn.
    checksum: str | None
    #: Whether it had been done before this batch began.
    was_done: bool
    #: What there is to doubt about the image, and of the scene what is not rendered as described.
    warnings: tuple[str, ...]


class Batch(Iterator[Result]):
    """A batch on its way: its results, as jobs end. What `batch` returns.

    It begins with the first result that is asked for. `close`, the end of a `with` block, or
    nothing that refers to it any more ends it: jobs in work are dropped, and a batch that is
    started again does them.
    """

    def __init__(
        self,
        native: _sunstone.Batch,
        threads: int | None,
        progress: Callable[[int, int], object] | None,
        dry_run: bool,
    ) -> None:
        self._native: _sunstone.Batch | None = native
        self._threads = threads
        self._progress = progress
        self._dry_run = dry_run
        #: Results that need not be waited for.
        self._known: Iterator[Any] | None = None
        self._said: set[str] = set()
        #: A result with warnings that somebody has made errors of.
        self._held: Result | None = None

    def __iter__(self) -> Batch:
        return self

    def __next__(self) -> Result:
        result = self._held or self._taken()
        self._held = result
        for text in result.warnings:
            if text not in self._said:
                self._said.add(text)
                about = f"job {result.index} \"{result.name}\": {text.removeprefix('warning: ')}"
                warnings.warn(about, RenderWarning, stacklevel=2)
        self._held = None
        return result

    def _taken(self) -> Result:
        """The next result."""
        if self._native is None:
            raise StopIteration
        if self._known is None:
            self._known = iter(())
            native, options = self._native, {"threads": self._threads}
            self._known = iter(native.look() if self._dry_run else native.begin(options))
        row = next(self._known, None)
        if row is None and not self._dry_run:
            row = self._native.next(self._progress)
        if row is None:
            self._native = None
            raise StopIteration
        return Result(*row)

    def close(self) -> None:
        """Ends it, and waits for that."""
        native, self._native = self._native, None
        if native is not None:
            native.close()

    def __enter__(self) -> Batch:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        # One that could not be made has nothing.
        if getattr(self, "_native", None) is not None:
            self.close()


def batch(
    jobs: str | os.PathLike[str],
    *,
    results: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    allow_outside: bool = False,
    dry_run: bool = False,
    progress: Callable[[int, int], object] | None = None,
) -> Batch:
    """Renders all that a job file asks for and that has not been done: what `sunstone batch` does.

    >>> for result in sunstone.batch("jobs.toml"):
    ...     print(result.name, result.values, result.output, result.error)

    First come the jobs that were done before, and then others as they end, each with its error if
    it has failed. The interpreter is free meanwhile; Ctrl-C ends the batch with KeyboardInterrupt.

    Args:
        jobs: the job file, .toml or .jsonl.
        results: where it is noted what has been done; results.jsonl beside the job file by default.
        threads: threads for all jobs together, one for every processor by default.
        allow_outside: let scenes read, and jobs write, files outside their folders.
        dry_run: render nothing: the results are what is done, and, without seconds, what is not.
        progress: called in this thread now and then, while a result is waited for, with the samples
            of all images that are done and those in all; if it returns False, the batch ends with
            what is done. What it raises ends the batch.

    Raises:
        OSError: if the job file cannot be read; and in the end, if results could not be noted.
        Error: if the job file is wrong, with all that is; nothing is rendered then. If another
            batch is at work on the same results.

    Warns:
        RenderWarning: of what there is to doubt about images and scenes, once each, and of results
            that cannot be read and parts of images that tasks have left.
    """
    where = None if results is None else os.fspath(results)
    native = _sunstone.Batch(os.fspath(jobs), where, allow_outside)
    return Batch(native, threads, progress, dry_run)
