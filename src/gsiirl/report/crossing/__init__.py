"""Figures of the crossing: an encounter, rates, the map of the human's reward."""
