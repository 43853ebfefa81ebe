"""Parameter files that others wrote for Nav2, slam_toolbox and AMCL, as our nodes' parameters."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from arjuna_core.config import flatten, infos
from arjuna_core.errors import closest
from arjuna_core.plugins import PluginTypes, canonical, config_class_for
from bringup.parameters.files import EVERY_NODE, SIM_TIME, Parameters, merged
from bringup.parameters.foreign import nav2
from bringup.parameters.foreign.plugins import ForeignPlugins, plugin_lists
from bringup.parameters.foreign.ros1_names import TABLES, targets
from bringup.parameters.foreign.sections import FILLED, of_program, sections_by_node
from bringup.parameters.remarks import Checked, Kind, Remark
from bringup.parameters.sources import OUTLINE, keys_of_robot
from bringup.stack import PROGRAMS, NodeSpec

_KEYWORD = re.compile(r"[A-Z][A-Z0-9]*_[A-Z0-9_]+")
_CLASS_KEYS = ("plugin", "robot_model_type")
_SOURCES = "observation_sources"
_BLIND_ZONES = f"without {_SOURCES} its zones see nothing; Nav2 would not start"
_BLIND = f"without {_SOURCES} it sees no obstacles, in Nav2 neither"


def understand(
    given: Parameters,
    below: Parameters,
    specs: Iterable[NodeSpec],
    namespace: str = "",
    base: Parameters | None = None,
) -> Checked:
    """Return what a file's parameters mean here, over those that hold already.

    A section that names a class of Nav2's, or what its node is made of, is whole: what it leaves
    out takes Nav2's default, but for what is the robot's own. Any other changes what is below it,
    and so does one of a node that an earlier file has changed, as ROS 2 merges files.

    Args:
        given: The file's parameters; those of `/**` go to each node that has them.
        below: What holds already; of plug-ins that the file replaces nothing is kept.
        base: What held before all files; none: what is below.
    """
    nodes = {spec.name: spec for spec in specs}
    sections, remarks = sections_by_node(given, nodes, namespace)
    everywhere = given.get(EVERY_NODE, {})
    shared = {key: value for key, value in everywhere.items() if key != SIM_TIME}
    result, problems, taken = merged(below), list[str](), set[str]()
    for name in nodes if shared else sections:
        held, own = result.get(name, {}), sections.get(name, {})
        changed = base is not None and held != base.get(name, {})
        section = _Section(nodes[name], own, held, shared, changed)
        result[name] = section.values
        remarks += section.remarks
        problems += section.problems
        taken.update(section.taken)
    if SIM_TIME in everywhere:
        result.setdefault(EVERY_NODE, {})[SIM_TIME] = everywhere[SIM_TIME]
    unused = {key: value for key, value in shared.items() if key not in taken}
    return Checked(result, remarks + _of_no_node(unused, list(nodes.values())), problems)


def _of_no_node(unused: dict[str, Any], specs: Sequence[NodeSpec]) -> list[Remark]:
    """Return remarks on names below `/**`, which may all be of one program that runs alone."""
    if not unused:
        return []
    own = {program: _chosen_keys(spec.config, unused) for program, spec in PROGRAMS.items()}
    program = max(own, key=lambda one: len(own[one]))
    return [
        of_program(f"{EVERY_NODE}: {key}", program) if key in own[program] else _of_key(key, specs)
        for key in unused
    ]


def _chosen_keys(config: type[Any], values: dict[str, Any]) -> set[str]:
    """Return the names that a node has, but for those whose values are none of its choices."""
    known = infos(config_class_for(config, dict(values), "", []))
    others = {key for key, info in known.items() if info.choices and key in values}
    others = {key for key in others if values[key] not in known[key].choices}
    return (values.keys() & _own_keys(config, values).keys()) - others


def _of_key(key: str, specs: Sequence[NodeSpec]) -> Remark:
    for spec in specs:
        if (known := nav2.of_key(spec.name, key)) is not None:
            return Remark(known[0], f"{EVERY_NODE}: {key}", known[1])
    valid = {name for spec in specs for name in _own_keys(spec.config, {})}
    return Remark(Kind.UNKNOWN, f"{EVERY_NODE}: {key}", f"no node has it{closest(key, valid)}")


class _Section:
    """One node's section of a file, as that node's parameters.

    Attributes:
        taken: The names of `shared` that the node has.
    """

    def __init__(
        self,
        spec: NodeSpec,
        given: Mapping[str, Any],
        below: dict[str, Any],
        shared: Mapping[str, Any],
        is_changed: bool,
    ) -> None:
        self._node, self._config = spec.name, spec.config
        self.remarks: list[Remark] = []
        self.problems: list[str] = []
        self._foreign = ForeignPlugins(spec.name)
        if not is_changed and _is_whole(spec.name, given):
            robot = keys_of_robot(spec, below)
            if not given.keys() & {*OUTLINE}:
                robot |= {"footprint_padding"}  # a part of the shipped outline
            below = {key: value for key, value in below.items() if key in robot}
        values = nav2.as_today(spec.name, given)
        sim_time = values.pop(SIM_TIME, below.get(SIM_TIME))
        whole = merged({"": below}, {"": {**shared, **values}})[""]
        self._foreign.take(self._config, whole)
        self.remarks += self._foreign.remarks
        values |= self._foreign.changed
        own = _own_keys(self._config, {**whole, **values})
        self.taken = [key for key in shared if key in own or self._is_left_out(key)]
        kept = {key: value for key, value in values.items() if self._has_effect(key, value, own)}
        mine = {key: shared[key] for key in self.taken if key in own}
        whole = merged({"": below}, {"": {**mine, **kept}})[""]
        self.values = {key: v for key, v in whole.items() if key in own or key in kept}
        for key, value, reason in nav2.as_started(spec.name, {**own, **self.values}):
            self.values[key] = value
            safety = nav2.is_safety(spec.name, key)
            self.remarks.append(Remark(Kind.UNKNOWN, f"{spec.name}: {key}", reason, safety))
        if sim_time is not None:
            self.values[SIM_TIME] = sim_time
        self.remarks += self._on_what_is_blind(given, own)

    def _on_what_is_blind(self, given: Mapping[str, Any], own: Mapping[str, Any]) -> list[Remark]:
        """Return remarks on layers, and on zones of a monitor, that the file gives no sources."""
        remarks = []
        if self.values.get("polygons") and not self.values.get(_SOURCES) and _SOURCES in own:
            where = f"{self._node}: polygons"
            remarks.append(Remark(Kind.NO_EFFECT, where, _BLIND_ZONES, safety=True))
        for key in own if self._node in nav2.COSTMAPS else ():
            layer, _, last = key.rpartition(".")
            named = any(name.startswith(f"{layer}.") for name in given)
            named |= layer in (given.get("plugins") or ())
            if last == _SOURCES and layer and named and not self.values.get(key, own[key]):
                where = f"{self._node}: {layer}"
                remarks.append(Remark(Kind.NO_EFFECT, where, _BLIND, safety=True))
        return remarks

    def _has_effect(self, key: str, value: Any, own: Mapping[str, Any]) -> bool:
        """Return whether a name and its value have an effect here; remark on it if not."""
        node = self._node
        if self._is_left_out(key):
            return False
        if _is_below(key, self._foreign.replaced) and not _is_like(value, own.get(key)):
            return False
        known = nav2.of_value(node, key, value)
        of_text = isinstance(own.get(key, ""), (str, type(None)))
        if isinstance(value, str) and not of_text and _KEYWORD.fullmatch(value):
            known = Kind.NO_EFFECT, FILLED.format(value)
        if known is None and key in own:
            return True
        known = known or self._of_no_list(key, own) or nav2.of_key(node, key)
        known = known or self._of_another_plugin(key)
        known = known or _of_ros1(node, key)
        last = key.rpartition(".")[2]
        hint = f"; '{last}' stands higher up" if last != key and last in own else closest(key, own)
        kind, reason = known or (Kind.UNKNOWN, f"no such parameter{hint}")
        safety = kind is Kind.NO_EFFECT and nav2.is_safety(node, key)
        self.remarks.append(Remark(kind, f"{node}: {key}", reason, safety))
        return False

    def _is_left_out(self, key: str) -> bool:
        return _is_below(key, self._foreign.left_out)

    def _of_no_list(self, key: str, own: Mapping[str, Any]) -> tuple[Kind, str] | None:
        """Return why a name has no effect that is of a plug-in or source which no list names."""
        plugin, dot, rest = key.partition(".")
        if dot and any(name.startswith(f"{plugin}.") for name in own):
            sources, (source, dot, _) = f"{plugin}.{_SOURCES}", rest.partition(".")
            listed = any(name.startswith(f"{plugin}.{source}.") for name in own)
            if not dot or listed or sources not in own:
                return None
            return Kind.NOT_NEEDED, f"'{source}' is not in '{sources}'"
        if not dot:
            return None
        if all(one.is_class for one in plugin_lists(self._config, {})):
            return None
        return Kind.NOT_NEEDED, f"'{plugin}' is in no list of plug-ins"

    def _of_another_plugin(self, key: str) -> tuple[Kind, str] | None:
        """Return why a name has no effect that is left over of another plug-in."""
        plugin, dot, rest = key.partition(".")
        for listed in plugin_lists(self._config, {}) if dot else ():
            for cls in () if listed.is_class else listed.kind.types:
                if rest in _keys_of(listed.kind, cls):
                    return Kind.NOT_NEEDED, f"a parameter of {cls}, which '{plugin}' is not"
        return None


def _of_ros1(node: str, key: str) -> tuple[Kind, str] | None:
    """Return what a node's name of ROS 1 is here; None where it is none."""
    ours = targets(node).get(key) if node in TABLES else None
    if ours is None:
        return None
    names = ", ".join(f"'{name}'" for _, name in ours)
    return (Kind.UNKNOWN, f"ROS 1's name of {names}") if names else (Kind.NOT_NEEDED, "of ROS 1")


