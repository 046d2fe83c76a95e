"""The style of all figures, and figures as files: PNG, SVG and GIF."""
