"""Fields along x: numbers, functions of x, expressions, tables, and files of tables with units."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial, reduce
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from semianalytic.scene.arguments import checking, floats_of
from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.checks import finite, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.alike import Alike
from semianalytic.scene.laws.sampling import sampled

if TYPE_CHECKING:
    from semianalytic.scene.tables.columns import Column


_ANY_NUMBER = 0
_FUNCTIONS: Mapping[str, tuple[Callable[..., Any], int]] = {
    **{name: (getattr(np, name), 1) for name in ("abs", "exp", "log", "sqrt", "sin", "cos", "tan")},
    "tanh": (np.tanh, 1),
    "min": (np.minimum, _ANY_NUMBER),
    "max": (np.maximum, _ANY_NUMBER),
    "where": (np.where, 3),
}
"""Functions of expressions, and how many arguments each takes: two or more, of two at a time, where
any number is taken.  A further argument of numpy's own functions would be their `out`."""
_OPERATORS: Mapping[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
RESERVED = ("x", "t", "pi", "factor", *_FUNCTIONS)
"""Names that have a meaning in expressions."""
DEEPEST = 250
"""Levels of an expression.  Each takes a call within another, of which Python allows a thousand."""


@dataclass(frozen=True, eq=False)
class Table(Alike):
    """A quantity given at positions x, linear between them; a position given twice is a jump.

    Parameters
    ----------
    x : (n,) array
        Positions [length], in increasing order.
    values : (n,) array
        Values there.

    Raises
    ------
    SceneError
        If positions decrease, lengths differ, or a number is not finite.

    Examples
    --------
    >>> from semianalytic import Table
    >>> Table([0.0, 1.0, 1.0, 2.0], [1.0, 2.0, 5.0, 5.0])([0.5, 1.5]).tolist()
    [1.5, 5.0]
    """

    x: Any
    values: Any

    def __post_init__(self) -> None:
        for name in ("x", "values"):
            given = floats_of(getattr(self, name))
            if given is None or given.ndim != 1 or len(given) < 2 or not np.isfinite(given).all():
                raise SceneError(f"table: {name} must be two or more finite numbers.")
            object.__setattr__(self, name, given.copy())  # the caller keeps its own
        if len(self.x) != len(self.values) or not (np.diff(self.x) >= 0).all():
            raise SceneError("table: x must increase and be as long as values.")

    def __call__(self, x: Any) -> Array:
        """Return the values at positions x; nan beyond the first and the last one."""
        return np.interp(np.asarray(x, float), self.x, self.values, left=math.nan, right=math.nan)

    @classmethod
    @checking
    def read(cls, path: str | PathLike[str], column: str = "") -> Table:
        """Read a table from a file with a header such as ``x [km], pressure [MPa]``.

        Parameters
        ----------
        path : str or path
            The file.  Its first column is x; units are in brackets, after _ (pressure_MPa) or in a
            row of their own below the names.
        column : str, optional
            Name of the column that holds the values, with or without its unit; the second one by
            default.

        Raises
        ------
        SceneError
            If the file cannot be read, or a number or a unit is not known.
        """
        from semianalytic.scene.tables.columns import Tables  # most scenes read no table

        return cls.of_columns(path, *Tables().pair(path, column))

    @classmethod
    def of_columns(cls, path: str | PathLike[str], along: Column, column: Column) -> Table:
        """Return the table of two columns of a file, as `read` does."""
        from semianalytic.scene.tables.units import EXAMPLES

        x, values = along.numbers(path, ("length",)), column.numbers(path, EXAMPLES)
        if len(x) < 2:
            raise SceneError(f"{path}: a table must have a header and two lines or more.")
        return cls(x, values)


@dataclass(frozen=True, eq=False)
class Scaled(Alike):
    """A field, or a function of time, times a factor.

    Parameters
    ----------
    field : function or Table
        Field that is multiplied.
    factor : float
        The factor.
    """

    field: Any
    factor: float

    def __call__(self, *values: Any) -> Any:
        """Return the product at arguments, as the field itself would take them."""
        return self.factor * np.asarray(self.field(*values), dtype=float)


Field = float | Callable[[Array], Any] | Table
"""A number, a function of x (n,) that returns (n,), or a `Table`."""


def check_field(what: str, field: Any) -> None:
    """Raise SceneError unless a field is a number, a function or a `Table`."""
    if finite(field) is None and not callable(field):
        raise SceneError(
            f"{what} must be a number, a function of x or a Table, got {shown(field)}."
        )


def at_nodes(what: str, field: Any, x: Array, where: Mask, spacing: float = 0.0) -> Array:
    """Return a field at the nodes (n,) of a mask, 0 at the others; see `sampled`."""
    values = np.zeros(len(x))
    values[where] = sampled(what, field, x[where], spacing)
    return values


def required(what: str, values: Array, admitted: Sequence[Any] | Any, words: str, x: Array) -> None:
    """Raise SceneError with the first position at which a sampled field is not admitted."""
    wrong = ~np.asarray(admitted)
    if wrong.any():
        first = int(np.argmax(wrong))
        raise SceneError(f"{what} must {words}, got {values[first]:.6g} at x = {x[first]:.4g}.")


_Part = Callable[[Mapping[str, Any]], Any]
"""A part of an expression, as a function of what its names stand for."""


def _joined(combined: Callable[..., Any], *parts: _Part) -> _Part:
    """Return the function that combines the values of one, two or more parts."""
    if len(parts) == 1:
        (only,) = parts
        return lambda known: combined(only(known))
    if len(parts) == 2:
        first, second = parts
        return lambda known: combined(first(known), second(known))
    return lambda known: combined(*(part(known) for part in parts))


def _levels(tree: ast.AST) -> int:
    """Return how many nodes of a syntax tree lie within one another."""
    levels, nodes = 0, [tree]
    while nodes:
        levels += 1
        nodes = [child for node in nodes for child in ast.iter_child_nodes(node)]
    return levels


class Expression:
    """A function given as text: numbers, + - * / **, comparisons, and a few functions of numpy.

    Parameters
    ----------
    text : str
        The expression, such as "where(abs(x) < 1, 0.6, 0.2)".
    variables : tuple of str
        Names of the arguments, in order.
    numbers : mapping of name to number, optional
        Numbers that the expression may name; of these it keeps those that it does.

    Raises
    ------
    SceneError
        If it contains anything else.
    """

    def __init__(
        self,
        text: str,
        variables: tuple[str, ...],
        numbers: Mapping[str, float] | None = None,
    ) -> None:
        self.text, self.variables = text, variables
        self.numbers: dict[str, float] = {}
        try:
            # Longer expressions belong in a table or a script.
            tree = ast.parse(" ".join(text.split()), mode="eval") if len(text) <= 2000 else None
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            tree = None
        if tree is None:
            raise SceneError(f"{shown(text)} is not an expression such as 1 + 0.1 * exp(-x**2).")
        if _levels(tree) > DEEPEST:
            raise SceneError(
                f"{shown(text)} has more than {DEEPEST} operations within one another; give a "
                "table or a shorter expression."
            )
        names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        self.numbers = {name: number for name, number in (numbers or {}).items() if name in names}
        self._value = self._part(tree.body)
        self(*(np.array([0.5]) for _ in variables))

    def __call__(self, *values: Any) -> Any:
        """Return the value at arguments, which broadcast; nan or inf where there is none."""
        known = {**self.numbers, **dict(zip(self.variables, values, strict=True))}
        # numbers of numpy divide by 0 and overflow to inf or nan, which fields refuse
        known = {key: np.float64(x) if np.ndim(x) == 0 else x for key, x in known.items()}
        with np.errstate(all="ignore"):
            return self._value(known)

    def with_numbers(self, numbers: Mapping[str, float]) -> Expression:
        """Return the expression with other values of some of the numbers that it names."""
        return Expression(self.text, self.variables, {**self.numbers, **numbers})

    def __repr__(self) -> str:
        return self.text

    def __reduce__(self) -> Any:
        return Expression, (self.text, self.variables, self.numbers)  # parts are closures

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and self.__reduce__() == other.__reduce__()

    def __hash__(self) -> int:
        return hash((self.text, self.variables))

    def _part(self, node: ast.AST) -> _Part:
        """Return the function that a part of the expression is, or raise SceneError.

        A history is asked for its value in each step of a run: nested functions take a third of
        the time of a walk through the tree.
        """
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                value = finite(number)
                constant = np.float64(np.inf if value is None else value)
                return lambda known: constant
            case ast.Name(id=name) if name in self.variables or name in self.numbers:
                return operator.itemgetter(name)
            case ast.Name(id="pi"):
                return lambda known: np.pi
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
                return _joined(_OPERATORS[type(op)], self._part(left), self._part(right))
            case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATORS:
                return _joined(_OPERATORS[type(op)], self._part(operand))
            case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in _OPERATORS:
                holds = _joined(_OPERATORS[type(op)], self._part(left), self._part(right))
                # a number, because the sum of two truth values of numpy is 1 where both hold
                return lambda known: 1.0 * holds(known)
            case ast.Call(func=ast.Name(id=name), args=given, keywords=[]) if name in _FUNCTIONS:
                combined, count = _FUNCTIONS[name]
                if len(given) < 2 if count == _ANY_NUMBER else len(given) != count:
                    takes = count or "two or more"
                    raise SceneError(
                        f"{shown(self.text)}: {name} takes {takes} argument{'s'[: count != 1]}, "
                        f"got {len(given)}."
                    )
                parts = [self._part(part) for part in given]
                if count == _ANY_NUMBER:
                    return reduce(partial(_joined, combined), parts)
                return _joined(combined, *parts)
        raise SceneError(
            f"{shown(self.text)}: {ast.unparse(node)} is not known here; use "
            f"{', '.join((*self.variables, *self.numbers))}, pi, + - * / **, < > <= >=, "
            f"{', '.join(_FUNCTIONS)}."
        )
