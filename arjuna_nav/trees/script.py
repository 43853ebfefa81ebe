"""Scripts of behavior trees: expressions and assignments on the blackboard's entries.

`code := 0; tries += 1`, `battery > 20 && mode != 'idle' ? 1 : 2`. The tighter an operator binds,
the later it stands here: `?:`, `||`, `&&`, `== != < <= > >=` (which chain), `| ^`, `&`, `+ - ..`,
`* /`, and the signs `! - ~`. `:=` makes an entry, `=` changes one that is there.

Source: BehaviorTree.CPP 4, its scripting language.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable
from typing import Any

from arjuna_nav.trees.blackboard import Blackboard, TreeError

Value = bool | float | str
Code = Callable[[Blackboard], Any]

_TOKEN = re.compile(
    r"\s*(?:(0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|'([^']*)'|(@?[A-Za-z_]\w*)"
    r"|(\|\||&&|==|!=|<=|>=|:=|\+=|-=|\*=|/=|\.\.|[-+*/<>=!~&|^?:();]))"
)


def _numbers(function: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    return lambda a, b: function(_number(a), _number(b))


def _bits(function: Callable[[int, int], int]) -> Callable[[Any, Any], float]:
    return lambda a, b: function(int(_number(a)), int(_number(b)))


def _number(value: Any) -> float:
    """Return a value as a number; texts are read, as SetBlackboard writes texts."""
    try:
        return value if isinstance(value, (bool, int, float)) else float(value)
    except (TypeError, ValueError) as error:
        raise TreeError(f"'{value}' is no number") from error


def _truth(value: Any) -> bool:
    if isinstance(value, str) and value.lower() in ("true", "false"):
        return value.lower() == "true"
    return bool(_number(value))


def _add(a: Any, b: Any) -> Any:
    both_texts = isinstance(a, str) and isinstance(b, str)
    return a + b if both_texts else _number(a) + _number(b)


def _equal(a: Any, b: Any) -> bool:
    return bool(a == b if isinstance(a, str) == isinstance(b, str) else _number(a) == _number(b))


_COMPARED: dict[str, Callable[[Any, Any], Any]] = {
    "==": _equal,
    "!=": lambda a, b: not _equal(a, b),
    "<": _numbers(operator.lt),
    "<=": _numbers(operator.le),
    ">": _numbers(operator.gt),
    ">=": _numbers(operator.ge),
}
_LEVELS: tuple[dict[str, Callable[[Any, Any], Any]], ...] = (
    {"|": _bits(operator.or_), "^": _bits(operator.xor)},
    {"&": _bits(operator.and_)},
    {"+": _add, "-": _numbers(operator.sub), "..": lambda a, b: f"{a}{b}"},
    {"*": _numbers(operator.mul), "/": _numbers(operator.truediv)},
)
_SIGNS: dict[str, Callable[[Any], Any]] = {
    "-": lambda value: -_number(value),
    "!": lambda value: not _truth(value),
    "~": lambda value: ~int(_number(value)),
}
_CHANGES = {
    "+=": _add,
    "-=": _numbers(operator.sub),
    "*=": _numbers(operator.mul),
    "/=": _numbers(operator.truediv),
}


class Script:
    """A script that can be run again and again.

    Args:
        text: One statement or several with `;` between them.

    Raises:
        TreeError: It is none.
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
            if match is None:
                raise self._error(text[at:].strip())
            kind = ("number", "text", "name", "sign")[(match.lastindex or 1) - 1]
            self._tokens.append((kind, match.group(match.lastindex or 1)))
            at = match.end()
        self._at = 0

    def _error(self, found: str) -> TreeError:
        shown = f"unexpected '{found}'" if found else "it ends too early"
        return TreeError(f"script '{self._text}': {shown}")

    def _next(self) -> str:
        """Return the sign that comes next, empty where none does."""
        ahead = self._tokens[self._at] if self._at < len(self._tokens) else ("", "")
        return ahead[1] if ahead[0] == "sign" else ""

    def _take(self, *signs: str) -> str:
        """Return one of the signs where it comes next, and step behind it; else empty."""
        found = self._next()
        if found not in signs:
            return ""
        self._at += 1
        return found

    def _need(self, sign: str) -> None:
        if not self._take(sign):
            raise self._error(" ".join(value for _, value in self._tokens[self._at :][:1]))

    def statements(self) -> list[Code]:
        found = [self._statement()]
        while self._take(";"):
            if self._at < len(self._tokens):
                found.append(self._statement())
        if self._at < len(self._tokens):
            raise self._error(self._tokens[self._at][1])
        return found

    def _statement(self) -> Code:
        begins_with_name = self._at < len(self._tokens) and self._tokens[self._at][0] == "name"
        name = self._tokens[self._at][1] if begins_with_name else ""
        self._at += begins_with_name
        sign = self._take(":=", "=", *_CHANGES) if begins_with_name else ""
        if not sign:
            self._at -= begins_with_name
            return self._expression()
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
        condition = self._either()
        if not self._take("?"):
            return condition
        yes = self._expression()
        self._need(":")
        no = self._expression()
        return lambda board: yes(board) if _truth(condition(board)) else no(board)

    def _either(self) -> Code:
        return self._joined("||", self._both, any)

    def _both(self) -> Code:
        return self._joined("&&", self._comparison, all)

    def _joined(
        self, sign: str, read: Callable[[], Code], join: Callable[[Iterable[bool]], bool]
    ) -> Code:
        parts = [read()]
        while self._take(sign):
            parts.append(read())
        if len(parts) == 1:
            return parts[0]
        return lambda board: join(_truth(part(board)) for part in parts)

    def _comparison(self) -> Code:
        parts, compared = [self._binary(0)], []
        while sign := self._take(*_COMPARED):
            compared.append(_COMPARED[sign])
            parts.append(self._binary(0))
        if not compared:
            return parts[0]

        def compare(board: Blackboard) -> bool:
            values = [part(board) for part in parts]
            return all(f(a, b) for f, a, b in zip(compared, values, values[1:], strict=False))

        return compare

    def _binary(self, level: int) -> Code:
        if level == len(_LEVELS):
            return self._signed()
        left = self._binary(level + 1)
        while sign := self._take(*_LEVELS[level]):
            left = _applied(_LEVELS[level][sign], left, self._binary(level + 1))
        return left

    def _signed(self) -> Code:
        sign = self._take(*_SIGNS)
        if sign:
            function, operand = _SIGNS[sign], self._signed()
            return lambda board: function(operand(board))
        if self._take("("):
            inner = self._expression()
            self._need(")")
            return inner
        kind, word = self._tokens[self._at] if self._at < len(self._tokens) else ("", "")
        if kind in ("", "sign"):
            raise self._error(word)
        self._at += 1
        if kind == "name" and word not in ("true", "false"):
            return lambda board: _read(board, word)
        value = _constant(kind, word)
        return lambda board: value


def _constant(kind: str, word: str) -> Value:
    """Return a literal's value; a number without point or exponent is whole."""
    if kind == "number":
        whole = word.isdigit() or word[:2] in ("0x", "0X")
        return int(word, 16 if word[:2] in ("0x", "0X") else 10) if whole else float(word)
    return word if kind == "text" else word == "true"


def _applied(function: Callable[[Any, Any], Any], left: Code, right: Code) -> Code:
    return lambda board: function(left(board), right(board))


def _read(board: Blackboard, name: str) -> Any:
    value = board.get(name)
    if value is None:
        raise TreeError(f"{name} is not on the blackboard")
    return value
