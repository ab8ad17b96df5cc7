"""A run on its way: marched in the stretches of its length, judged at the end of each."""

import math
from collections.abc import Sequence

from slipwave.observe import EventObserver, Verdict, judge_motion, slides_at
from slipwave.solve import Final, Mark, Observer, Solver, follow
from slipwave.solve.checkpoint import Checkpoints
from slipwave.solve.foresight import Foresight, require_time
from validation.run.advice import Advice
from validation.run.length import Ended, Judged, Length, second_half
from validation.run.progress import progress


class Course:
    """A run of `solver` over a `length`. After `march`, or after what it raised, `until` is the end of the last stretch begun
    (transits), `final` the state there and `ended` the reason, both None if it was not reached.

    A scene that records nothing is not watched for events. No stretch is begun that would take more than `most_seconds`.
    """

    def __init__(
        self,
        solver: Solver,
        length: Length,
        watch: EventObserver,
        observers: Sequence[Observer],
        marks: Sequence[Mark],
        most_seconds: float,
    ) -> None:
        self.solver, self.watch = solver, watch
        self.until = 0.0
        self.final: Final | None = None
        self.ended: Ended | None = None
        self._length, self._marks, self._most = length, marks, most_seconds
        self._watched = bool(solver.scene.record)
        self._work = Foresight(solver, 0.0, most_seconds)
        self._observers = [*([watch] if self._watched else []), *observers, self._work]

    def march(self) -> None:
        """To the end. Raises NumericsError where the solver fails, and SceneError if it would take too long."""
        for end in self._length.ends(self.solver.time):
            if self._work.seconds(end) > self._length.most_seconds:
                break
            self._stretch(end)
            self.ended = self._length.ended(self.judged())
            if self.ended:
                return
        self.ended = "limit"

    def _stretch(self, end: float) -> None:
        require_time(self.solver, end, self._most)
        self.until, self.final = end, None
        self._work.until = end
        for mark in self._marks:
            if isinstance(mark, Checkpoints):
                mark.until = end
        with progress(f"{self.solver.scene.name}, {self.solver.model}", end) as report:
            advice = Advice(self.solver, end)

            def reached(done: float) -> None:
                report(done)
                advice(done)

            self.final = follow(self.solver, end, self._observers, reached, self._marks)

    def judged(self) -> Judged:
        """The second half of what was run so far, and the verdict on it."""
        half = second_half(self.solver, self.until)
        return Judged(2.0 * half, self._verdict(half) if self._watched else None, self.watch.events(half))

    def _verdict(self, half: float) -> Verdict:
        """On the second half of what was run, which begins at `half` (transits)."""
        drive, end = self.solver.scene.drive, 2.0 * half
        slides = self.final is not None and slides_at(math.exp(self.final.ln_v), drive.at(end))
        return judge_motion(self.watch.events(half), self.watch.judge(half).complete, drive.rests_from(half), slides, end)
