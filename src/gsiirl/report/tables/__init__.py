"""Tables of returns and of other metrics, beside the figures that the paper prints."""
