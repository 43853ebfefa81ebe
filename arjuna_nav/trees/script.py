"""Scripts of behavior trees: expressions and assignments on the blackboard's entries.

`code := 0; tries += 1`, `battery > 20 && mode != 'idle' ? 1 : 2`. The tighter an operator binds,
the later it stands here: `?:`, `||`, `&&`, `== != < <= > >=` (which chain), `| ^`, `&`, `+ - ..`,
`* /`, and the signs `! - ~`. `:=` makes an entry, `=` changes one that is there.

Source: BehaviorTree.CPP 4, its scripting language; Pratt, Top down operator precedence, 1973.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from itertools import pairwise
from typing import Any

from arjuna_nav.trees.blackboard import Blackboard, TreeError

Code = Callable[[Blackboard], Any]
_Function = Callable[[Any, Any], Any]

_TOKEN = re.compile(
    r"\s*(?:(?P<number>0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|'(?P<text>[^']*)'"
    r"|(?P<name>@?[A-Za-z_]\w*)"
    r"|(?P<sign>\|\||&&|==|!=|<=|>=|:=|\+=|-=|\*=|/=|\.\.|[-+*/<>=!~&|^?:();]))"
)


def _number(value: Any) -> float:
    """Return a value as a number; texts are read, as SetBlackboard writes texts."""
    try:
        return value if isinstance(value, (bool, int, float)) else float(value)
    except (TypeError, ValueError) as error:
        raise TreeError(f"'{value}' is no number") from error


def _truth(value: Any) -> bool:
    is_word = isinstance(value, str) and value.lower() in ("true", "false")
    return value.lower() == "true" if is_word else bool(_number(value))


def _numbers(function: _Function) -> _Function:
    return lambda a, b: function(_number(a), _number(b))


def _bits(function: _Function) -> _Function:
    return lambda a, b: function(int(_number(a)), int(_number(b)))


def _add(a: Any, b: Any) -> Any:
    both_texts = isinstance(a, str) and isinstance(b, str)
    return a + b if both_texts else _number(a) + _number(b)


def _equal(a: Any, b: Any) -> bool:
    return bool(a == b if isinstance(a, str) == isinstance(b, str) else _number(a) == _number(b))


_OR, _AND, _COMPARISON = 1, 2, 3
_ARITHMETIC: dict[str, tuple[int, _Function]] = {
    "|": (4, _bits(operator.or_)),
    "^": (4, _bits(operator.xor)),
    "&": (5, _bits(operator.and_)),
    "+": (6, _add),
    "-": (6, _numbers(operator.sub)),
    "..": (6, lambda a, b: f"{a}{b}"),
    "*": (7, _numbers(operator.mul)),
    "/": (7, _numbers(operator.truediv)),
}
_COMPARED: dict[str, _Function] = {
    "==": _equal,
    "!=": lambda a, b: not _equal(a, b),
    "<": _numbers(operator.lt),
    "<=": _numbers(operator.le),
    ">": _numbers(operator.gt),
    ">=": _numbers(operator.ge),
}
_POWERS = {
    "||": _OR,
    "&&": _AND,
    **dict.fromkeys(_COMPARED, _COMPARISON),
    **{sign: power for sign, (power, _) in _ARITHMETIC.items()},
}
_SIGNS: dict[str, Callable[[Any], Any]] = {
    "-": lambda value: -_number(value),
    "!": lambda value: not _truth(value),
    "~": lambda value: ~int(_number(value)),
}
_CHANGES = {f"{sign}=": _ARITHMETIC[sign][1] for sign in "+-*/"}


class Script:
    """Statements with `;` between them, that can be run again and again.

    Raises:
        TreeError: The text is none.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._code = _Parser(text).statements()

    def run(self, board: Blackboard) -> Any:
        """Return the value of the last statement.

        Raises:
            TreeError: An entry is not there, or a value is of the wrong kind.
        """
        value: Any = None
        try:
            for code in self._code:
                value = code(board)
        except (TreeError, ArithmeticError) as error:
            raise TreeError(f"script '{self.text}': {error}") from error
        return value

    def holds(self, board: Blackboard) -> bool:
        """Return whether the last statement's value is true."""
        return _truth(self.run(board))