def _is_below(key: str, names: Iterable[str]) -> bool:
    """Return whether a dotted name is one of some names, or below one."""
    return any(key == name or key.startswith(f"{name}.") for name in names)


def _is_like(value: Any, ours: Any) -> bool:
    """Return whether a value of someone's class is of the kind of the one of ours."""
    kinds = (bool, (int, float), str, (list, tuple))
    kind = next((one for one in kinds if isinstance(ours, one)), ())
    return isinstance(value, kind) and isinstance(value, bool) == isinstance(ours, bool)


def _is_whole(node: str, given: Mapping[str, Any]) -> bool:
    """Return whether a section names what its node is made of, as whole configurations do."""
    classes = (value for key, value in given.items() if key.endswith(_CLASS_KEYS))
    named = any(isinstance(value, str) and "::" in canonical(value) for value in classes)
    return named or not nav2.made_of(node).isdisjoint(given)


@cache
def _keys_of(kind: PluginTypes, cls: str) -> frozenset[str]:
    """Return the parameters of a class of plug-ins; one that wraps another has the other's too."""
    return frozenset(infos(kind.config_of(cls, {"primary_controller": kind.default})))


def _own_keys(config: type[Any], values: dict[str, Any]) -> dict[str, Any]:
    """Return the keys that a node has, given its values, each with its default.

    Those below a plug-in of no known class count: the node's own check speaks of the class.
    """
    unused = dict(values)
    return {
        **flatten(config_class_for(config, unused, "", [])()),
        **dict.fromkeys(values.keys() - unused.keys()),
    }
