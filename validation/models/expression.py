"""Arithmetic on numbers and variables, as in `1.4e-5 * (1 + q) / q` and `0.2 m * q`.

    sum     = product { ("+" | "-") product }
    product = factor { ("*" | "/") factor }
    factor  = ("+" | "-") factor | power
    power   = value [ "**" factor ]
    value   = number [ unit ] | variable | function "(" sum ")" | "(" sum ")"

Functions: sqrt, exp, log (natural), log10. All numbers are floats. A number with a unit becomes one in SI; it may be multiplied
by pure numbers and divided by its like, and is added to its like alone. Text is read, never run.
"""

import math
import operator
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TypeAlias

from slipwave.errors import SceneError
from slipwave.input.quantity import KINDS, quantity
from slipwave.input.wording import shorten

FUNCTIONS: Mapping[str, Callable[[float], float]] = {"sqrt": math.sqrt, "exp": math.exp, "log": math.log, "log10": math.log10}

_TOKEN = re.compile(r"\s*((?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|(?P<word>[^\W\d]\w*[²³]?)|\*\*|\S)")
_LONGEST = 1000  # characters
_DEEPEST = 50  # parentheses, signs and powers in each other


class Undefined(SceneError):
    """An expression that has no value for these variables, as a division by 0."""


Value: TypeAlias = tuple[float, str]
"""A number and its SI unit (empty: a pure number)."""


def value_at(text: str, variables: Mapping[str, Value]) -> Value:
    """The value of an expression. Raises SceneError, with the reason alone, for text that is none, and Undefined where it has no
    finite value."""
    return _Reader(text, variables).whole()


@lru_cache(maxsize=256)
def _tokens(text: str) -> tuple[tuple[str, str], ...]:
    """Kind (number, word, or empty) and text of each token."""
    return tuple(("number" if token["number"] else "word" if token["word"] else "", token[1]) for token in _TOKEN.finditer(text))


class _Reader:
    """Reads an expression from left to right; what has no value is NaN, with the first reason in `fault`, so that a text that is
    none is refused whatever the variables are."""

    def __init__(self, text: str, variables: Mapping[str, Value]) -> None:
        if len(text) > _LONGEST:
            raise SceneError(f"is longer than {_LONGEST} characters")
        self._tokens, self._at, self._depth, self._fault = _tokens(text), 0, 0, ""
        self._variables = variables

    def whole(self) -> Value:
        """The value of the text."""
        number, unit = self._sum()
        if self._next()[1]:
            raise SceneError(f"unexpected {shorten(self._next()[1])}")
        if self._fault or not math.isfinite(number):
            raise Undefined(self._fault or "is too large")
        return number, unit

    def _next(self, ahead: int = 0) -> tuple[str, str]:
        return self._tokens[self._at + ahead] if self._at + ahead < len(self._tokens) else ("", "")

    def _took(self, *signs: str) -> str:
        """The next token, taken if it is one of `signs`; else empty."""
        kind, token = self._next()
        if kind or token not in signs:
            return ""
        self._at += 1
        return token

    def _sum(self) -> Value:
        number, unit = self._product()
        while sign := self._took("+", "-"):
            other, of_other = self._product()
            if unit != of_other:
                raise SceneError(f"{_said(unit)} and {_said(of_other)} cannot be added")
            number += other if sign == "+" else -other
        return number, unit

    def _product(self) -> Value:
        number, unit = self._factor()
        while sign := self._took("*", "/"):
            other, of_other = self._factor()
            is_ratio = sign == "/" and unit == of_other
            if of_other and not is_ratio and (unit or sign == "/"):
                raise SceneError(f"{_said(unit)} cannot be {'multiplied' if sign == '*' else 'divided'} by {_said(of_other)}")
            number = self._finite(operator.mul if sign == "*" else operator.truediv, number, other)
            unit = "" if is_ratio else unit or of_other
        return number, unit

    def _factor(self) -> Value:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise SceneError(f"is nested more than {_DEEPEST} deep")
        sign = self._took("+", "-")
        value = self._factor() if sign else self._value()
        if sign == "-":
            value = -value[0], value[1]
        elif not sign and self._took("**"):
            power = self._pure(self._factor(), "an exponent")
            value = self._finite(math.pow, self._pure(value, "the base of a power"), power), ""
        self._depth -= 1
        return value

    def _value(self) -> Value:
        kind, token = self._next()
        if self._took("("):
            return self._closed()
        self._at += bool(kind)
        if kind == "number":
            return self._with_unit(token)
        if kind and token in FUNCTIONS and self._took("("):
            return self._finite(FUNCTIONS[token], self._pure(self._closed(), f"the argument of {token}")), ""
        if kind and token in self._variables:
            return self._variables[token]
        if kind and self._next()[1] == "(":
            raise SceneError(f"{shorten(token)} is no function; there are {', '.join(FUNCTIONS)}")
        if kind:
            raise SceneError(f"{shorten(token)} is no variable; there are {', '.join(self._variables)}")
        raise SceneError(f"unexpected {shorten(token)}" if token else "ends too early")

    def _closed(self) -> Value:
        """The sum up to a closing parenthesis."""
        value = self._sum()
        if not self._took(")"):
            raise SceneError("a parenthesis is not closed")
        return value

    def _with_unit(self, number: str) -> Value:
        """The number with the unit that follows it, if any: words that are no variables, with blanks or / between them."""
        unit = ""
        while True:
            slash = self._next() == ("", "/")
            kind, word = self._next(slash)
            if kind != "word" or word in self._variables or word in FUNCTIONS:
                break
            unit += f"/{word}" if slash else f" {word}"
            self._at += 1 + slash
        if not unit:
            return float(number), ""
        try:
            given = quantity(f"{number} {unit}", *KINDS)
        except ValueError:
            raise SceneError(f"{shorten(unit.strip())} is neither a variable nor a unit of a scene") from None
        return given.value, given.unit

    def _pure(self, value: Value, what: str) -> float:
        number, unit = value
        if unit:
            raise SceneError(f"{what} must be a pure number, not {_said(unit)}")
        return number

    def _finite(self, function: Callable[..., float], *numbers: float) -> float:
        """The value of `function`; NaN, with its reason kept, where there is none."""
        try:
            return function(*numbers)
        except ZeroDivisionError:
            fault = "division by zero"
        except OverflowError:
            fault = "is too large"
        except ValueError:
            fault = "a root, logarithm or power has no real value"
        self._fault = self._fault or fault
        return math.nan


def _said(unit: str) -> str:
    return f"a number in {unit}" if unit else "a pure number"