class _Parser:
    """Reads one script from left to right into functions of a blackboard."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens: list[tuple[str, str]] = []
        at, end = 0, len(text.rstrip())
        while at < end:
            match = _TOKEN.match(text, at)
            if match is None or match.lastgroup is None:
                raise self._error(text[at:].strip())
            self._tokens.append((match.lastgroup, match.group(match.lastgroup)))
            at = match.end()
        self._tokens.append(("end", ""))
        self._at = 0

    def _error(self, found: str) -> TreeError:
        problem = f"unexpected '{found}'" if found else "it ends too early"
        return TreeError(f"script '{self._text}': {problem}")

    def _take(self, *signs: str) -> str:
        """Return one of the signs where it comes next, and step behind it; else empty."""
        kind, word = self._tokens[self._at]
        if kind != "sign" or word not in signs:
            return ""
        self._at += 1
        return word

    def _need(self, sign: str) -> None:
        if not self._take(sign):
            raise self._error(self._tokens[self._at][1])

    def statements(self) -> list[Code]:
        """Return the script's statements."""
        found = [self._statement()]
        while self._take(";"):
            if self._tokens[self._at][0] != "end":
                found.append(self._statement())
        kind, word = self._tokens[self._at]
        if kind != "end":
            raise self._error(word)
        return found

    def _statement(self) -> Code:
        (kind, name), ahead = self._tokens[self._at], self._tokens[self._at + 1 :][:1]
        if kind != "name" or ahead[0][1] not in (":=", "=", *_CHANGES):
            return self._expression()
        self._at += 1
        sign = self._take(":=", "=", *_CHANGES)
        value = self._expression()

        def assign(board: Blackboard) -> Any:
            found = value(board)
            if sign != ":=":
                present = _read(board, name)
                found = _CHANGES[sign](present, found) if sign in _CHANGES else found
            board.set(name, found)
            return found

        return assign

    def _expression(self) -> Code:
        condition = self._operation(0)
        if not self._take("?"):
            return condition
        yes = self._expression()
        self._need(":")
        no = self._expression()
        return lambda board: yes(board) if _truth(condition(board)) else no(board)

    def _operation(self, least: int) -> Code:
        """Read operands as long as the operators between them bind tighter than the least."""
        left = self._operand()
        while (power := self._power()) > least:
            parts, signs = [left], []
            while self._power() == power:
                signs.append(self._take(*_POWERS))
                parts.append(self._operation(power))
            left = _joined(power, parts, signs)
        return left

    def _power(self) -> int:
        kind, word = self._tokens[self._at]
        return _POWERS.get(word, 0) if kind == "sign" else 0

    def _operand(self) -> Code:
        sign = self._take(*_SIGNS)
        if sign:
            function, operand = _SIGNS[sign], self._operand()
            return lambda board: function(operand(board))
        if self._take("("):
            inner = self._expression()
            self._need(")")
            return inner
        kind, word = self._tokens[self._at]
        if kind in ("end", "sign"):
            raise self._error(word)
        self._at += 1
        if kind == "name" and word not in ("true", "false"):
            return lambda board: _read(board, word)
        value = _constant(kind, word)
        return lambda board: value


def _joined(power: int, parts: list[Code], signs: list[str]) -> Code:
    """Return the code of operands with operators of one power between them."""
    if power in (_OR, _AND):
        join = any if power == _OR else all
        return lambda board: join(_truth(part(board)) for part in parts)

    def compare(board: Blackboard) -> bool:
        pairs = pairwise(part(board) for part in parts)
        return all(_COMPARED[sign](a, b) for sign, (a, b) in zip(signs, pairs, strict=True))

    def compute(board: Blackboard) -> Any:
        value = parts[0](board)
        for sign, part in zip(signs, parts[1:], strict=True):
            value = _ARITHMETIC[sign][1](value, part(board))
        return value

    return compare if power == _COMPARISON else compute


def _constant(kind: str, word: str) -> bool | float | str:
    """Return a literal's value; a number without point or exponent is whole."""
    if kind == "number":
        is_hex = word[:2] in ("0x", "0X")
        return int(word, 16 if is_hex else 10) if is_hex or word.isdigit() else float(word)
    return word if kind == "text" else word == "true"


def _read(board: Blackboard, name: str) -> Any:
    value = board.get(name)
    if value is None:
        raise TreeError(f"{name} is not on the blackboard")
    return value
