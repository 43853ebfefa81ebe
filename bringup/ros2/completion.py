"""Shell completion: a script for bash or zsh, made from the parser."""

from __future__ import annotations

import argparse

from arjuna_core.errors import ArjunaError, nearest
from bringup.ros2.grammar import build_parser, choices_of

_SHELLS = ("bash", "zsh")
LIVE = {
    "topic": "ros2 topic list",
    "node": "ros2 node list",
    "service": "ros2 service list",
    "action": "ros2 action list",
    "message_type": "ros2 interface list -m | sed 's/^ *//'",
    "interface": "ros2 interface list | sed -n 's/^ *\\(.*\\/.*\\)/\\1/p'",
    "package": "ros2 interface packages",
}
_SCRIPT = """\
{zsh}_arjuna_ros2() {{
  local cur="${{COMP_WORDS[COMP_CWORD]}}" verb="${{COMP_WORDS[1]}} ${{COMP_WORDS[2]}}"
  local words="" live=""
  if [ "$COMP_CWORD" -eq 1 ]; then
    words="{commands}"
  elif [ "$COMP_CWORD" -eq 2 ]; then
    case "${{COMP_WORDS[1]}}" in
{verbs}
    esac
  else
    case "$verb" in
{options}
    esac
    case "$cur" in
      -*) ;;
      *) [ -n "$live" ] && words="$(eval "$live" 2>/dev/null)" ;;
    esac
  fi
  COMPREPLY=($(compgen -W "$words" -- "$cur"))
}}
complete -o default -F _arjuna_ros2 ros2"""


def script(shell: str) -> str:
    """Return what a shell evaluates to complete `ros2`: `eval "$(ros2 --completion bash)"`.

    Names of the graph are asked for when the tabulator is pressed; all else stands in the script.

    Raises:
        ArjunaError: There is no script for the shell.
    """
    if shell not in _SHELLS:
        raise ArjunaError(f"no completion for '{shell}'; {nearest(shell, _SHELLS)}")
    zsh = "autoload -Uz bashcompinit && bashcompinit\n" if shell == "zsh" else ""
    commands = dict(choices_of(build_parser()))
    verbs = {name: dict(choices_of(command)) for name, command in commands.items()}
    return _SCRIPT.format(
        zsh=zsh,
        commands=" ".join(commands),
        verbs="\n".join(
            f'      {name}) words="{" ".join(found)}" ;;' for name, found in verbs.items() if found
        ),
        options="\n".join(
            f'      "{name} {verb}") {_options(parser)} ;;'
            for name, found in verbs.items()
            for verb, parser in found.items()
        ),
    )


def _options(parser: argparse.ArgumentParser) -> str:
    _help, *actions = parser._actions
    flags = [name for one in actions for name in one.option_strings if name.startswith("--")]
    live = next((LIVE[name] for one in actions if (name := getattr(one, "complete", ""))), "")
    return f'words="{" ".join([*flags, "--help"])}"; live="{live}"'
