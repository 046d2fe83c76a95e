"""The crossing experiment: a robot and a pedestrian."""
