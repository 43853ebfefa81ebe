"""Behavior trees: BehaviorTree.CPP's XML with Nav2's nodes, run a tick at a time."""
