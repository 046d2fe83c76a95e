"""Figures of metrics over iterations."""
