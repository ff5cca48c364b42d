"""Functions of x or t written in files, such as "1 + 0.1 * exp(-x**2)"."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError

_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    **{name: getattr(np, name) for name in ("exp", "log", "sqrt", "sin", "cos", "tan", "tanh")},
    **{"abs": np.abs, "min": np.minimum, "max": np.maximum, "where": np.where},
}
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
LONGEST = 2000
"""Characters of an expression; longer ones belong in a table or a script."""


class Expression:
    """A function given as text: numbers, + - * / **, comparisons, and a few functions of numpy.

    Parameters
    ----------
    text : str
        The expression, such as "where(abs(x) < 1, 0.6, 0.2)".
    variables : tuple of str
        Names of the arguments, in order.

    Raises
    ------
    SceneError
        If it contains anything else.
    """

    def __init__(self, text: str, variables: tuple[str, ...]) -> None:
        self.text, self.variables = text, variables
        try:
            tree = ast.parse(" ".join(text.split()), mode="eval") if len(text) <= LONGEST else None
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            tree = None
        if tree is None:
            raise SceneError(f"{shown(text)} is not an expression such as 1 + 0.1 * exp(-x**2).")
        self._body = tree.body
        with np.errstate(all="ignore"):
            self(*(np.array([0.5]) for _ in variables))

    def __call__(self, *values: Any) -> Any:
        """Return the value at arguments, which broadcast."""
        return self._value(self._body, dict(zip(self.variables, values, strict=True)))

    def __repr__(self) -> str:
        return self.text

    def _value(self, node: ast.AST, known: Mapping[str, Any]) -> Any:
        """Return the value of a part of the expression."""
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return float(number)
            case ast.Name(id=name) if name in known:
                return known[name]
            case ast.Name(id="pi"):
                return np.pi
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](self._value(left, known), self._value(right, known))
            case ast.UnaryOp(op=op, operand=one) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](self._value(one, known))
            case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](self._value(left, known), self._value(right, known))
            case ast.Call(func=ast.Name(id=name), args=given, keywords=[]) if name in _FUNCTIONS:
                try:
                    return _FUNCTIONS[name](*(self._value(one, known) for one in given))
                except (TypeError, ValueError) as error:
                    raise SceneError(
                        f"{shown(self.text)}: {name} takes other arguments."
                    ) from error
        raise SceneError(
            f"{shown(self.text)}: {ast.unparse(node)} is not known here; use "
            f"{', '.join(self.variables)}, pi, + - * / **, < > <= >=, {', '.join(_FUNCTIONS)}."
        )
