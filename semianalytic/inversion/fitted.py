"""The result of a fit: values of parameters, their uncertainty, and their probability."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.inversion.gauges import Gauge
from semianalytic.inversion.quoted import Quoted, quoted
from semianalytic.inversion.samples import Samples
from semianalytic.inversion.trials import Trials
from semianalytic.inversion.unknowns import Setup
from semianalytic.results.in_words import html_table
from semianalytic.results.reading import Measured
from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution


@checking_methods
@dataclass(frozen=True, eq=False)
class Fit:
    """The parameters that fit gauge records best, with their uncertainty.

    Attributes
    ----------
    parameters : tuple of str
        Names of the parameters.
    values : (p,) array
        Estimates, in the units of the scene.
    covariance : (p, p) array
        Covariance of the estimates due to noise and, for a march, due to the error of its grid at
        the gauges, which is estimated from a march on twice the nodes; infinite for parameters that
        the data do not constrain.
    interval : (p, 2) array
        Lower and upper end of the confidence interval of each value, at which chi2, minimised over
        the other values, exceeds its minimum by one; the error of the grid is added.  If chi2 is a
        parabola, this is one standard error to either side; an end is infinite if the data do not
        bound it.
    chi2 : float
        Sum of squares of the misfits over the noise, and over the widths of priors.
    freedom : int
        Number of samples and priors minus the number of parameters; chi2 is about as large if the
        noise is stated correctly.
    unconstrained : tuple of str
        Parameters that the data do not constrain, alone or together.
    status : str
        "converged", or a sentence on what is unreliable. It also says so if the misfits, or the
        distances of estimates from their priors, would occur in only one fit in a million.
    solution : Solution
        Solution of the scene with these parameters; for a scene that is marched, `solution.run` is
        the march.
    setup : Setup
        Set-up of the gauges with these parameters.
    gauges : tuple of Gauge
        The records.
    minima : (m, p) array
        Values at all minima that the search found, the lowest first.
    chi2_of_minima : (m,) array
        chi2 at these minima.
    derivative_error : float
        Relative error of the finite-difference derivatives that gauges in the bodies require; 0 if
        there are none.
    solutions : int
        Number of solutions that were computed individually; those of `sweep` are not counted.
    trials : Trials
        Misfits of any values.

    Examples
    --------
    >>> import numpy as np
    >>> from semianalytic import Gauge, Normal, find, fit, solve
    >>> scene, t = find("antiplane"), np.linspace(0.3, 1.5, 5)
    >>> record = Gauge(x=0.2, t=t, values=solve(scene).slip(0.2, t), noise=1e-3, quantity="slip")
    >>> found = fit([record], scene, "friction", priors={"friction": Normal(0.5, 0.1)})
    >>> found.status, found.freedom, bool(found.standard_errors[0] < 0.002)
    ('converged', 5, True)
    """

    parameters: tuple[str, ...]
    values: Array
    covariance: Array
    interval: Array
    chi2: float
    freedom: int
    unconstrained: tuple[str, ...]
    status: str
    solution: Solution
    setup: Setup
    gauges: tuple[Gauge, ...]
    minima: Array
    chi2_of_minima: Array
    derivative_error: float
    solutions: int
    trials: Trials = field(repr=False)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} {self.values[number]:.5g} {self.error_in_words(number)}"
            for number, name in enumerate(self.parameters)
        )
        return f"<Fit: {values}; chi2 {self.chi2:.4g} of {self.freedom}; {self.status}>"

    def _repr_html_(self) -> str:
        rows = [
            (name, f"{self.values[number]:.6g}", self.error_in_words(number))
            for number, name in enumerate(self.parameters)
        ]
        caption = f"Fit: chi2 {self.chi2:.4g} of {self.freedom}; {self.status}"
        return html_table(caption, ("parameter", "value", "error"), rows)

    def error_in_words(self, number: int, factor: float = 1.0) -> str:
        """Return the error of a value as text, with two sides where they differ.

        Parameters
        ----------
        number : int
            Place of the parameter.
        factor : float
            Factor by which the numbers are multiplied, for another unit.

        Returns
        -------
        str
            Such as "± 0.0031", "+0.06 -0.16" or "not constrained".
        """
        if not 0 <= number < len(self.values):
            raise SceneError(f"error_in_words: there is no parameter {number}.")
        error = float(self.standard_errors[number])
        if not np.isfinite(error):
            return "not constrained"
        below, above = np.abs(self.interval[number] - self.values[number])
        # Ends that were not sought apart are one standard error away, but for rounding.
        if max(abs(above - error), abs(below - error)) < 1e-6 * error:
            return f"± {error * factor:.2g}"
        return f"+{above * factor:.2g} -{below * factor:.2g}"

    @property
    def scene(self) -> Scene:
        """The scene with the fitted parameters; its period is infinite if that of the given scene
        was.
        """
        scene, lengthens = self.solution.scene, getattr(self.trials, "lengthens", False)
        return replace(scene, period=np.inf) if lengthens else scene

    @property
    def standard_errors(self) -> Array:
        """Standard deviations of the estimates, (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Array:
        """Correlations of the estimates, (p, p); nan where the data do not constrain them."""
        errors = self.standard_errors
        # Infinite over infinite: a parameter that the data do not constrain has no correlation.
        with np.errstate(invalid="ignore"):
            return np.asarray(self.covariance / np.outer(errors, errors))

    @property
    def next_minimum(self) -> float:
        """Difference of chi2 between the next minimum and the lowest; infinite without one."""
        above = self.chi2_of_minima[1:] - self.chi2_of_minima[0]
        return float(above[0]) if above.size else np.inf

    def log_density(self, values: ArrayLike) -> float:
        """Return the logarithm of the posterior density of the parameters, up to a constant.

        It is -chi2/2 of the records plus the logarithms of the densities of the priors; without a
        prior the density of a parameter is flat.  A sampler such as emcee takes it as it is.

        Parameters
        ----------
        values : (p,) array
            In the order of `parameters`, in the units of the scene.

        Returns
        -------
        float
            -inf outside the bounds of a parameter, and where the values give no admissible scene.

        Raises
        ------
        SceneError
            If there is not one value for each parameter.
        """
        trials, given = self.trials, np.asarray(values, dtype=float)
        if given.shape != self.values.shape:
            raise SceneError(
                f"log_density: give one value for each of {', '.join(self.parameters)}, got an "
                f"array of shape {given.shape}."
            )
        scaled, (low, high) = given / trials.sizes, trials.bounds
        if not np.all((scaled > low) & (scaled < high)):
            return -np.inf
        result = -float(np.sum(trials.misfit(scaled)[: len(trials.samples.t)] ** 2)) / 2
        for name, value in zip(self.parameters, given.tolist(), strict=True):
            if name in trials.priors:
                result += trials.priors[name].log_density(value)
        return result

    @property
    def residuals(self) -> tuple[Array, ...]:
        """Record minus fit for each gauge, in the units of its quantity."""
        return tuple(gauge.values - self.seen(gauge, gauge.t) for gauge in self.gauges)

    def seen(self, gauge: Gauge, t: Array) -> Array:
        """Return what a gauge would have recorded without noise at times (n,) of the records."""
        # The same code as in the fit, so that residuals are what was minimised.
        like = Samples((_silent(gauge, t),))
        return np.asarray(like.gain(self.setup) * like.of(self.solution, self.setup))

    def forecast(self, t: ArrayLike | None = None) -> tuple[Measured, ...]:
        """Return what each gauge would record without noise, with the errors of the fit.

        The errors are standard errors that follow from the covariance of the fitted values and do
        not include noise.

        Parameters
        ----------
        t : (n,) array, optional
            Times of the records [time], also later ones, for which a scene on a line is marched
            anew; by default those of each record.

        Returns
        -------
        tuple of Measured
            `value` and `error`, (n,) each, in the order of `gauges`.

        Raises
        ------
        SceneError
            If the times are not ascending numbers.
        """
        gauges = tuple(_silent(gauge, gauge.t if t is None else t) for gauge in self.gauges)
        trials, scaled = self.trials.asking(gauges, self.setup), self.values / self.trials.sizes
        slopes = trials.jacobian(scaled)[: len(trials.samples.t)]
        # misfits of a gauge without noise are what it would record
        values = trials.misfit(scaled)[: len(slopes)]
        parts = map(trials.samples.split, (values, self._deviations(slopes)))
        return tuple(Measured(*pair) for pair in zip(*parts, strict=True))

    @cached_property
    def quoted(self) -> Quoted:
        """Front speed, stress drop, fracture energy and the strength ratio S; this requires two
        solutions per parameter.
        """
        return quoted(self.trials, self.solution, self.setup, self._deviations)

    def _deviations(self, slopes: Array) -> Array:
        """Return standard deviations (n,) of what has these derivatives (n, p) over sizes."""
        sizes, free = self.trials.sizes, ~np.isfinite(self.standard_errors)
        known = np.where(np.isfinite(self.covariance), self.covariance, 0.0)
        squares = np.einsum("np,pq,nq->n", slopes, known / np.outer(sizes, sizes), slopes)
        found = np.sqrt(np.maximum(squares, 0.0))
        return np.where(np.any(slopes[:, free] != 0, axis=1), np.inf, found)


def _silent(gauge: Gauge, t: ArrayLike) -> Gauge:
    """Return a gauge at other times, whose values and noise do not matter."""
    t = np.asarray(t, dtype=float)
    return replace(gauge, t=t, values=np.zeros_like(t), noise=1.0)
