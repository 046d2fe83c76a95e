"""Figures of an attack graph: the graph, the learned weights, one trajectory."""
