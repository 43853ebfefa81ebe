"""Shell completion: a script for bash or zsh, made from the tables."""

from __future__ import annotations

from arjuna_core.errors import ArjunaError, nearest
from bringup.ros2.grammar import GRAPH, Argument, Command, Verb
from bringup.ros2.tables import COMMANDS

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
    verbs = [
        f'      {command.name}) words="{" ".join(verb.name for verb in command.verbs)}" ;;'
        for command in COMMANDS
        if command.verbs
    ]
    options = [_options(command, verb) for command in COMMANDS for verb in command.verbs]
    return _SCRIPT.format(
        zsh=zsh,
        commands=" ".join(command.name for command in COMMANDS),
        verbs="\n".join(verbs),
        options="\n".join(options),
    )


def _options(command: Command, verb: Verb) -> str:
    flat: list[Argument] = []
    for item in verb.arguments + (GRAPH if command.graph else ()):
        flat.extend([item] if isinstance(item, Argument) else item)
    flags = [name for item in flat for name in item.names if name.startswith("--")]
    live = next((LIVE[item.complete] for item in flat if item.complete), "")
    words = " ".join([*flags, "--help"])
    return f'      "{command.name} {verb.name}") words="{words}"; live="{live}" ;;'
